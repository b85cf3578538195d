//! A hammer driven by chambers: closed forms, the ledger, slices, what is refused.

use hammer::parameters::{ChamberLaws, PortLaw};
use hammer::periodic::{Search, find};
use hammer::sensitivity::{Argument, Sample, Scene, derivatives};
use hammer::{Chamber, Event, Fidelity, InputValues, Machine, Parameters, Port, Source};

/// The reference hammer, driven by chambers.
fn driven() -> Parameters {
    let mut parameters = Parameters::default();
    parameters.drive.source = Source::Chambers;
    parameters
}

/// A machine at the start of a scene.
fn machine(parameters: &Parameters) -> Machine {
    Machine::new(parameters, &InputValues::default(), 0.0).expect("a scene")
}

/// Ports that make no pressure.
fn idle() -> ChamberLaws {
    let mut laws = Parameters::default().chambers;
    for chamber in [&mut laws.drive, &mut laws.returning] {
        for port in [&mut chamber.supply, &mut chamber.exhaust] {
            *port = PortLaw {
                position: port.position,
                open_pressure: 0.0,
                open_time: 0.0,
                shut_pressure: 0.0,
                shut_time: 0.0,
            };
        }
    }
    laws
}

/// A free piston under a constant pressure, then one that falls in a straight line: a parabola,
/// then a cubic.
#[test]
fn a_piston_follows_its_pressures_in_closed_form() {
    let mut parameters = Parameters { fidelity: Fidelity::Rigid, gravity: 0.0, ..driven() };
    parameters.chambers = idle();
    let supply = &mut parameters.chambers.drive.supply;
    (supply.open_pressure, supply.shut_pressure, supply.shut_time) = (12e5, 3e5, 1e-3);
    let position = supply.position;
    let (mass, area) = (parameters.piston_mass(), parameters.drive.area_drive);
    let mut hammer = machine(&parameters);
    hammer.keep_journal(true);
    let from = hammer.kinematics().relative_position;
    // x = a t^2 / 2 up to the port; then F = A (p0 + (p1 - p0) s / T).
    let pushed = 12e5 * area / mass;
    let passes = (2.0 * (position - from) / pushed).sqrt();
    let speed = pushed * passes + area * (12e5 + 3e5) / 2.0 * 1e-3 / mass;
    let place =
        position + pushed * passes * 1e-3 + area * (12e5 / 2.0 + (3e5 - 12e5) / 6.0) * 1e-6 / mass;
    hammer.advance(passes + 1e-3).expect("a step");
    let events: Vec<Event> = hammer.take_journal().iter().map(|r| r.event).collect();
    let closes = Event::Port { chamber: Chamber::Drive, port: Port::Supply, opens: false };
    assert!(events.contains(&closes), "{events:?}");
    let kinematics = *hammer.kinematics();
    // Sums of a few terms, and an instant known to the rounding of 1e-14 m over 10 m/s.
    assert!((kinematics.piston_velocity - speed).abs() < 1e-12 * speed);
    assert!((kinematics.relative_position - place).abs() < 1e-14 + 1e-13 * place.abs());
    // The work of the drive is what the piston has.
    let energy = 0.5 * mass * speed * speed;
    assert!((hammer.energies().drive - energy).abs() < 1e-12 * energy);
    let [drive, back] = hammer.chamber_pressures();
    assert!((drive[0] - 3e5).abs() < 1e-6 && back == [0.0; 2], "{drive:?}");
}

/// Both ports of a chamber at one place, or a rounding apart on either side, passed downward and back:
/// whichever turns first by rounding, the pressure is that of the one that is open then.
#[test]
fn of_two_ports_at_one_place_the_open_one_has_the_pressure() {
    let place = Parameters::default().chambers.drive.supply.position;
    for chamber in Chamber::ALL {
        for apart in [place.next_down(), place, place.next_up()] {
            let mut p = Parameters { fidelity: Fidelity::Rigid, gravity: 0.0, ..driven() };
            p.chambers = idle();
            let laws = &mut p.chambers;
            let law = if chamber == Chamber::Drive { &mut laws.drive } else { &mut laws.returning };
            for (port, number, at) in
                [(&mut law.supply, 1.0, place), (&mut law.exhaust, 2.0, apart)]
            {
                // What shuts would jump.
                (port.position, port.open_pressure, port.shut_pressure) =
                    (at, number, 10.0 * number);
            }
            p.piston.initial_velocity = 5.0;
            let mut hammer = machine(&p);
            let from = hammer.kinematics().relative_position;
            let passes = (place - from) / 5.0;
            let read = |hammer: &Machine| hammer.chamber_pressures()[chamber as usize];
            let above = read(&hammer);
            hammer.advance(passes + 1e-4).expect("a step");
            let below = read(&hammer);
            assert!(hammer.kinematics().relative_position > place);
            // It meets the bit and comes back.
            while hammer.kinematics().relative_position > place - 1e-3 {
                hammer.advance(hammer.time() + 1e-3).expect("a step");
                assert!(hammer.time() < 0.1, "back by now");
            }
            let expected = if chamber == Chamber::Drive { [1.0, 2.0] } else { [2.0, 1.0] };
            assert_eq!([above, below], expected.map(|pressure| [pressure, 0.0]), "{apart}");
            assert_eq!(read(&hammer), above, "{apart}");
        }
    }
}

