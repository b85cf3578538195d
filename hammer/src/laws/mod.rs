//! The laws: force, stored energy, guards and transition of each in a file of its own.

pub mod chambers;
pub(crate) mod contact;
pub mod drive;
pub mod event;
pub mod mode;
pub mod rock;
