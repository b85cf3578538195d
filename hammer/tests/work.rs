//! How much work a cycle takes: a slower algorithm fails here. The counts are of this
//! algorithm, not of a machine; a change that lowers them updates them.

use hammer::{InputValues, Machine, Parameters};

/// Work from the start of cycle `from` to the start of cycle `to` of the reference hammer.
fn counts(from: u64, to: u64) -> [u64; 5] {
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    let mut at = |blows: u64| {
        while machine.counters().blows < blows {
            machine.advance(machine.time() + 1e-3).expect("a step");
        }
        let c = machine.counters();
        [c.events, c.basis_changes, c.guard_evaluations, c.windows, c.samples]
    };
    let (a, b) = (at(from), at(to));
    std::array::from_fn(|i| b[i] - a[i])
}

/// The physics fixes the number of events of the settled cycle (it repeats exactly); the
/// search may take so much and no more.
#[test]
fn a_settled_cycle_takes_no_more_work_than_it_did() {
    let [events, changes, evaluations, windows, samples] = counts(12, 32);
    let cycles = 20;
    // Within a step of 1 ms after the blow some of its events are seen, some not: 20 cycles
    // even that out to one part in twenty.
    assert!((40..=46).contains(&(events / cycles)), "{} events per cycle", events / cycles);
    assert!(changes <= 40 * cycles, "{} changes of basis a cycle", changes / cycles);
    assert!(evaluations <= 1400 * cycles, "{} evaluations per cycle", evaluations / cycles);
    assert!(windows <= 130 * cycles, "{} windows per cycle", windows / cycles);
    assert!(samples <= 1900 * cycles, "{} rotations per cycle", samples / cycles);
}

#[test]
fn flight_costs_a_handful_of_evaluations() {
    // From 20 ms to 40 ms nothing can happen but the relay: bounds decide.
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    machine.advance(0.020).expect("a step");
    let before = machine.counters();
    machine.advance(0.040).expect("a step");
    let after = machine.counters();
    assert_eq!(after.events - before.events, 1);
    let evaluations = after.guard_evaluations - before.guard_evaluations;
    assert!(evaluations < 100, "{evaluations} evaluations in 20 ms of flight");
}
