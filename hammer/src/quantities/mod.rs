//! Parameters and inputs of a scene: table, domains, and derived quantities.

pub(crate) mod domain;
pub mod inputs;
pub mod parameters;
pub mod quantity;
pub mod scales;
pub mod sections;
pub mod table;
pub(crate) mod warnings;
