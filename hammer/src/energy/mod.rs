//! Works, losses, what is stored and the largest forces: of the intervals between events, computed when they are read.

pub mod deferred;
pub mod interval;
pub mod ledger;
pub mod peaks;
mod powers;
pub mod sums;
