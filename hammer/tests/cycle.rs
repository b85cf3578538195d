//! The stationary cycle, against the settled simulation, differences and scaling laws.

use crate::scenes::overdamped;
use hammer::Scene;
use hammer::periodic::{Cycle, CycleError, Piece, Response, Schedule, Search, find};
use hammer::sensitivity::Argument;
use hammer::{Energies, Fidelity, Input, InputValues, Machine, Parameters, Source};

fn scene(parameters: &Parameters) -> Scene {
    Scene { parameters: *parameters, ..Scene::default() }
}

fn cycle(p: &Parameters, by: &[Argument]) -> Result<Cycle, CycleError> {
    find(&scene(p), &Search::default(), by)
}

fn named(name: &str) -> Argument {
    Argument::named(name).expect("a row of the table")
}

fn hammer_of(elements: usize) -> Parameters {
    let mut p = overdamped();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p
}

/// What a period puts in and loses.
fn spent(e: &Energies) -> [f64; 6] {
    [e.drive, e.gravity, e.feed, e.rock_dissipated, e.viscous, e.damping]
}

/// Every argument that a relay's scene reads, and that is not zero.
fn arguments(p: &Parameters) -> Vec<Argument> {
    let unread = ["drive.area", "drive_", "return_", "blow."];
    let read = |a: &Argument| a.is_read(p) && !unread.iter().any(|u| a.name().starts_with(u));
    Argument::all().filter(|a| read(a) && a.value(&scene(p)) != 0.0).collect()
}

/// 40 blows forget the start to rounding (the multiplier is 0.2); what is left is rounding of
/// the settled run, 1e-13 of a state that is turned over at each touch of the rock.
#[test]
fn it_is_what_the_simulation_settles_to() {
    for p in [overdamped(), Parameters { fidelity: Fidelity::Rigid, ..hammer_of(1) }] {
        let cycle = cycle(&p, &[]).expect("a cycle");
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        machine.advance(40.0 * cycle.response.period).expect("a run");
        let blow = *machine.blow().expect("a blow");
        for (found, settled) in [
            (cycle.response.period, blow.period),
            (cycle.response.advance, blow.penetration),
            (cycle.response.tip_rate, blow.tip_rate),
            (cycle.response.strikes[0].speed, blow.speed),
            (cycle.response.strikes[0].energy, blow.energy),
        ] {
            assert!((found / settled - 1.0).abs() < 1e-10, "{found} {settled}");
        }
        assert!(cycle.is_stable());
        // What comes in goes out, and nothing is stored.
        let e = cycle.response.energies;
        let put_in = e.drive + e.gravity + e.feed;
        let lost = e.rock_dissipated + e.viscous + e.damping;
        assert!((put_in - lost).abs() < 1e-9 * put_in, "{put_in} {lost}");
    }
}

/// The numbers to meet, and the rate at which it forgets its start: 0.199 a blow.
#[test]
fn the_overdamped_reference_has_the_derivatives_and_the_multiplier_that_were_measured() {
    let p = overdamped();
    let by = ["rock.stiffness", "feed_force"].map(named);
    let cycle = cycle(&p, &by).expect("a cycle");
    let measured = [[-0.071182, -0.556409], [-0.0115566, 0.0947321]];
    for ((argument, gradient), measured) in by.iter().zip(&cycle.gradients).zip(measured) {
        assert!(gradient.nonsmooth.is_empty(), "{:?}", gradient.nonsmooth);
        let (own, here) = (argument.value(&scene(&p)), &cycle.response);
        let found = [
            gradient.values.period * own / here.period,
            gradient.values.advance * own / here.advance,
        ];
        for (found, measured) in found.iter().zip(measured) {
            // As many digits as were given.
            assert!((found - measured).abs() < 5e-7, "{argument:?} {found} {measured}");
        }
    }
    assert!((cycle.multipliers[0].re - 0.199).abs() < 5e-4, "{:?}", cycle.multipliers);
    assert!(cycle.is_stable());
    // Nobody has asked, so nobody can say.
    let unknown = find(&scene(&p), &Search { multipliers: 0, ..Search::default() }, &[]);
    assert!(!unknown.expect("a cycle").is_stable());
}

