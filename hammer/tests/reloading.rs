//! Reloading along the unloading line, and the rate by specific energy.

use crate::scenes;
use hammer::{InputValues, Machine, Parameters, Reloading};

fn scene(parameters: &Parameters) -> Machine {
    Machine::new(parameters, &InputValues::default(), 0.0).expect("a scene")
}

fn reloading() -> Parameters {
    let mut p = scenes::overdamped();
    p.rock.reloading = Reloading::Unloading;
    p
}

/// Another solver of the same law gives 32.99 mm/s and 45.380 ms for `overdamped`.
#[test]
fn it_settles_at_the_rate_of_another_solver() {
    let mut machine = scene(&reloading());
    machine.advance(1.5).expect("a run");
    let blow = *machine.blow().expect("a blow");
    assert!((blow.tip_rate - 32.99e-3).abs() < 0.005e-3, "{} mm/s", 1e3 * blow.tip_rate);
    assert!((blow.period - 45.380e-3).abs() < 0.5e-6, "{} ms", 1e3 * blow.period);
    let energies = machine.energies();
    assert!(energies.residual.abs() < 1e-12 * energies.drive, "{energies:?}");
}

/// Work before a change counts with the specific energy of its time: `W1 / k1 + (W2 - W1) / k2`.
#[test]
fn another_specific_energy_changes_only_the_length_drilled_from_then_on() {
    let mut p = Parameters::default();
    (p.hole.diameter, p.rock.specific_energy) = (0.09, 399e6);
    let mut machine = scene(&p);
    let work = |machine: &Machine| machine.energies().rock_dissipated + machine.energies().viscous;
    let length =
        |work: f64, energy: f64| 4.0 * work / (std::f64::consts::PI * 0.09 * 0.09 * energy);
    let (mut before, mut drilled) = (0.0, 0.0_f64);
    for (until, energy) in [(0.1, 399e6), (0.15, 100e6), (0.2, 600e6), (0.25, 250e6)] {
        p.rock.specific_energy = energy;
        let unchanged = machine.drilled_length();
        machine.retune(&p).expect("a tunable parameter");
        // Rounding of sums and differences of lengths that are at most ten times as long.
        let room = 1e-13 * drilled.max(1e-3);
        assert!((machine.drilled_length() - unchanged).abs() < room, "{energy}");
        machine.advance(until).expect("a run");
        let now = work(&machine);
        drilled += length(now - before, energy);
        before = now;
        let found = machine.drilled_length();
        assert!((found - drilled).abs() < room.max(1e-13 * drilled), "{energy}: {found} {drilled}");
    }
    assert!(drilled > 1e-4);
}
