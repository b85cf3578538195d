//! Works, losses and what is stored: integrals over the stretches between events, made when they are read.

pub mod deferred;
pub mod ledger;
pub mod pending;
mod powers;
pub mod sums;
