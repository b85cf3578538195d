//! Rows of the report: closed forms, exact waves, published benchmarks, measurements.

pub mod assembly;
pub mod casing;
pub mod catalogue;
pub mod closed;
pub mod continuum;
pub mod cycle;
pub mod graze;
pub mod joints;
pub mod measured;
pub mod mesh;
pub mod order;
pub mod row;
pub mod shapes;
pub mod string;
