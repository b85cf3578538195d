//! Properties that every scene has, checked in monitored runs.

pub mod monitor;
pub mod properties;
