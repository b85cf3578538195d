//! Linear systems in modal form: from the bodies' own modes to a decomposed system, and its exact flow. Each file uses
//! only those above it:
//!
//! ```text
//! structure    bodies in their own modes, with springs and dashpots attached
//! spectrum     eigenvalues and eigenvectors of a structure, as blocks of two coordinates
//! system       flow, loads and displacements in these coordinates
//! shared       cache of systems that scenes share
//! track        a modal vector in motion
//! stretch      integrals over the time between two events
//! memory       check that there is memory for all of them
//! model        the systems of a scene
//! ```

mod memory;
pub mod model;
pub(crate) mod shared;
mod spectrum;
pub mod stretch;
pub mod structure;
pub mod system;
pub mod track;
