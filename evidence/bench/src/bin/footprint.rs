//! What one instance weighs, and a fixed amount of work for an instruction counter.
//!
//! `footprint memory` prints the bytes of heap that an instance holds and the peak of its
//! set-up; `footprint cycles N` runs `N` pressure cycles of the reference hammer.

use bench::engine::machine;
use hammer::Parameters;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Period of the stationary response, s.
const PERIOD: f64 = 45.389e-3;

fn memory() {
    let parameters = Parameters::default();
    // Whatever is shared by all is there before the first is counted.
    let first = machine(&parameters);
    let region = Region::new(ALLOCATOR);
    let mut instance = machine(&parameters);
    let made = region.change();
    instance.advance(PERIOD).expect("the reference hammer runs");
    let run = region.change();
    let held = |s: &stats_alloc::Stats| s.bytes_allocated as i64 - s.bytes_deallocated as i64;
    println!("{{\"new\":{},\"after_cycle\":{}}}", held(&made), held(&run));
    drop((first, instance));
}

fn cycles(count: u32) {
    let mut machine = machine(&Parameters::default());
    for cycle in 1..=count {
        let start = f64::from(cycle - 1) * PERIOD;
        for step in 1..=45 {
            machine.advance(start + f64::from(step) * 1e-3).expect("the reference hammer runs");
        }
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["memory"] => memory(),
        ["cycles", count] => cycles(count.parse().expect("a number of cycles")),
        _ => eprintln!("footprint memory | footprint cycles N"),
    }
}
