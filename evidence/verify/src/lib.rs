//! The evidence: what the engine is checked against, as rows of one report.
//!
//! Every check is a function that returns [`row::Row`]s. The tests assert them, and
//! `cargo verify` prints the same rows: nothing is in the report that no test holds. A function that
//! returns `hammer::Error` passes on what the engine says.

#![forbid(unsafe_code)]

pub mod actions;
pub mod assembly;
pub mod bodies;
pub mod casing;
pub mod catalogue;
pub mod closed;
pub mod compare;
pub mod continuum;
pub mod cycle;
mod draws;
pub mod hard;
pub mod joints;
pub mod known;
pub mod measured;
pub mod mesh;
pub mod monitor;
mod observables;
pub mod order;
pub mod properties;
mod random_air;
pub mod random_scene;
pub mod reference;
pub mod report;
pub mod row;
pub mod scaling;
pub mod scene;
pub mod sensitivity;
pub mod shapes;
pub mod stored;
pub mod string;
pub mod study;
pub mod tally;
