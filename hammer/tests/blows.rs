//! Blows, counted independently from the finely sampled motion and the definition.

use crate::scenes::{Random, overdamped};
use hammer::{Fidelity, InputValues, Machine, Parameters, Source};

/// A collision by its definition: closings within `2 (T1 + T2)` of the last opening are one.
#[derive(Clone, Debug)]
struct Collision {
    time: f64,
    piston: f64,
    relative: f64,
    hole: f64,
    /// Places of the piston's mean in the hole since the previous collision, the last at this one, m.
    way: Vec<f64>,
}

/// All collisions of a scene, sampled every 20 us and on both sides of each closing.
fn collisions(p: &Parameters, inputs: &InputValues, until: f64) -> Vec<Collision> {
    let mut scout = Machine::new(p, inputs, 0.0).expect("a scene");
    scout.keep_journal(true);
    scout.advance(until).expect("a run");
    let transits = p.timescales();
    let same = 2.0 * (transits.piston_transit + transits.bit_transit);
    let (mut list, mut opened, mut closed) = (Vec::new(), f64::NEG_INFINITY, false);
    let mut machine = Machine::new(p, inputs, 0.0).expect("a scene");
    let mut way = vec![machine.kinematics().piston.displacement];
    for record in scout.take_journal() {
        if !record.event.is_contact() {
            continue;
        }
        while machine.time() + 2e-5 < record.time {
            machine.advance(machine.time() + 2e-5).expect("a step");
            way.push(machine.kinematics().piston.displacement);
        }
        // Just before it; nothing happens within 1e-12 s.
        machine.advance((record.time - 1e-12).max(machine.time())).expect("a step");
        let k = *machine.kinematics();
        way.push(k.piston.displacement);
        closed = !closed;
        if !closed {
            opened = record.time;
        } else if record.time - opened > same {
            list.push(Collision {
                time: record.time,
                piston: k.piston.velocity,
                relative: k.relative.velocity,
                hole: k.tip_depth,
                way: std::mem::take(&mut way),
            });
        }
    }
    list
}

/// The blows among collisions: of the falling piston, fast enough, after a rise of a fiftieth of the fall to the blow
/// before. After eight times the wait for that blow any rise will do.
fn blows(collisions: &[Collision], minimum: f64) -> Vec<Collision> {
    let (mut list, mut way, mut before, mut began) = (Vec::new(), Vec::new(), None, 0.0);
    for c in collisions {
        way.extend(&c.way);
        let (mut lowest, mut rise) = (f64::NEG_INFINITY, 0.0_f64);
        for place in &way {
            lowest = lowest.max(*place);
            rise = rise.max(lowest - place);
        }
        let (highest, wait) = (way.iter().copied().fold(f64::INFINITY, f64::min), c.time - began);
        let fresh = before.is_none_or(|(fall, last_wait)| {
            rise >= fall / 50.0 || rise > 0.0 && wait > 8.0 * last_wait
        });
        if c.piston > 0.0 && fresh && c.relative >= minimum {
            let place = c.way[c.way.len() - 1];
            list.push(c.clone());
            (before, began, way) = (Some((place - highest, wait)), c.time, vec![place]);
        }
    }
    list
}

fn unequal(piston: f64, bit: f64) -> Parameters {
    let mut p = overdamped();
    (p.piston.length, p.bit.length) = (piston, bit);
    p
}

/// Compares counts, periods and advances of a scene with the definition.
fn check(p: &Parameters, inputs: &InputValues, until: f64) -> (usize, usize) {
    let all = collisions(p, inputs, until);
    let expected = blows(&all, p.blow.minimum_speed);
    let mut machine = Machine::new(p, inputs, 0.0).expect("a scene");
    machine.advance(until).expect("a run");
    assert_eq!(machine.counters().contacts as usize, all.len());
    assert_eq!(machine.counters().blows as usize, expected.len());
    if let [.., before, last] = &expected[..] {
        let blow = machine.blow().expect("a blow");
        // Instants are sums of two numbers, known to 1e-15 s. The hole is read 1e-12 s early, during which it does
        // not change.
        let (period, advance) = (last.time - before.time, last.hole - before.hole);
        assert!((blow.time - last.time).abs() < 1e-14);
        assert!((blow.period - period).abs() < 1e-14, "{} {period}", blow.period);
        assert!((blow.penetration - advance).abs() < 1e-12, "{} {advance}", blow.penetration);
        assert!((blow.tip_rate - advance / period).abs() < 1e-10);
        assert!((blow.speed - last.relative).abs() < 1e-6, "{} {}", blow.speed, last.relative);
        // The definition, whose product is rounded three times.
        let energy = 0.5 * p.piston_mass() * blow.speed * blow.speed;
        assert!(
            (blow.energy / energy - 1.0).abs() < 4.0 * f64::EPSILON,
            "{} {energy}",
            blow.energy
        );
    }
    (all.len(), expected.len())
}

