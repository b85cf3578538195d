//! Checks of the engine, as rows of one report.
//!
//! Every check is a function that returns [`rows::row::Row`]s. The tests assert them, and `cargo verify` prints the
//! same rows, so the report contains nothing that no test asserts. A function that returns `hammer::Error` passes on
//! the engine's errors.

#![forbid(unsafe_code)]

pub mod comparison;
pub mod drawn;
pub mod laws;
pub mod reference;
pub mod report;
pub mod rows;
pub mod scene;
