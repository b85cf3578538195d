//! Arbitrary calls of either standard, in any order: none crashes, hangs or panics.

#![no_main]

use fuzz::abuser::three::ThreeAbuser;
use fuzz::abuser::{Abuser, Watchdog};
use fuzz::support::library::Log;
use fuzz::{Draws, LIBRARY};
use libfuzzer_sys::fuzz_target;
use rand::RngExt;
use std::sync::LazyLock;

static DOG: LazyLock<Watchdog> = LazyLock::new(Watchdog::new);

fuzz_target!(|data: &[u8]| {
    let mut draws = Draws::new(data);
    if draws.random() {
        let mut abuser = ThreeAbuser::new(&LIBRARY, draws.clone());
        while !draws.are_over() {
            abuser.act(&DOG);
        }
        abuser.clean_up();
    } else {
        let log = Log::default();
        let mut abuser = Abuser::new(&LIBRARY, &log, draws.clone());
        while !draws.are_over() {
            abuser.act(&DOG);
        }
        abuser.clean_up();
    }
});
