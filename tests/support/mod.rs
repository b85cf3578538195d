//! The FMU as its hosts see it.

pub mod host;
pub mod library;
