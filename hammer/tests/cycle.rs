//! The stationary cycle, against the settled simulation, differences and scaling laws.

use hammer::periodic::{Cycle, CycleError, Piece, Schedule, Search, stationary};
use hammer::tangent::{Parameter, Seed};
use hammer::{Energies, Fidelity, Input, InputValues, Machine, Parameters, Source};

fn cycle(p: &Parameters, inputs: &InputValues, seeds: &[Seed]) -> Result<Cycle, CycleError> {
    let mut machine = Machine::new(p, inputs, 0.0).expect("a scene");
    stationary(&mut machine, &Search::default(), seeds)
}

fn reference(elements: usize) -> Parameters {
    let mut p = Parameters::default();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p
}

/// What a period puts in and loses.
fn spent(e: &Energies) -> [f64; 6] {
    [e.drive, e.gravity, e.feed, e.rock_dissipated, e.viscous, e.damping]
}

/// Every seed but those of which the scene reads nothing, with its value.
fn seeds(p: &Parameters) -> Vec<(Seed, f64)> {
    let read = Parameter::ALL.iter().filter(|q| q.is_read(p));
    let mut list: Vec<_> = read.map(|q| (Seed::Parameter(*q), *q.slot(&mut p.clone()))).collect();
    list.push((Seed::Input(Input::FeedForce, 0), InputValues::default().feed_force));
    list
}

/// 40 blows forget the start to rounding (the multiplier is 0.2); what is left is rounding of
/// the settled run, 1e-13 of a state that is turned over at each touch of the rock.
#[test]
fn it_is_what_the_simulation_settles_to() {
    for p in [reference(20), Parameters { fidelity: Fidelity::Rigid, ..reference(1) }] {
        let cycle = cycle(&p, &InputValues::default(), &[]).expect("a cycle");
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        machine.advance(40.0 * cycle.period).expect("a run");
        let blow = *machine.blow().expect("a blow");
        for (found, settled) in [
            (cycle.period, blow.period),
            (cycle.advance, blow.penetration),
            (cycle.rop, blow.rop),
            (cycle.strikes[0].speed, blow.speed),
            (cycle.strikes[0].energy, blow.energy),
        ] {
            assert!((found / settled - 1.0).abs() < 1e-10, "{found} {settled}");
        }
        assert!(cycle.is_stable());
        // What comes in goes out, and nothing is stored.
        let e = cycle.energies;
        let put_in = e.drive + e.gravity + e.feed;
        let lost = e.rock_dissipated + e.viscous + e.damping;
        assert!((put_in - lost).abs() < 1e-9 * put_in, "{put_in} {lost}");
    }
}

/// The numbers to meet, and the rate at which the reference forgets its start: 0.199 a blow.
#[test]
fn the_reference_has_the_derivatives_and_the_multiplier_that_were_measured() {
    let seeds = [Seed::Parameter(Parameter::RockStiffness), Seed::Input(Input::FeedForce, 0)];
    let cycle = cycle(&reference(20), &InputValues::default(), &seeds).expect("a cycle");
    let period = cycle.gradients[0].period * 1.2e8 / cycle.period;
    let advance = cycle.gradients[1].advance * 5000.0 / cycle.advance;
    // As many digits as were given.
    assert!((period + 0.071182).abs() < 5e-7, "{period}");
    assert!((advance - 0.0947321).abs() < 5e-8, "{advance}");
    assert!((cycle.multipliers[0].re - 0.199).abs() < 5e-4, "{:?}", cycle.multipliers);
}

/// Cycles are solved to 1e-12 and differenced over 1e-6: 1e-6 of their size is what rounding
/// leaves (`2 * 1e-12 / 2e-6`); truncation is below that, by the second step.
#[test]
fn every_derivative_is_what_differences_of_solved_cycles_tend_to() {
    let mut p = reference(6);
    p.bit.length = 0.2;
    let base = InputValues::default();
    let list = seeds(&p);
    let only: Vec<Seed> = list.iter().map(|x| x.0).collect();
    let found = cycle(&p, &base, &only).expect("a cycle");
    let mut compared = 0;
    for ((seed, value), gradient) in list.iter().zip(&found.gradients) {
        let h = 1e-6 * if *value == 0.0 { 1.0 } else { *value };
        if gradient.reach < 4.0 * h || *value == 0.0 {
            continue;
        }
        let at = |h: f64| {
            let (mut p, mut inputs) = (p, base);
            match seed {
                Seed::Parameter(q) => *q.slot(&mut p) += h,
                _ => inputs.feed_force += h,
            }
            let c = cycle(&p, &inputs, &[]).expect("a cycle");
            let strike = c.strikes[0];
            [c.period, c.advance, strike.speed, strike.time, strike.rebound]
                .into_iter()
                .chain(spent(&c.energies))
                .chain(c.peaks)
                .collect::<Vec<f64>>()
        };
        let (low, high, lower, higher) = (at(-h), at(h), at(-0.5 * h), at(0.5 * h));
        let strike = gradient.strikes[0];
        let ours = [gradient.period, gradient.advance, strike.speed, strike.time, strike.rebound];
        let ours = ours.into_iter().chain(spent(&gradient.energies)).chain(gradient.peaks);
        for (k, tangent) in ours.map(|d| d * value).enumerate() {
            let (coarse, fine) =
                ((high[k] - low[k]) / (2.0 * h) * value, (higher[k] - lower[k]) / h * value);
            let bound = 2.0 * (fine - coarse).abs() + 1e-6 * low[k].abs();
            assert!((tangent - fine).abs() <= bound, "{seed:?} {k}: {tangent:e} {fine:e}");
        }
        compared += 1;
    }
    assert!(compared >= 12, "{compared}");
}

