//! From the bodies' own modes to a decomposed linear system.

mod basis;
pub mod model;
mod pairs;
mod receptance;
pub mod spectrum;
pub mod system;
