//! States that were changed and given the right checksum, and hosts that read them.

use super::{Stopwatch, Structure};
use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use crate::support::three::{Three, extra};
use dth_hammer::events::{Extra, MAX_POSITIONS};
use hammer::variables::VARIABLES;
use rand::{Rng, RngExt};
use std::ops::Range;
use std::time::Duration;

/// Where the payload begins: magic, version, length, checksum, GUID.
pub const HEADER: usize = 4 + 4 + 8 + 4 + 36;
const CHECKSUM: Range<usize> = 16..20;
/// Present time of the unchanged state, s.
pub const PRESENT: f64 = 0.02 + 1.25e-3;
/// Time span of the steps after it, s.
pub const SPAN: f64 = 0.02;
/// Longer work counts as a hang: readers of such states once searched for ever.
const PATIENCE: Duration = Duration::from_secs(300);
/// Steps of FMI 3.0 that end at events: more than any motion has in that span.
const MOST_ENDS: usize = 1000;

/// The same bytes with the right checksum.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = crc32fast::hash(&bytes[HEADER..]);
    bytes[CHECKSUM].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// An unchanged state with one to three random changes in `places`, and the right checksum.
pub fn forge(rng: &mut dyn Rng, honest: &[u8], places: Range<usize>) -> Vec<u8> {
    const CRAZY: [f64; 9] = [0.0, -1.0, 1e300, -1e300, f64::NAN, f64::INFINITY, 1e-300, 1e6, 1e9];
    let mut forged = honest.to_vec();
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(places.clone());
        match rng.random_range(0..3) {
            0 => forged[at] ^= 1 << rng.random_range(0..8),
            1 => forged[at] = rng.random(),
            _ => {
                let value: f64 = super::pick(rng, &CRAZY);
                forged[at..at + 8].copy_from_slice(&value.to_le_bytes());
            }
        }
    }
    sealed(forged)
}

/// The bytes of a state of this structure in flight, 1 ms into a step.
pub fn honest(library: &Library, structure: &Structure) -> Vec<u8> {
    let host = Host::with(library, structure.reals);
    host.set("drive.source", structure.source.into());
    structure.counts.iter().for_each(|(name, count)| host.set(name, (*count).into()));
    host.start(0.0);
    host.step(0.0, 0.02);
    host.step(0.02, 1.25e-3);
    let mut state = host.state();
    let bytes = host.library.serialize(host.handle, state).unwrap();
    assert_eq!(host.library.free_state(host.handle, Some(&mut state)), OK);
    bytes
}

/// The same for FMI 3.0, with all positions that a host may monitor, and the place of these in it. The mesh is
/// coarse, since only the face's part is changed.
pub fn honest_three(library: &Library) -> (Vec<u8>, usize) {
    let host = Three::new(library, true, true);
    let position = |index: usize| -0.0123 - 1e-3 * index as f64;
    for name in ["piston.elements", "bit.elements"] {
        host.set("Int32", vr(name), 3_i32);
    }
    // The limit is low, since a sanitizer makes everything ten times slower.
    host.set("Int32", vr("work_limit"), 2_i32);
    host.set("Int32", extra("event.positions"), MAX_POSITIONS as i32);
    for index in 0..MAX_POSITIONS {
        host.set("Float64", Extra::Position(index).reference(), position(index));
    }
    host.start(true);
    step_to(&host, 0.0, 0.02);
    step_to(&host, 0.02, PRESENT);
    let bytes = host.serialized();
    let first = position(0).to_le_bytes();
    let at = bytes.windows(8).position(|window| window == first);
    (bytes, at.expect("the first position"))
}

/// Makes steps of FMI 3.0 that end at events. Returns the last status.
fn step_to(host: &Three, mut point: f64, target: f64) -> i32 {
    for _ in 0..MOST_ENDS {
        let (status, ended) = host.try_step(point, target - point);
        if status != OK || !ended.event {
            return status;
        }
        point = ended.time;
        host.plain("EnterEventMode");
        host.happened();
        host.try_update();
        host.plain("EnterStepMode");
    }
    panic!("{MOST_ENDS} events up to {point} s");
}

/// Reads a state from bytes, then all variables, and makes steps, which succeed or end in an error with a reason.
/// Returns how the state was received.
pub fn receive(host: &Host, bytes: &[u8]) -> [i32; 2] {
    let (library, begun) = (host.library, Stopwatch::start());
    let mut state = Handle(0);
    let mut received = [library.deserialize(host.handle, bytes, &mut state), ERROR];
    if received[0] == OK {
        received[1] = library.set_state(host.handle, state);
        for (reference, _) in (0u32..).zip(VARIABLES.iter()) {
            let mut value = [0.0];
            let read = library.get_reals(host.handle, &[reference], &mut value);
            assert!(read == ERROR || value[0].is_finite(), "{reference} is {value:?}, and OK");
            library.get_ints(true, host.handle, &[reference], &mut [0]);
        }
        library.free_state(host.handle, Some(&mut state));
        internal_errors(host.take_log().iter().map(|line| &*line.2));
        let stepped = library.step(host.handle, PRESENT, SPAN);
        let log = host.take_log();
        assert_eq!(stepped == ERROR, log.iter().any(|line| line.0 == ERROR), "{log:?}");
        internal_errors(log.iter().map(|line| &*line.2));
    }
    assert!(begun.worked() < PATIENCE, "{:?}", begun.worked());
    internal_errors(host.take_log().iter().map(|line| &*line.2));
    received
}

/// The same with FMI 3.0, in steps that end at events.
pub fn receive_three(host: &Three, bytes: &[u8]) -> [i32; 2] {
    let begun = Stopwatch::start();
    let received = host.adopt(bytes);
    if received == [OK, OK] {
        let extras = Extra::all().map(Extra::reference);
        for reference in (0..VARIABLES.len() as u32).chain(extras) {
            // Also of arrays, which are computed and then refused for lack of room.
            for call in ["GetFloat64", "GetInt32", "GetInt64", "GetUInt64", "GetBoolean"] {
                host.access(call, &[reference], &mut [0_u64]);
            }
        }
        internal_errors(host.lines().iter().map(String::as_str));
        let stepped = step_to(host, PRESENT, PRESENT + SPAN);
        let lines = host.lines();
        assert!(stepped == OK || !lines.is_empty(), "an error without a word");
        internal_errors(lines.iter().map(String::as_str));
    }
    assert!(begun.worked() < PATIENCE, "{:?}", begun.worked());
    internal_errors(host.lines().iter().map(String::as_str));
    received
}

/// Checks that the log has no internal error.
fn internal_errors<'a>(mut log: impl Iterator<Item = &'a str>) {
    assert_eq!(log.find(|line| line.starts_with("internal error")), None);
}
