//! What every scene keeps, and the hard cases: driven under watch.

pub mod hard;
pub mod monitor;
pub mod properties;
