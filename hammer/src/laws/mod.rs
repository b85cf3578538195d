//! The laws, one file each: force, stored energy, guards and transition.

pub mod air;
pub mod chambers;
pub(crate) mod chuck;
pub(crate) mod contact;
pub mod drive;
pub mod event;
pub(crate) mod joint;
pub mod mode;
pub mod rock;
