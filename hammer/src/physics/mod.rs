//! The laws: bodies, contact, drive, rock; what a scene is made of; what ends a mode.
//!
//! ```text
//! M v' + C v + K u = f_drive + f_contact + f_rock + dead loads,    u' = v
//! ```
//!
//! Each law has its force, stored energy, guards and transition in its own file.

pub mod bar;
pub mod body;
pub mod chambers;
pub(crate) mod contact;
pub(crate) mod domain;
pub mod drive;
pub mod event;
pub mod inputs;
pub(crate) mod kept;
mod meeting;
pub mod mode;
pub mod parameters;
mod pencil;
pub mod resolution;
pub mod rock;
pub mod scales;
pub mod spline;
pub(crate) mod warnings;
