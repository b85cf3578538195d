//! How much work a cycle takes: a slower algorithm fails here. The counts are of this
//! algorithm, not of a machine; a change that lowers them updates them.

use hammer::{InputValues, Machine, Parameters, Vectors};
use std::process::Command;

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
    assert!((47..=53).contains(&(events / cycles)), "{} events per cycle", events / cycles);
    assert!(changes <= 44 * cycles, "{} changes of basis a cycle", changes / cycles);
    assert!(evaluations <= 1050 * cycles, "{} evaluations per cycle", evaluations / cycles);
    assert!(windows <= 37 * cycles, "{} windows per cycle", windows / cycles);
    assert!(samples <= 1050 * cycles, "{} rotations per cycle", samples / cycles);
}

#[test]
fn flight_costs_a_handful_of_evaluations() {
    // From 21 ms to 41 ms the bit stands still: nothing can happen but the relay: bounds decide.
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    machine.advance(0.021).expect("a step");
    let before = machine.counters();
    machine.advance(0.041).expect("a step");
    let after = machine.counters();
    assert_eq!(after.events - before.events, 1);
    let evaluations = after.guard_evaluations - before.guard_evaluations;
    assert!(evaluations < 100, "{evaluations} evaluations in 20 ms of flight");
}

/// Set in the process that valgrind runs: how many settled cycles to make.
const CYCLES: &str = "HAMMER_CYCLES";
/// The same: energies are asked for at every communication point.
const ASKED: &str = "HAMMER_ENERGIES";
/// Name of the test below, which runs itself under valgrind.
const COUNTED: &str = "instructions_of_a_settled_cycle_stay_near_the_stated_count";

/// 12 blows to settle, then so many cycles, in communication steps of 1 ms.
fn run(cycles: u64, asked: bool) {
    let mut machine =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    let mut sum = 0.0;
    while machine.counters().blows < 12 + cycles {
        machine.advance(machine.time() + 1e-3).expect("a step");
        if asked {
            sum += machine.energies().residual;
        }
    }
    assert!(sum.is_finite());
    println!("vectors: {}", Vectors::in_use());
}

/// Instructions of a whole run, by callgrind, if it runs in AVX2.
fn instructions(cycles: u64, asked: bool) -> Option<f64> {
    let mut command = Command::new("valgrind");
    command
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().expect("this test"))
        .args(["--exact", "--nocapture", "--test-threads=1", COUNTED])
        .env(CYCLES, cycles.to_string());
    if asked {
        command.env(ASKED, "1");
    }
    let output = command.output().expect("valgrind");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{stderr}", output.status);
    let stdout = String::from_utf8_lossy(&output.stdout);
    if !stdout.contains("vectors: AVX2") {
        return None;
    }
    let line = stderr.lines().find(|line| line.contains("refs:")).expect("a count");
    let digits: String =
        line.rsplit("refs:").next()?.chars().filter(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// A snapshot of work: instructions of a settled reference cycle in AVX2, as the suite builds
/// (`opt-level = 2`, overflow checked), without and with the energies at every 1 ms. A change
/// that lowers them updates them. The margin is for other compilers and C libraries. What a
/// release build takes, `cargo work-per-cycle` counts.
#[test]
fn instructions_of_a_settled_cycle_stay_near_the_stated_count() {
    if let Ok(cycles) = std::env::var(CYCLES) {
        return run(cycles.parse().expect("a number"), std::env::var(ASKED).is_ok());
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("skipped: valgrind is not installed");
        return;
    }
    for (asked, stated) in [(false, STATED[0]), (true, STATED[1])] {
        let counted = [0, 10].map(|cycles| instructions(cycles, asked));
        let [Some(settled), Some(ten)] = counted else {
            println!("skipped: valgrind's processor has no AVX2");
            return;
        };
        let cycle = (ten - settled) / 10.0;
        println!("{cycle:.0} instructions per cycle, energies asked for: {asked}");
        assert!(
            (cycle / stated - 1.0).abs() < MARGIN,
            "{cycle:.0} instructions, stated {stated:.0}"
        );
    }
}

/// Instructions per cycle.
const STATED: [f64; 2] = [4.27e6, 6.11e6];
const MARGIN: f64 = 0.15;
