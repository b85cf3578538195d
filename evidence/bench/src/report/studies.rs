//! Studies of the engine alone: cost by its size and by the processor's vectors.

use crate::timed;
use bench::engine::machine;
use hammer::{Machine, Parameters, Vectors};
use serde::Serialize;

const STEP: f64 = 1e-3;

/// Cost against the number of elements of each bar, s.
#[derive(Serialize)]
pub struct Size {
    /// Elements.
    pub elements: usize,
    /// From parameters to a machine.
    pub setup: f64,
    /// First cycle, which decomposes the systems it meets.
    pub first: f64,
    /// The same cycle again.
    pub again: f64,
    /// Transitions in it.
    pub events: u64,
}

/// Cost of a settled cycle in 1 ms steps, s.
#[derive(Serialize)]
pub struct Settled {
    /// Which vectors the engine was told to use.
    pub vectors: String,
    /// Where nobody asks for an energy, of a few cycles.
    pub cycle: f64,
    /// The same in a run so long that what is owed to the energies is paid on the way.
    pub long: f64,
    /// The same with the energies asked for after every step.
    pub with_energies: f64,
}

fn cycle(machine: &mut Machine) {
    let begin = machine.time();
    (1..=45).for_each(|k| machine.advance(begin + f64::from(k) * STEP).expect("runs"));
}

/// Cost of a hammer with so many elements per bar.
pub fn size(elements: usize) -> Size {
    let mut parameters = Parameters::default();
    (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
    // Whoever had the same hammer before has left its systems.
    hammer::forget_shared_systems();
    let (mut made, setup) = timed(|| machine(&parameters));
    let rest = made.state();
    let first = timed(|| cycle(&mut made)).1;
    let events = made.counters().events;
    let repeats = if elements > 80 { 3 } else { 20 };
    let run = |_| {
        made.restore(&rest).expect("its own state");
        timed(|| cycle(&mut made)).1
    };
    let again = (0..repeats).map(run).sum::<f64>() / f64::from(repeats);
    Size { elements, setup, first, again, events }
}

/// Settled cycles by every kind of vectors, in turn; the fastest of some rounds counts.
pub fn settled(rounds: u32) -> Vec<Settled> {
    let chosen = Vectors::in_use();
    let mut machine = machine(&Parameters::default());
    let mut run = |cycles: u64, asked: bool| {
        let last = machine.counters().blows + cycles;
        let mut sum = 0.0;
        while machine.counters().blows < last {
            machine.advance(machine.time() + STEP).expect("runs");
            sum += if asked { machine.energies().residual } else { 0.0 };
        }
        assert!(sum.is_finite());
    };
    run(12, true);
    let mut list: Vec<_> = Vectors::available().map(|v| (v, [f64::INFINITY; 3])).collect();
    for _ in 0..rounds {
        for (vectors, best) in &mut list {
            assert!(vectors.select());
            for (best, (cycles, asked)) in
                best.iter_mut().zip([(20, false), (400, false), (20, true)])
            {
                // None pays what another owes.
                run(1, true);
                *best = best.min(timed(|| run(cycles, asked)).1 / cycles as f64);
            }
        }
    }
    assert!(chosen.select());
    let row = |(vectors, [cycle, long, with_energies]): (Vectors, [f64; 3])| Settled {
        vectors: vectors.to_string(),
        cycle,
        long,
        with_energies,
    };
    list.into_iter().map(row).collect()
}
