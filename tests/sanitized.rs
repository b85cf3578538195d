//! A host in C, made with the sanitizers of its compiler: what it hands over and takes back is its own,
//! and the library leaves nothing behind.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

mod support;

use dth_hammer::GUID;
use std::path::Path;
use std::process::Command;
use support::host::{Host, vr};
use support::library::Library;

const STEPS: usize = 60;
const NAMES: [&str; 3] = ["piston_position", "rock_impulse", "energy_residual"];

#[test]
fn a_sanitized_host_reads_the_same_bits_and_finds_no_fault() {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sanitized-host");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/platforms/host.c");
    let compiler = Command::new("gcc")
        .args(["-g", "-Wall", "-Wextra", "-fsanitize=address,undefined", "-fno-sanitize-recover"])
        .arg(source)
        .arg("-o")
        .arg(&program)
        .arg("-ldl")
        .output();
    let Some(compiler) = compiler.ok().filter(|compiler| compiler.status.success()) else {
        assert!(std::env::var_os("CI").is_none(), "apt install gcc");
        println!("skipped: gcc or its sanitizers are not installed");
        return;
    };
    assert!(compiler.stderr.is_empty(), "{}", String::from_utf8_lossy(&compiler.stderr));
    let output = Command::new(program)
        .arg(Library::path())
        .args([GUID, "1e-3", &STEPS.to_string()])
        .args(NAMES.map(|name| vr(name).to_string()))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{}\n{errors}", output.status);
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let row = || NAMES.map(|name| format!("{:016x}", host.get(name).to_bits())).join(" ");
    let mut rows = vec![row()];
    for step in 0..STEPS {
        host.step(step as f64 * 1e-3, 1e-3);
        rows.push(row());
    }
    assert!(rows.first() != rows.last());
    let lines: Vec<_> = String::from_utf8_lossy(&output.stdout).lines().map(String::from).collect();
    assert_eq!(lines, rows);
}
