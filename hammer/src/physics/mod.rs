//! The laws: bodies, contact, drive, rock, and what a scene is made of.

pub mod bar;
pub mod inputs;
pub mod mode;
pub mod parameters;
pub mod rock;
