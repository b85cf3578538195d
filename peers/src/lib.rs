//! What the engine is measured against.
//!
//! * [`model`]: the finite element hammer assembled a second time, from the
//!   text of the model and without a line of the engine;
//! * [`reference`](mod@reference): its solution in double-double arithmetic, the oracle of
//!   every error quoted in the report;
//! * the other modules: solvers that a user could pick instead.
//!
//! Nothing that ships depends on this crate.

pub mod alpha;
pub mod crossing;
pub mod dd;
#[cfg(feature = "contest")]
pub mod diffsol_peer;
pub mod engine;
pub mod export;
pub mod hybrid;
pub mod law;
pub mod linear;
pub mod model;
pub mod radau;
pub mod reference;
pub mod tabulated;
pub mod taylor;
pub mod trajectory;
