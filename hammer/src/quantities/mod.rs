//! Parameters and inputs of a scene: table, domains, and derived quantities.

pub mod air;
pub(crate) mod domain;
pub mod drill;
pub mod inputs;
pub mod parameters;
pub mod quantity;
pub mod scales;
pub mod sections;
pub mod table;
mod validation;
pub(crate) mod warnings;
