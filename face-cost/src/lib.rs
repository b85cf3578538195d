//! The C functions of an FMU for whoever measures them: this crate's own rows, and the
//! contest of `peers`.

pub mod library;

/// Why something could not be measured.
pub type Failure = Box<dyn std::error::Error>;
