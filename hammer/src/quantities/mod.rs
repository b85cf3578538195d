//! What a scene is made of: parameters and inputs with their domains, and what follows from them.

pub(crate) mod domain;
pub mod inputs;
pub mod parameters;
pub mod quantity;
pub mod scales;
pub mod sections;
pub mod table;
pub(crate) mod warnings;
