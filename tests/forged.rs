//! States that somebody has changed, and given the right checksum, are read and stepped. How much work
//! a step may take is counted in the engine's own test, `altered`.

mod support;

use hammer::variables::VARIABLES;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::time::{Duration, Instant};
use support::host::Host;
use support::library::{ERROR, Handle, Library, OK};

/// Where the payload begins: magic, version, length, checksum, GUID.
const HEADER: usize = 4 + 4 + 8 + 4 + 36;
const CHECKSUM: std::ops::Range<usize> = 16..20;
/// The present of an honest state, s.
const PRESENT: f64 = 0.02 + 1.25e-3;
/// What takes longer hangs, also on a busy machine: before, such a reader searched for ever.
const PATIENCE: Duration = Duration::from_secs(60);

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = crc32fast::hash(&bytes[HEADER..]);
    bytes[CHECKSUM].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// A state in flight, 1 ms into a step, as bytes.
fn honest(host: &Host) -> Vec<u8> {
    host.step(0.0, 0.02);
    host.step(0.02, 1.25e-3);
    let mut state = Handle(0);
    assert_eq!(host.library.get_state(host.handle, Some(&mut state)), OK);
    let bytes = host.library.serialize(host.handle, state).unwrap();
    assert_eq!(host.library.free_state(host.handle, Some(&mut state)), OK);
    bytes
}

/// Takes a state from bytes, reads all there is and steps on by 20 ms, which goes well or ends in an
/// error that says why; how the state was received.
fn receive(host: &Host, bytes: &[u8]) -> [i32; 2] {
    let (library, begun) = (host.library, Instant::now());
    let mut state = Handle(0);
    let mut received = [library.deserialize(host.handle, bytes, &mut state), ERROR];
    if received[0] == OK {
        received[1] = library.set_state(host.handle, state);
        for (reference, _) in (0u32..).zip(VARIABLES.iter()) {
            library.get_reals(host.handle, &[reference], &mut [0.0]);
            library.get_ints(true, host.handle, &[reference], &mut [0]);
        }
        library.free_state(host.handle, Some(&mut state));
        internal_errors(&host.take_log());
        let stepped = library.step(host.handle, PRESENT, 0.02);
        let log = host.take_log();
        assert_eq!(stepped == ERROR, log.iter().any(|line| line.0 == ERROR), "{log:?}");
        internal_errors(&log);
    }
    assert!(begun.elapsed() < PATIENCE, "{:?}", begun.elapsed());
    internal_errors(&host.take_log());
    received
}

/// There are none.
fn internal_errors(log: &[(i32, String, String)]) {
    assert!(!log.iter().any(|line| line.2.starts_with("internal error")), "{log:?}");
}

#[test]
fn a_step_that_began_ages_ago_is_refused() {
    let library = Library::load();
    let bytes = honest(&Host::running(&library, &[]));
    let other = Host::new(&library);
    assert_eq!(receive(&other, &bytes), [OK, OK], "as it was written");
    // Each number of the state in turn, as far in the past as a step could not begin.
    let mut refused = 0;
    for at in HEADER..bytes.len() - 8 {
        let mut forged = bytes.clone();
        forged[at..at + 8].copy_from_slice(&(-1e6_f64).to_le_bytes());
        refused += usize::from(receive(&other, &sealed(forged)) != [OK, OK]);
    }
    assert!(refused > 8, "{refused}");
}

#[test]
fn nothing_forged_holds_who_reads_it() {
    let library = Library::load();
    let bytes = honest(&Host::running(&library, &[]));
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    let crazy = [0.0, -1.0, 1e300, -1e300, f64::NAN, f64::INFINITY, 1e-300, 1e6, 1e9];
    let mut taken = 0;
    for _ in 0..300 {
        let mut forged = bytes.clone();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(HEADER..bytes.len() - 8);
            match rng.random_range(0..3) {
                0 => forged[at] ^= 1 << rng.random_range(0..8),
                1 => forged[at] = rng.random(),
                _ => {
                    let value: f64 = crazy[rng.random_range(0..crazy.len())];
                    forged[at..at + 8].copy_from_slice(&value.to_le_bytes());
                }
            }
        }
        let other = Host::new(&library);
        taken += usize::from(receive(&other, &sealed(forged)) == [OK, OK]);
    }
    assert!(taken > 20, "only {taken} were so much as taken");
}
