//! The laws: bodies, contact, drive, rock, and what a scene is made of.

pub mod bar;
pub mod body;
pub mod inputs;
mod meeting;
pub mod mode;
pub mod parameters;
mod pencil;
pub mod rock;
pub mod spline;
