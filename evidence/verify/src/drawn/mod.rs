//! Scenes drawn over the whole domain, actions on them, and stored scenes that failed once.

pub mod actions;
pub(crate) mod air;
pub(crate) mod draws;
pub mod scaling;
pub mod scenes;
pub mod stored;
