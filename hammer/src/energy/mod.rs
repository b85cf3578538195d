//! Works, losses, stored energies and largest forces, integrated over the intervals between events when they are
//! read.

pub mod deferred;
pub mod interval;
pub mod ledger;
pub mod peaks;
