//! Comparison of the engine and its derivatives with the reference in extended precision, on any scene and script.

pub mod asked;
pub mod bodies;
pub mod compare;
pub mod known;
pub(crate) mod observables;
pub mod sensitivity;
pub mod tally;
