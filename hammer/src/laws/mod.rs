//! The laws of the model. Each has one file with its force, stored energy, guards and transitions.

pub mod air;
pub mod drive;
pub mod event;
pub mod mode;
pub mod rock;
pub mod tie;
