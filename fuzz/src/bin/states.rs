//! Arbitrary changes to a state of either standard: the state is refused, or read and stepped without a crash, a hang
//! or a panic.

#![no_main]

use fuzz::abuser::STRUCTURES;
use fuzz::abuser::forger::{HEADER, forge, honest, honest_three, receive, receive_three};
use fuzz::support::host::Host;
use fuzz::support::three::Three;
use fuzz::{Draws, LIBRARY};
use libfuzzer_sys::fuzz_target;
use rand::RngExt;
use std::sync::LazyLock;

static TWO: LazyLock<Vec<Vec<u8>>> =
    LazyLock::new(|| STRUCTURES.iter().map(|structure| honest(&LIBRARY, structure)).collect());
static THREE: LazyLock<Vec<u8>> = LazyLock::new(|| honest_three(&LIBRARY).0);

fuzz_target!(|data: &[u8]| {
    let mut draws = Draws::new(data);
    let bytes = TWO.get(draws.random_range(0..=STRUCTURES.len())).unwrap_or(&THREE);
    let forged = forge(&mut draws.clone(), bytes, HEADER..bytes.len() - 8);
    if draws.random() {
        receive_three(&Three::new(&LIBRARY, true, true), &forged);
    } else {
        receive(&Host::new(&LIBRARY), &forged);
    }
});