fn sum(cycle: &Cycle, p: &Parameters, by: &[Argument], exponents: &[(&str, f64)]) -> [f64; 10] {
    let mut sums = [0.0; 10];
    let numbers = |r: &Response| -> Vec<f64> {
        let peaks = [r.peaks.contact_force(), r.peaks.rock_force()];
        [r.period, r.advance].into_iter().chain(spent(&r.energies)).chain(peaks).collect()
    };
    let values = numbers(&cycle.response);
    for (argument, gradient) in by.iter().zip(&cycle.gradients) {
        // One exponent for all sections' lengths, and one for their areas.
        let name = argument.name();
        let all = |law: &str| name.contains(".segment[") && name.ends_with(law);
        let exponent = exponents.iter().find(|x| x.0 == name || all(x.0)).map_or(0.0, |x| x.1);
        for (sum, (slope, number)) in
            sums.iter_mut().zip(numbers(&gradient.values).iter().zip(&values))
        {
            *sum += exponent * argument.value(&scene(p)) * slope / number;
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
/// Some twenty elasticities of order one to ten, each to 1e-7 of itself: rounding over the step.
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
        ("casing.mass", 1.0),
        ("casing.impedance", 1.0),
        ("chuck.stiffness", 1.0),
        ("chuck.viscosity", 1.0),
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
        ("casing.mass", 1.0),
        ("casing.impedance", 1.0),
        ("chuck.stiffness", 1.0),
        ("chuck.viscosity", 1.0),
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
        ("chuck.travel", 1.0),
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
        ("casing.impedance", -1.0),
        ("chuck.stiffness", -2.0),
        ("chuck.viscosity", -1.0),
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
        ("chuck.travel", 1.0),
    ];
    let mut unequal = hammer_of(7);
    (unequal.bit.length, unequal.rock.viscosity) = (0.22, 9e4);
    let mut stepped = hammer_of(7);
    stepped.piston.segments = 3;
    for (s, (length, area)) in
        stepped.piston.segment.iter_mut().zip([(0.1, 2.7e-3), (0.04, 1.7e-3), (0.03, 2e-3)])
    {
        (s.length, s.area) = (length, area);
    }
    let rigid = |p: Parameters| Parameters { fidelity: Fidelity::Rigid, ..p };
    let mut cased = hammer_of(7);
    (cased.casing.mass, cased.casing.impedance) = (40.0, 2e4);
    for p in [overdamped(), unequal, rigid(unequal), stepped, rigid(stepped), cased, rigid(cased)] {
        let list = arguments(&p);
        let cycle = cycle(&p, &list).expect("a cycle");
        for (law, expected) in [
            (&masses[..], [0.0, 0.0, 1.0, 1.0]),
            (&areas, [0.0, 0.0, 1.0, 1.0]),
            (&motion, [0.0, 1.0, 2.0, 1.0]),
            (&time, [1.0, 0.0, -2.0, -2.0]),
            (&length, [0.0, 1.0, 2.0, 1.0]),
        ] {
            let sums = sum(&cycle, &p, &list, law);
            let [period, advance, energy, force] = expected;
            let mut all = [energy; 10];
            (all[0], all[1], all[8], all[9]) = (period, advance, force, force);
            // A rigid body has no damping.
            let (rigid, damping) = (p.fidelity == Fidelity::Rigid, 7);
            let sums = sums.iter().enumerate().filter(|(k, _)| !(rigid && *k == damping));
            for (k, sum) in sums {
                let expected = all[k];
                assert!((sum - expected).abs() < 1e-5, "{law:?} {k}: {sum}");
            }
        }
    }
}

/// A piston driven by a force that is given over time: up to the cycle at a phase of it, which
/// here no simulation settles to (its multiplier is about -12).
#[test]
fn a_drive_that_repeats_has_its_cycle_too_though_it_does_not_attract() {
    let mut p = hammer_of(3);
    p.drive.source = Source::Force;
    p.contact.initial_gap = 0.002;
    let (period, force) = (0.03, 1800.0);
    let input = Input::DriveForce;
    let piece = |at: f64, value: f64| Piece { at, input, derivatives: vec![value] };
    let pieces = vec![piece(0.0, force), piece(0.5 * period, -0.8 * force)];
    let schedule = Some(Schedule { period, pieces });
    let search = Search { schedule, settle: 8, ..Search::default() };
    let stiffness = named("rock.stiffness");
    let run =
        |p: &Parameters, search: &Search| find(&scene(p), search, &[stiffness]).expect("a cycle");
    let cycle = run(&p, &search);
    let response = &cycle.response;
    assert!((response.period - period).abs() < 1e-14);
    assert!(cycle.gradients[0].values.period.abs() <= cycle.gradients[0].errors.period);
    assert!(!cycle.is_stable() && cycle.steps[1] > 0, "{:?}", cycle.multipliers);
    // The largest forces are those of all its pieces.
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
    machine.restore(&cycle.state).expect("its state");
    let (start, mut peaks) = (machine.time(), [0.0f64; 2]);
    for (value, end) in [(force, 0.5 * period), (-0.8 * force, period)] {
        machine.set_input(input, &[value]).expect("a force");
        machine.advance(start + end).expect("a run");
        let largest = machine.peaks();
        peaks = [peaks[0].max(largest.contact_force()), peaks[1].max(largest.rock_force())];
    }
    let found = [response.peaks.contact_force(), response.peaks.rock_force()];
    for (found, simulated) in found.into_iter().zip(peaks) {
        // Twelve times what a return leaves of 1e-12 of the state.
        assert!((found / simulated - 1.0).abs() < 1e-9, "{found} {simulated}");
    }
    let near = Search { start: Some(cycle.orbit.clone()), settle: 0, ..search };
    let h = 1e-7 * p.rock.stiffness;
    let at = |h: f64| {
        let mut p = p;
        p.rock.stiffness += h;
        find(&scene(&p), &near, &[]).expect("a cycle").response.advance
    };
    let (coarse, fine) = ((at(h) - at(-h)) / (2.0 * h), (at(0.5 * h) - at(-0.5 * h)) / h);
    let ours = cycle.gradients[0].values.advance;
    // Solved to 1e-12 of the state, ten times which is the advance's own noise.
    let noise = 1e-11 * response.advance.abs() / h + cycle.gradients[0].errors.advance;
    let bound = 2.0 * (coarse - fine).abs() + noise;
    assert!((ours - fine).abs() <= bound, "{ours:e} {fine:e} {bound:e}");
}

#[test]
fn what_has_no_cycle_says_why() {
    let mut p = hammer_of(2);
    p.drive.source = Source::Pressure;
    assert_eq!(cycle(&p, &[]).expect_err("no schedule"), CycleError::NoSchedule);
    let schedule = Some(Schedule { period: 0.05, pieces: Vec::new() });
    let search = Search { schedule, ..Search::default() };
    let error = find(&scene(&hammer_of(2)), &search, &[]).expect_err("a relay");
    assert_eq!(error, CycleError::NotScheduled);
    let mut slow = hammer_of(2);
    (slow.drive.amplitude, slow.gravity) = (0.0, 0.0);
    let search = Search { limit: 0.5, ..Search::default() };
    let error = find(&scene(&slow), &search, &[]).expect_err("no force");
    assert_eq!(error, CycleError::NoReturn { after: 0.5, stalled: false });
}
