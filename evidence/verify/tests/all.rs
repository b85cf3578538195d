//! All tests of this crate in one program, which is linked once; `cargo test --test all MODULE::` runs a
//! file's.

mod benchmarks;
mod casing;
mod closed_forms;
mod compare;
mod cycles;
mod found;
mod hard;
mod joints;
mod orders;
mod properties;
mod reference;
mod sensitivity;
mod steps;
mod string;
