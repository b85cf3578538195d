//! Works, losses, stored energies and largest forces. They are computed for the intervals between events, when they are
//! read.

pub mod deferred;
pub mod interval;
pub mod ledger;
mod modes;
pub mod peaks;
mod rigid;
