//! Down-the-hole percussive drilling: physics and exact event-driven integration.

/// Highest derivative of an input that is taken.
pub const MAX_INPUT_ORDER: usize = 4;

pub mod bar;
pub mod error;
pub mod kernel;
pub mod mode;
pub mod observe;
pub mod parameters;
pub mod poly;
pub mod spectrum;
pub mod system;
