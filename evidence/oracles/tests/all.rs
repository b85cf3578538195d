//! All tests of this crate in one program, which is linked once; `cargo test --test all MODULE::` runs a
//! file's.

mod waves;
