//! `cargo lab` on a machine that cannot build for a browser.

#![cfg(unix)]

use std::path::Path;
use std::process::Command;

/// If neither Rust's standard library for browsers nor its sources can be found, this is reported at once, with what
/// to install, and nothing is compiled.
#[test]
fn what_is_missing_is_said_before_anything_is_compiled() {
    if Path::new("/usr/bin/rustc").exists() {
        // Debian's toolchain may have the sources, whichever compiler is in use.
        return;
    }
    let mut lab = Command::new(env!("CARGO_BIN_EXE_xtask"));
    // Cargo cannot start either, which would be another error.
    lab.arg("lab").env("RUSTC", "/bin/false").env("PATH", "/nowhere").env("CARGO", "/nowhere");
    let done = lab.output().expect("the task starts");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(!done.status.success());
    assert!(said.contains("rustup target add wasm32-unknown-unknown"), "{said}");
    assert!(said.contains("rustup component add rust-src"), "{said}");
    assert!(done.stdout.is_empty(), "it began to build");
}
