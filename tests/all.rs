//! All tests of this crate in one program, which is linked once; `cargo test --test all MODULE::` runs those of one
//! file. Tests that need a process of their own are separate (`[[test]]` in `Cargo.toml`).

mod abuser;
mod air;
mod calls;
mod cancel;
mod capabilities;
mod configured;
mod coupling;
mod derivatives;
mod description;
mod forged;
mod linked;
mod modes;
mod reference;
mod reload;
mod sanitized;
mod support;
mod three;
mod warnings;
