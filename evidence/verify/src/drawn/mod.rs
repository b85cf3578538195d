//! Scenes drawn over the whole domain, what is done to them, and those that failed once.

pub mod actions;
pub(crate) mod air;
pub(crate) mod draws;
pub mod scaling;
pub mod scenes;
pub mod stored;