/// Sum of exponents times elasticities: Euler's theorem for a scaling law.
fn sum(cycle: &Cycle, list: &[(Seed, f64)], exponents: &[(&str, f64)]) -> [f64; 10] {
    let mut sums = [0.0; 10];
    let numbers = |period: f64, advance: f64, e: &Energies, peaks: [f64; 2]| {
        [period, advance].into_iter().chain(spent(e)).chain(peaks)
    };
    let values: Vec<f64> =
        numbers(cycle.period, cycle.advance, &cycle.energies, cycle.peaks).collect();
    for ((seed, value), gradient) in list.iter().zip(&cycle.gradients) {
        let name = match seed {
            Seed::Parameter(q) => q.name(),
            _ => "feed_force",
        };
        // One exponent for all sections' lengths, and one for their areas.
        let all = |law: &str| name.contains(".segment[") && name.ends_with(law);
        let exponent = exponents.iter().find(|x| x.0 == name || all(x.0)).map_or(0.0, |x| x.1);
        let slopes = numbers(gradient.period, gradient.advance, &gradient.energies, gradient.peaks);
        for (sum, (slope, number)) in sums.iter_mut().zip(slopes.zip(&values)) {
            *sum += exponent * value * slope / number;
        }
    }
    sums
}

/// Masses, stiffnesses, viscosities, forces and WR times a: the same motion, whether E and rho
/// see to it or areas. Displacements,
/// velocities and forces times b, WR times b^2: the motion times b. Time in another unit: the
/// period in that unit, the advance as it was. Of each, the derivative at no change: of period,
/// advance, energies (all alike), forces.
///
/// Elasticities of order one to ten are solved to 1e-10 each.
#[test]
fn derivatives_obey_the_scaling_laws() {
    let masses = [
        ("material.youngs_modulus", 1.0),
        ("material.density", 1.0),
        ("contact.stiffness", 1.0),
        ("rock.stiffness", 1.0),
        ("rock.viscosity", 1.0),
        ("rock.energy_barrier", 1.0),
        ("drive.amplitude", 1.0),
        ("feed_force", 1.0),
    ];
    let areas = [
        ("cross_section", 1.0),
        ("].area", 1.0),
        ("contact.stiffness", 1.0),
        ("rock.stiffness", 1.0),
        ("rock.viscosity", 1.0),
        ("rock.energy_barrier", 1.0),
        ("drive.amplitude", 1.0),
        ("feed_force", 1.0),
    ];
    let motion = [
        ("contact.initial_gap", 1.0),
        ("drive.stroke", 1.0),
        ("drive.amplitude", 1.0),
        ("feed_force", 1.0),
        ("gravity", 1.0),
        ("rock.standstill_speed", 1.0),
        ("rock.standstill_penetration", 1.0),
        ("rock.energy_barrier", 2.0),
    ];
    let time = [
        ("material.youngs_modulus", -2.0),
        ("material.damping_time", 1.0),
        ("contact.stiffness", -2.0),
        ("rock.stiffness", -2.0),
        ("rock.viscosity", -1.0),
        ("rock.energy_barrier", -2.0),
        ("rock.standstill_speed", -1.0),
        ("drive.amplitude", -2.0),
        ("feed_force", -2.0),
        ("gravity", -2.0),
    ];
    // Lengths in another unit: what has none of them stays.
    let length = [
        ("material.youngs_modulus", -1.0),
        ("material.density", -3.0),
        ("cross_section", 2.0),
        ("].area", 2.0),
        ("].length", 1.0),
        ("piston.length", 1.0),
        ("bit.length", 1.0),
        ("contact.initial_gap", 1.0),
        ("drive.stroke", 1.0),
        ("drive.amplitude", 1.0),
        ("feed_force", 1.0),
        ("gravity", 1.0),
        ("rock.energy_barrier", 2.0),
        ("rock.standstill_speed", 1.0),
        ("rock.standstill_penetration", 1.0),
    ];
    let mut unequal = reference(7);
    (unequal.bit.length, unequal.rock.viscosity) = (0.22, 9e4);
    let mut stepped = reference(7);
    stepped.piston.segments = 3;
    for (s, (length, area)) in
        stepped.piston.segment.iter_mut().zip([(0.1, 2.7e-3), (0.04, 1.7e-3), (0.03, 2e-3)])
    {
        (s.length, s.area) = (length, area);
    }
    let rigid = |p: Parameters| Parameters { fidelity: Fidelity::Rigid, ..p };
    for p in [reference(20), unequal, rigid(unequal), stepped, rigid(stepped)] {
        let list = seeds(&p);
        let only: Vec<Seed> = list.iter().map(|x| x.0).collect();
        let cycle = cycle(&p, &InputValues::default(), &only).expect("a cycle");
        for (law, expected) in [
            (&masses[..], [0.0, 0.0, 1.0, 1.0]),
            (&areas, [0.0, 0.0, 1.0, 1.0]),
            (&motion, [0.0, 1.0, 2.0, 1.0]),
            (&time, [1.0, 0.0, -2.0, -2.0]),
            (&length, [0.0, 1.0, 2.0, 1.0]),
        ] {
            let sums = sum(&cycle, &list, law);
            let [period, advance, energy, force] = expected;
            let mut all = [energy; 10];
            (all[0], all[1], all[8], all[9]) = (period, advance, force, force);
            // A rigid body has no damping.
            let (rigid, damping) = (p.fidelity == Fidelity::Rigid, 7);
            let sums = sums.iter().enumerate().filter(|(k, _)| !(rigid && *k == damping));
            for (k, sum) in sums {
                let expected = all[k];
                assert!((sum - expected).abs() < 1e-8, "{law:?} {k}: {sum}");
            }
        }
    }
}

