//! The first crossing of a guard, for certain.

pub mod barrier;
pub mod guard;
pub(crate) mod window;
