//! Hosts with other floating-point settings than Rust's: exceptions that end the program, other rounding, small
//! numbers flushed to zero. Delphi, `gfortran -ffpe-trap` and debug builds make such hosts.

#![cfg(target_arch = "x86_64")]
#![allow(unsafe_code, reason = "sets the processor's control register")]

mod support;

use std::arch::asm;
use support::host::Host;
use support::library::Library;
use support::three::Three;

/// Settings at the start of a program: all exceptions masked, rounding to nearest.
const PLAIN: u32 = 0x1f80;
const FLAGS: u32 = 0x3f;
const EXCEPTIONS: [(&str, u32); 6] = [
    ("invalid", 1 << 7),
    ("denormal", 1 << 8),
    ("divide by zero", 1 << 9),
    ("overflow", 1 << 10),
    ("underflow", 1 << 11),
    ("inexact", 1 << 12),
];

fn control() -> u32 {
    let mut value = 0_u32;
    // SAFETY: stores a register in a variable.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut value) };
    value
}

fn set_control(value: u32) {
    // SAFETY: until the settings are Rust's again, only the library computes, and it must cope with them.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const value) };
}

/// Makes a call with these settings, which must be the same afterwards.
fn under<T>(settings: u32, call: impl FnOnce() -> T) -> T {
    set_control(settings);
    let made = call();
    let after = control();
    set_control(PLAIN);
    assert_eq!(after, settings, "{after:#x}, not {settings:#x}");
    made
}

/// A run in which every call is made with these settings.
fn run(library: &Library, settings: u32, fidelity: f64) -> Vec<u64> {
    let host = under(settings, || Host::with_logging(library, true));
    under(settings, || host.set("feed_force", 4e3));
    under(settings, || host.set("fidelity", fidelity));
    under(settings, || host.start(0.0));
    for step in 0..40 {
        let point = f64::from(step) * 1e-3;
        under(settings, || host.step(point, 1e-3));
    }
    let mut state = under(settings, || host.fingerprint());
    for name in ["contact_force", "energy_residual"] {
        state.push(under(settings, || host.rate(name)).to_bits());
    }
    under(settings, || drop(host));
    state
}

/// Compares a run under each of the settings with one under a program's own.
fn assert_independent(run: impl Fn(u32) -> Vec<u64>) {
    let expected = run(PLAIN);
    for (name, mask) in EXCEPTIONS {
        // An exception that gets through would end this program.
        assert_eq!(run(PLAIN & !mask), expected, "{name} unmasked");
    }
    for (name, bits) in [("downward", 1 << 13), ("upward", 1 << 14), ("flushed", 0x8040)] {
        assert_eq!(run(PLAIN | bits), expected, "{name}");
    }
}

#[test]
fn whatever_the_hosts_floating_point_is_the_bits_are_the_same_and_nothing_ends_the_program() {
    let library = Library::load();
    for fidelity in [1.0, 2.0] {
        assert_independent(|settings| run(&library, settings, fidelity));
    }
}

/// The same in FMI 3.0, with events: the bits at the end of each step.
fn run_three(library: &Library, settings: u32) -> Vec<u64> {
    let host = under(settings, || Three::new(library, true, true));
    under(settings, || host.start(true));
    let (mut point, mut found) = (0.0, Vec::new());
    while point < 0.1 {
        let size = 0.1 - point;
        let ended = under(settings, || host.step(point, size));
        point = ended.time;
        if ended.event {
            under(settings, || host.event(|_, _| ()));
        }
        let names = ["contact_force", "energy_residual", "rop"];
        found.extend(under(settings, || host.fingerprint(&names)));
        found.push(point.to_bits());
    }
    under(settings, || drop(host));
    found
}

#[test]
fn fmi_3_does_not_depend_on_the_hosts_floating_point_either() {
    let library = Library::load();
    assert!(run_three(&library, PLAIN).len() > 4, "a blow ends a step");
    assert_independent(|settings| run_three(&library, settings));
}

#[test]
fn the_exceptions_that_the_host_has_noted_are_kept_and_no_others_added() {
    let library = Library::load();
    for noted in [0, 1, FLAGS] {
        let host = under(PLAIN | noted, || Host::running(&library, &[]));
        under(PLAIN | noted, || host.step(0.0, 0.05));
    }
}
