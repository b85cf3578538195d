//! Hosts in C. Under sanitizers memory stays with the side that owns it, and the library leaks nothing; and one does what
//! none should.

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

/// What a host in `tests/platforms` prints, compiled with these flags; `None` without a compiler that knows them.
fn printed(source: &str, flags: &[&str], words: &[String]) -> Option<Vec<String>> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("host-{source}"));
    let source = Path::new("tests/platforms").join(source);
    let compiler = Command::new("gcc")
        .args(["-g", "-Wall", "-Wextra"])
        .args(flags)
        .arg(source)
        .arg("-o")
        .arg(&program)
        .args(["-ldl", "-lm", "-lpthread"])
        .output();
    let Some(compiler) = compiler.ok().filter(|compiler| compiler.status.success()) else {
        assert!(std::env::var_os("CI").is_none(), "apt install gcc");
        println!("skipped: gcc or its sanitizers are not installed");
        return None;
    };
    assert!(compiler.stderr.is_empty(), "{}", String::from_utf8_lossy(&compiler.stderr));
    let output = Command::new(program).arg(Library::path()).args(words).output().unwrap();
    let lines: Vec<String> =
        String::from_utf8_lossy(&output.stdout).lines().map(Into::into).collect();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{}\n{errors}{lines:?}", output.status);
    Some(lines)
}

/// The same of a host with sanitizers, which reads [`NAMES`].
fn sanitized(source: &str, token: &str) -> Option<Vec<String>> {
    let flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover"];
    let words = [token.into(), SIZE.to_string(), STEPS.to_string()].into_iter();
    let words: Vec<String> = words.chain(NAMES.map(|name| vr(name).to_string())).collect();
    printed(source, &flags, &words)
}

/// It leaves the logger by `longjmp`, frees and steps in it, steps from two threads, has no descriptor left and a stack
/// of 96 kB, and leaves a step from a signal's handler.
#[test]
fn a_host_that_does_what_none_should_is_refused_and_ends() {
    let Some(lines) = printed("battery.c", &[], &[GUID.into()]) else { return };
    assert_eq!(lines, ["all held"]);
}

fn row(bits: &[u64]) -> String {
    bits.iter().map(|bits| format!("{bits:016x}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_sanitized_host_reads_the_same_bits_and_finds_no_fault() {
    let Some(lines) = sanitized("host.c", GUID) else { return };
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
    let Some(lines) = sanitized("host3.c", TOKEN) else { return };
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
