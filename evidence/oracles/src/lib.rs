//! What the engine is held to, made without a line of it.
//!
//! * [`model`]: the finite element hammer assembled a second time, from the text of the model;
//! * [`reference`](mod@reference): its solution in double-double arithmetic, the oracle of every
//!   error quoted in the reports.
//!
//! Nothing that ships depends on this crate.

pub mod crossing;
pub mod dd;
pub mod law;
pub mod linear;
pub mod model;
pub mod reference;
pub mod taylor;
