//! From the bodies' own modes to a decomposed linear system, and the exact flow in it. Each
//! file uses only those above it:
//!
//! ```text
//! structure    bodies in their own modes, springs and dashpots attached
//! block        two coordinates of the result
//! deflation    modes of equal frequency taken out
//! jet          functions of s with their derivatives
//! secular      the function whose zeros are the eigenvalues, and its vectors
//! bordered     the same of more than two attachments
//! exact        the same in twice the digits
//! roots        all zeros at once
//! cluster      vectors of roots among several modes of nearly equal frequency
//! refinement   an eigenpair by Newton's method, its residuals in twice the digits
//! quotient     remainders over the factor of two roots, to twice the digits
//! confluence   two that nearly coincide
//! residual     how far a block is from an invariant pair
//! separation   real roots that are known to few digits
//! pairing      roots into blocks
//! spectrum     all of the above in one call
//! joined       the modes of bodies that are joined
//! reaction     the displacement of a stiff attachment, from the force in it
//! generator    the blocks' flow
//! basis        coordinates in and out
//! passage      from one system's coordinates straight into another's
//! driven       the part of a motion that is a polynomial
//! response     what loads do to a system
//! functional   a displacement, its bounds and its derivatives
//! system       all of it decomposed, with the energy forms
//! graph        bodies, ties, and groups that have a system
//! shared       systems of equal numbers made once
//! track        a modal vector in motion
//! stretch      integrals between two events
//! memory       what all of them take
//! model        the hammer's systems
//! ```

mod basis;
mod block;
mod bordered;
mod cluster;
mod confluence;
mod deflation;
pub mod driven;
mod exact;
mod functional;
pub(crate) mod generator;
pub mod graph;
mod jet;
mod joined;
mod memory;
pub mod model;
mod pairing;
pub mod passage;
mod quotient;
mod reaction;
mod refinement;
mod residual;
mod response;
mod roots;
mod secular;
mod separation;
pub(crate) mod shared;
mod spectrum;
pub mod stretch;
pub mod structure;
pub mod system;
pub mod track;