#[test]
fn the_level_is_reached_at_its_time_and_held() {
    let mut parameters = Parameters { fidelity: Fidelity::Rigid, gravity: 0.0, ..driven() };
    parameters.chambers = idle();
    let supply = &mut parameters.chambers.drive.supply;
    (supply.open_pressure, supply.shut_pressure, supply.shut_time) = (12e5, 3e5, 2.5e-4);
    let mut hammer = machine(&parameters);
    hammer.keep_journal(true);
    let mut journal = Vec::new();
    let reached = Event::Level(Chamber::Drive);
    while !journal.iter().any(|r: &hammer::Record| r.event == reached) {
        assert!(hammer.time() < 0.02);
        hammer.advance(hammer.time() + 1e-4).expect("a step");
        journal.extend(hammer.take_journal());
    }
    let closes = Event::Port { chamber: Chamber::Drive, port: Port::Supply, opens: false };
    let when = |event| journal.iter().find(|r| r.event == event).expect("it").time;
    // The difference of two instants, each rounded.
    assert!((when(reached) - when(closes) - 2.5e-4).abs() < 4.0 * f64::EPSILON * 0.02);
    let force = hammer.kinematics().applied_drive_force;
    assert!((force - 3e5 * parameters.drive.area_drive).abs() < 1e-12 * force);
}

#[test]
fn the_default_chambers_drill_and_their_energies_balance() {
    let mut hammer = machine(&driven());
    hammer.advance(0.5).expect("a run");
    let energies = hammer.energies();
    assert!(energies.residual.abs() <= energies.residual_bound(), "{energies:?}");
    assert!(hammer.counters().blows > 10 && hammer.kinematics().tip_depth > 1e-3);
    assert!(!hammer.stalled());
}

#[test]
fn neither_slices_nor_a_stored_state_show() {
    let mut parameters = driven();
    (parameters.piston.elements, parameters.bit.elements) = (6, 5);
    let (mut one, mut many) = (machine(&parameters), machine(&parameters));
    one.advance(0.08).expect("a run");
    let mut step = 1e-6;
    while many.time() < 0.08 {
        let to = (many.time() + step).min(0.08);
        many.advance(to).expect("a step");
        // A look, and a state that goes through bytes, between any two.
        many.energies();
        let bytes = serde_json::to_vec(&many.state()).expect("bytes");
        let state = serde_json::from_slice(&bytes).expect("a state");
        let mut fresh = machine(&parameters);
        fresh.restore(&state).expect("restored");
        many = fresh;
        step *= 1.09;
    }
    let bytes =
        |machine: &Machine| serde_json::to_vec(&machine.state().without_step()).expect("bytes");
    assert_eq!(bytes(&one), bytes(&many));
    assert_eq!(one.chamber_pressures(), many.chamber_pressures());
}

#[test]
fn a_piston_that_no_pressure_lifts_comes_to_rest_and_says_so() {
    let mut parameters = driven();
    parameters.chambers = idle();
    // Pressed down, and damped so that it does not bounce for long.
    parameters.chambers.drive.exhaust.open_pressure = 5e5;
    parameters.material.damping_time = 2e-5;
    (parameters.piston.elements, parameters.bit.elements) = (2, 2);
    parameters.contact.initial_gap = 1e-3;
    let mut hammer = machine(&parameters);
    hammer.advance(2.0).expect("a run");
    assert!(hammer.stalled(), "{:?}", hammer.kinematics());
    let before = hammer.counters().events;
    hammer.advance(4.0).expect("a run");
    assert_eq!(hammer.counters().events, before);
}

/// The same drive without its reach: constant pressures on the areas, so that the first fall has
/// `x = a t^2 / 2` with `a = G + p A / Mp`, and `dx/dA = p t^2 / 2 Mp`.
#[test]
fn a_fall_under_constant_pressure_has_the_derivatives_of_its_closed_form() {
    let mut parameters = driven();
    parameters.fidelity = Fidelity::Rigid;
    let scene = Scene { parameters, ..Scene::default() };
    let t = 2e-3;
    let run = |scene: &Scene| {
        Sample::of_run(&mut scene.machine()?, &[t], &|m| vec![m.kinematics().piston_position])
    };
    let area = Argument::named("drive.area_drive").expect("a row");
    let level = Argument::named("chambers.drive.supply.open_pressure").expect("a row");
    let found = derivatives(&scene, &[area, level], &run).expect("runs");
    let push = 0.5 * t * t / parameters.piston_mass();
    let pressure = parameters.chambers.drive.supply.open_pressure;
    for (row, exact) in found.iter().zip([pressure * push, parameters.drive.area_drive * push]) {
        assert!((row.values[0] - exact).abs() <= row.errors[0], "{row:?} {exact:e}");
        assert!(row.errors[0] < 1e-5 * exact, "{row:?}");
    }
}

