//! From the bodies' own modes to a decomposed linear system, and the exact flow in it.

mod basis;
pub mod model;
mod pairs;
mod receptance;
pub mod spectrum;
pub mod stretch;
pub mod system;
pub mod track;
