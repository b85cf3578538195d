//! Mathematics that is independent of the hammer.

pub(crate) mod bernstein;
pub(crate) mod bracket;
pub mod combine;
pub mod display;
pub mod form;
pub mod gram;
pub mod grid;
pub mod instant;
pub mod kernel;
pub mod math;
pub mod matrix2;
pub mod poles;
pub mod poly;
pub mod rank_one;
pub mod series;
pub mod vectors;
pub(crate) mod wide;