/// Damped by half a percent of the first mode, as the named hammers are where they repeat.
#[test]
fn chambers_have_a_cycle_which_simulations_settle_to() {
    let mut parameters = driven();
    (parameters.piston.elements, parameters.bit.elements) = (4, 4);
    parameters.material.damping_time = 1e-6;
    let scene = Scene { parameters, ..Scene::default() };
    let feed = Argument::named("feed_force").expect("an input");
    let cycle =
        find(&scene, &Search { settle: 20, ..Search::default() }, &[feed]).expect("a cycle");
    let mut hammer = machine(&parameters);
    hammer.advance(4.0).expect("a run");
    let blow = *hammer.blow().expect("a blow");
    assert!(cycle.is_stable(), "{:?}", cycle.multipliers);
    // What is left of the start after ninety blows, and of the run's rounding.
    assert!((cycle.response.period / blow.period - 1.0).abs() < 1e-9);
    assert!((cycle.response.advance / blow.penetration - 1.0).abs() < 1e-8);
    // The same by solved cycles at two values, 0.02 % apart.
    let at = |part: f64| {
        let scene = feed.at(&scene, feed.value(&scene) * part);
        let start = Some(cycle.orbit.clone());
        let search = Search { start, settle: 5, multipliers: 0, ..Search::default() };
        find(&scene, &search, &[]).expect("a cycle nearby").response.advance
    };
    let difference = (at(1.0001) - at(0.9999)) / (2e-4 * feed.value(&scene));
    let slope = cycle.gradients[0].values.advance;
    assert!((slope / difference - 1.0).abs() < 1e-4, "{slope:e} {difference:e}");
}

#[test]
fn a_port_out_of_its_domain_is_named_where_it_is_read() {
    let mut parameters = driven();
    parameters.chambers.returning.exhaust.shut_time = -1e-3;
    let refused = parameters.validate().expect_err("a negative time");
    assert_eq!(refused.name, "chambers.return.exhaust.shut_time");
    parameters.drive.source = Source::Relay;
    assert!(parameters.validate().is_ok());
}

#[test]
fn ports_that_are_open_at_once_are_told() {
    let mut parameters = driven();
    parameters.chambers.drive.supply.position = -0.01;
    let warnings = machine(&parameters).warnings().join(" ");
    assert!(warnings.contains("supply and exhaust of the drive chamber"), "{warnings}");
}

/// A return chamber at 8 bar on 1000 mm2 of the bit, 5 bar above its exhaust: constant pressures.
fn pressed(casing: f64) -> Parameters {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..driven() };
    p.chambers = idle();
    let law = &mut p.chambers.returning;
    for port in [&mut law.supply, &mut law.exhaust] {
        (port.open_pressure, port.shut_pressure) = (8e5, 8e5);
    }
    // It is read where the exhaust is shut, and no port is reached within the test.
    (law.supply.position, law.exhaust.position) = (-1.0, -0.5);
    law.exhaust.open_pressure = 3e5;
    p.chambers.drive.supply.position = 0.5;
    p.drive.anvil_area = 1e-3;
    p.casing.mass = casing;
    p
}

/// The bit rests on the rock under feed, weight and the chamber's 500 N; in a casing these are
/// taken from the shoulder, as the forces on piston, bit and casing add up to zero. Sums of a few
/// forces and displacements under them: a rounding of the largest, and of a shoulder of 1e9 N/m at
/// 1e-6 m.
#[test]
fn the_return_chamber_presses_on_the_bit_and_the_casing_carries_the_rest() {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs();
    let p = pressed(0.0);
    let hammer = machine(&p);
    let weight = p.gravity * p.bit_mass();
    assert!(close(hammer.kinematics().rock_force, 5000.0 + weight + 500.0));
    let p = pressed(30.0);
    let hammer = machine(&p);
    let (drive, carried) = (hammer.kinematics().applied_drive_force, 5000.0 + 30.0 * p.gravity);
    assert!(drive < 0.0, "it lifts the piston");
    assert!(close(hammer.kinematics().chuck_force, carried - drive - 500.0));
    assert!(close(hammer.kinematics().rock_force, carried - drive + weight));
}

/// The force belongs to the balance of energy, whether the bit flies, stands, or is struck, with a
/// casing, and while its pressure runs along straight lines.
#[test]
fn a_chamber_that_presses_on_the_bit_keeps_the_balance_of_energy() {
    for (casing, fidelity) in
        [(0.0, Fidelity::Rigid), (0.0, Fidelity::Elastic), (30.0, Fidelity::Elastic)]
    {
        let mut p = Parameters { fidelity, ..driven() };
        (p.casing.mass, p.drive.anvil_area) = (casing, 1e-3);
        let mut hammer = machine(&p);
        hammer.advance(0.15).expect("a step");
        let (with, energies) = (hammer.counters(), hammer.energies());
        assert!(with.blows >= 3, "{casing} {with:?}");
        assert!(energies.residual.abs() < energies.residual_bound(), "{casing} {energies:?}");
        p.drive.anvil_area = 0.0;
        let mut without = machine(&p);
        without.advance(0.15).expect("a step");
        assert!((without.energies().drive - energies.drive).abs() > 0.01, "it does work");
    }
}
