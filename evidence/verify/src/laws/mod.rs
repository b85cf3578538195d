//! What every scene keeps, driven under watch.

pub mod monitor;
pub mod properties;
