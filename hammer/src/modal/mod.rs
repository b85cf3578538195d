//! From the bodies' own modes to a decomposed linear system, and the exact flow in it. Each file uses only those above
//! it:
//!
//! ```text
//! structure    bodies in their own modes, springs and dashpots attached
//! spectrum     its eigenvalues and eigenvectors, as blocks of two coordinates
//! system       flow, loads and displacements in these coordinates
//! shared       cache of systems, by their numbers
//! track        a modal vector in motion
//! stretch      integrals between two events
//! memory       whether there is room for all of them
//! model        the hammer's systems
//! ```

mod memory;
pub mod model;
pub(crate) mod shared;
mod spectrum;
pub mod stretch;
pub mod structure;
pub mod system;
pub mod track;
