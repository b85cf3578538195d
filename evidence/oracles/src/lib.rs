//! References for the engine, made without any of its code: no oracle depends on the engine.
//!
//! * [`model`]: the finite element hammer assembled a second time, from the equations alone,
//!   on linear elements or splines;
//! * [`run`]: its solution by Taylor series in double-double arithmetic, through any script of
//!   inputs and retuning; [`reference`](mod@reference) stores some of these;
//! * [`waves`]: the continuum that meshes approximate, by characteristics;
//! * [`joint`]: loose joints in that continuum;
//! * [`closed`]: closed forms and published numbers.
//!
//! Nothing that ships depends on this crate.

#![forbid(unsafe_code)]

mod air;
mod assembly;
pub mod closed;
pub mod crossing;
pub mod dd;
pub mod guard_perturbation;
pub mod joint;
pub mod law;
pub mod linear;
pub mod model;
pub mod perturb;
mod powers;
pub mod record;
pub mod reference;
pub mod run;
pub mod scene;
mod spline;
pub mod taylor;
pub mod waves;
