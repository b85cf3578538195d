//! Any changes to a state of either standard: it is refused, or read and stepped without a crash, a
//! hang or a panic.

#![no_main]

use fuzz::abuser::CASING;
use fuzz::abuser::forger::{HEADER, forge, honest, honest_three, receive, receive_three};
use fuzz::support::host::Host;
use fuzz::support::three::Three;
use fuzz::{Draws, LIBRARY};
use libfuzzer_sys::fuzz_target;
use rand::RngExt;
use std::sync::LazyLock;

static TWO: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let host = Host::new(&LIBRARY);
    for body in ["piston.elements", "bit.elements"] {
        host.set_int(body, 3);
    }
    CASING.iter().for_each(|(name, value)| host.set(name, *value));
    host.start(0.0);
    honest(&host)
});
static THREE: LazyLock<Vec<u8>> = LazyLock::new(|| honest_three(&LIBRARY).0);

fuzz_target!(|data: &[u8]| {
    let mut draws = Draws::new(data);
    let bytes: &[u8] = if draws.random() { &THREE } else { &TWO };
    let forged = forge(&mut draws.clone(), bytes, HEADER..bytes.len() - 8);
    if draws.random() {
        receive_three(&Three::new(&LIBRARY, true, true), &forged);
    } else {
        receive(&Host::new(&LIBRARY), &forged);
    }
});