#[test]
fn the_bit_s_rebound_belongs_to_the_blow() {
    let (collisions, blows) = check(&Parameters::default(), &InputValues::default(), 0.4);
    assert_eq!(collisions, 2 * blows);
}

/// Unequal and stepped bodies under various feeds and forces, with falls, bounces and rebounds.
#[test]
fn drawn_hammers_strike_as_many_blows_as_the_definition_says() {
    let mut random = Random::new(17);
    let (mut more, mut none) = (0, 0);
    for case in 0..24 {
        let mut p = unequal(random.between(0.1, 0.4), random.between(0.1, 0.4));
        (p.piston.elements, p.bit.elements) = (8, 8);
        p.rock.stiffness *= (2.0 * random.unit()).exp();
        p.blow.minimum_speed = [1.0, 0.0, 3.0][case % 3];
        if case % 4 == 1 {
            p.mesh.degree = 3;
            p.piston.segments.set_count(3);
            p.piston.segments[0].area *= 2.0;
            p.piston.segments[1].length *= 4.0 * random.unit() + 0.1;
        }
        if case % 4 == 2 {
            // A steady push, under which bounces die away.
            p.drive.source = Source::Force;
        }
        let inputs = InputValues {
            feed_force: random.between(0.0, 1e4),
            drive_force: random.between(300.0, 2300.0),
            ..InputValues::default()
        };
        let (collisions, blows) = check(&p, &inputs, 0.25);
        more += usize::from(collisions > 2 * blows);
        none += usize::from(blows == 0);
    }
    // The draws include falls of several collisions, and each has blows.
    assert!(more >= 5 && none == 0, "{more} {none}");
}

/// The first impact is at `sqrt(2 (F0/Mp + G) g0)`, 7.3 m/s.
#[test]
fn what_is_slower_than_the_minimum_is_no_blow() {
    let mut p = Parameters::default();
    for (minimum, blows) in [(0.0, 1), (7.0, 1), (8.0, 0)] {
        p.blow.minimum_speed = minimum;
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        machine.advance(0.02).expect("a run");
        assert_eq!(machine.counters().blows, blows, "{minimum}");
        assert_eq!(machine.counters().contacts, 2);
    }
}

/// Free rigid masses separate after half a period of the spring between them, `pi sqrt(m / k)` with
/// `1 / m = 1 / mp + 1 / mb`. The rock, whose stiffness is `r` of that spring's, changes this by less than `r`.
#[test]
fn rigid_masses_are_in_contact_for_half_a_swing_of_its_spring() {
    for (piston, bit) in [(0.25, 0.21), (0.2, 0.4)] {
        let mut p = Parameters { fidelity: Fidelity::Rigid, gravity: 0.0, ..unequal(piston, bit) };
        (p.drive.source, p.piston.initial_velocity) = (Source::Force, 8.0);
        let stiffness = p.meeting_stiffness();
        (p.rock.stiffness, p.rock.viscosity) = (1e-6 * stiffness, 0.0);
        let mut m = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        let apart = m.kinematics().relative.displacement.abs() / p.piston.initial_velocity;
        let mass = 1.0 / (1.0 / p.piston_mass() + 1.0 / p.bit_mass());
        let half = std::f64::consts::PI * (mass / stiffness).sqrt();
        assert_eq!(m.contact_duration(), 0.0);
        m.advance(apart + 1.5 * half).expect("a blow");
        let ratio = m.contact_duration() / half;
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
        assert_eq!(m.blow().map(|blow| blow.contact_duration), Some(m.contact_duration()));
    }
}
