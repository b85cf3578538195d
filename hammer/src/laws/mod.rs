//! The laws, one file each: force, stored energy, guards and transition.

pub mod air;
pub mod drive;
pub mod event;
pub mod mode;
pub mod rock;
pub mod tie;
