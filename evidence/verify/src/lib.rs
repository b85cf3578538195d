//! The evidence: what the engine is checked against, as rows of one report.
//!
//! Every check is a function that returns [`rows::row::Row`]s. The tests assert them, and
//! `cargo verify` prints the same rows: nothing is in the report that no test holds. A function that
//! returns `hammer::Error` passes on what the engine says.

#![forbid(unsafe_code)]

pub mod comparison;
pub mod drawn;
pub mod laws;
pub mod reference;
pub mod report;
pub mod rows;
pub mod scene;
