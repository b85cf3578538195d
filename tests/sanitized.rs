//! Hosts in C, compiled with sanitizers. Memory stays with the side that owns it, and the library leaks nothing.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use crate::support::host::{Host, vr};
use crate::support::library::Library;
use crate::support::three::Three;
use dth_hammer::{GUID, TOKEN};
use std::path::Path;
use std::process::Command;

const STEPS: usize = 60;
const SIZE: f64 = 1e-3;
const NAMES: [&str; 3] = ["piston_position", "rock_impulse", "energy_residual"];

/// Output of a host in `tests/platforms`; `None` if the sanitizers are not installed.
fn printed(source: &str, token: &str) -> Option<Vec<String>> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("sanitized-{source}"));
    let source = Path::new("tests/platforms").join(source);
    let compiler = Command::new("gcc")
        .args(["-g", "-Wall", "-Wextra", "-fsanitize=address,undefined", "-fno-sanitize-recover"])
        .arg(source)
        .arg("-o")
        .arg(&program)
        .args(["-ldl", "-lm"])
        .output();
    let Some(compiler) = compiler.ok().filter(|compiler| compiler.status.success()) else {
        assert!(std::env::var_os("CI").is_none(), "apt install gcc");
        println!("skipped: gcc or its sanitizers are not installed");
        return None;
    };
    assert!(compiler.stderr.is_empty(), "{}", String::from_utf8_lossy(&compiler.stderr));
    let output = Command::new(program)
        .arg(Library::path())
        .args([token, &SIZE.to_string(), &STEPS.to_string()])
        .args(NAMES.map(|name| vr(name).to_string()))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{}\n{errors}", output.status);
    Some(String::from_utf8_lossy(&output.stdout).lines().map(String::from).collect())
}

fn row(bits: &[u64]) -> String {
    bits.iter().map(|bits| format!("{bits:016x}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_sanitized_host_reads_the_same_bits_and_finds_no_fault() {
    let Some(lines) = printed("host.c", GUID) else { return };
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let read = || row(&NAMES.map(|name| host.get(name).to_bits()));
    let mut rows = vec![read()];
    for step in 0..STEPS {
        host.step(step as f64 * SIZE, SIZE);
        rows.push(read());
    }
    assert!(rows.first() != rows.last());
    assert_eq!(lines, rows);
}

#[test]
fn a_sanitized_host_of_fmi_3_is_told_of_the_same_events() {
    let Some(lines) = printed("host3.c", TOKEN) else { return };
    let library = Library::load();
    let host = Three::new(&library, true, true);
    host.start(true);
    let (mut time, mut number, mut rows) = (0.0, 1, Vec::new());
    while time < STEPS as f64 * SIZE {
        let ended = host.step(time, f64::from(number) * SIZE - time);
        time = ended.time;
        rows.push(row(&host.fingerprint(&NAMES)));
        if ended.event {
            host.event(|_, _| ());
        }
        number += i32::from(!ended.early);
    }
    assert!(rows.len() > STEPS, "a blow ends a step before its time");
    assert_eq!(lines, rows);
}
