//! All tests of this crate in one program, which is linked once; `cargo test --test all MODULE::` runs those of one
//! file.

mod compare;
mod found;
mod properties;
mod reference;
mod rows;
mod sensitivity;
mod steps;
