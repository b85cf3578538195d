//! Down-the-hole percussive drilling: physics and exact event-driven integration.

pub mod error;
pub mod mode;
pub mod observe;
pub mod parameters;