/// A piston driven by a force that is given over time: up to the cycle at a phase of it, which
/// here no simulation settles to (its multiplier is about -12).
#[test]
fn a_drive_that_repeats_has_its_cycle_too_though_it_does_not_attract() {
    let mut p = reference(3);
    p.drive.source = Source::Force;
    p.contact.initial_gap = 0.002;
    let (period, force) = (0.03, 1800.0);
    let input = Input::DriveForce;
    let piece = |at: f64, value: f64| Piece { at, input, derivatives: vec![value] };
    let pieces = vec![piece(0.0, force), piece(0.5 * period, -0.8 * force)];
    let schedule = Some(Schedule { period, pieces });
    let search = Search { schedule, settle: 8, ..Search::default() };
    let run = |p: &Parameters, search: &Search| {
        let mut machine = Machine::new(p, &InputValues::default(), 0.0).expect("a scene");
        let seeds = [Seed::Parameter(Parameter::RockStiffness)];
        stationary(&mut machine, search, &seeds).expect("a cycle")
    };
    let cycle = run(&p, &search);
    assert!((cycle.period - period).abs() < 1e-14 && cycle.gradients[0].period == 0.0);
    assert!(!cycle.is_stable() && cycle.steps[1] > 0, "{:?}", cycle.multipliers);
    // The largest forces are those of all its pieces.
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
    machine.restore(&cycle.state).expect("its state");
    let (start, mut peaks) = (machine.time(), [0.0f64; 2]);
    for (value, end) in [(force, 0.5 * period), (-0.8 * force, period)] {
        machine.set_input(input, &[value]).expect("a force");
        machine.advance(start + end).expect("a run");
        let seen = machine.peaks();
        peaks = [peaks[0].max(seen.contact_force), peaks[1].max(seen.rock_force)];
    }
    for (found, simulated) in cycle.peaks.iter().zip(peaks) {
        // Twelve times what a lap leaves of 1e-12 of the state.
        assert!((found / simulated - 1.0).abs() < 1e-9, "{found} {simulated}");
    }
    let near = Search { start: Some(cycle.orbit.clone()), settle: 0, ..search };
    let h = 1e-7 * p.rock.stiffness;
    let at = |h: f64| {
        let mut p = p;
        p.rock.stiffness += h;
        run(&p, &near).advance
    };
    let (coarse, fine) = ((at(h) - at(-h)) / (2.0 * h), (at(0.5 * h) - at(-0.5 * h)) / h);
    let ours = cycle.gradients[0].advance;
    // Solved to 1e-12 of the state, ten times which is the advance's own noise.
    let bound = 2.0 * (coarse - fine).abs() + 1e-11 * cycle.advance.abs() / h;
    assert!((ours - fine).abs() <= bound, "{ours:e} {fine:e} {bound:e}");
}

#[test]
fn what_has_no_cycle_says_why() {
    let mut p = reference(2);
    p.drive.source = Source::Pressure;
    let error = cycle(&p, &InputValues::default(), &[]).expect_err("no schedule");
    assert_eq!(error, CycleError::NoSchedule);
    let mut machine = Machine::new(&reference(2), &InputValues::default(), 0.0).expect("a scene");
    let schedule = Some(Schedule { period: 0.05, pieces: Vec::new() });
    let search = Search { schedule, ..Search::default() };
    let error = stationary(&mut machine, &search, &[]).expect_err("a relay");
    assert_eq!(error, CycleError::NotScheduled);
    let mut slow = reference(2);
    slow.drive.amplitude = 0.0;
    slow.gravity = 0.0;
    let mut machine = Machine::new(&slow, &InputValues::default(), 0.0).expect("a scene");
    let search = Search { limit: 0.5, ..Search::default() };
    let error = stationary(&mut machine, &search, &[]).expect_err("no force");
    assert_eq!(error, CycleError::NoReturn { after: 0.5, stalled: false });
}
