//! The FMU as its hosts see it.

pub mod host;
pub mod library;
pub mod three;
