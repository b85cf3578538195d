//! The FMU as hosts see it.

pub mod host;
pub mod library;
pub mod three;
