//! Steps that end where the piston passes a position. The bodies are rigid; the piston is thrown up against a
//! constant force, and flies in a parabola until it strikes the resting bit.

use crate::scenes::Random;
use hammer::{Fidelity, InputValues, Machine, Parameters, Source, Stops};

const SPEED: f64 = 6.0;
const FORCE: f64 = 900.0;

fn thrown() -> Machine {
    let mut p = Parameters { fidelity: Fidelity::Rigid, gravity: 0.0, ..Parameters::default() };
    (p.drive.source, p.contact.initial_gap, p.piston.initial_velocity) =
        (Source::Force, 0.05, -SPEED);
    let inputs = InputValues { drive_force: FORCE, ..InputValues::default() };
    Machine::new(&p, &inputs, 0.0).expect("a scene")
}

/// Instants, s, at which `x - SPEED t + FORCE t^2 / (2 m)` is a level, and the speeds then, m/s.
fn passages(m: &Machine, x: f64, level: f64) -> [[f64; 2]; 2] {
    let acceleration = FORCE / m.parameters().piston_mass();
    let speed = (SPEED * SPEED - 2.0 * acceleration * (x - level)).sqrt();
    [-speed, speed].map(|v| [(SPEED + v) / acceleration, v])
}

/// Height of its flight, m.
fn height(m: &Machine) -> f64 {
    0.5 * SPEED * SPEED * m.parameters().piston_mass() / FORCE
}

/// A host's `<=` and `>=` on the output decide correctly, in both directions. The instant is that of the closed form,
/// up to four roundings of a position over the speed, and four of the time.
#[test]
fn a_step_ends_at_the_passage_with_the_position_beyond_the_level() {
    let mut random = Random::new(1);
    for round in 0..300 {
        let mut m = thrown();
        let start = m.kinematics().relative.displacement;
        let level = start - random.between(1e-6, 0.999) * height(&m);
        let mut stops = Stops::new(&m, false, &[level]);
        let mut beyond = |m: &mut Machine| {
            let (_, stop) = m.advance_keeping_start(1.0, Some(&mut stops)).expect("a step");
            assert_eq!(stop.position, Some(0), "{round}");
            (m.time(), m.kinematics().relative.displacement)
        };
        let ends = [beyond(&mut m), beyond(&mut m)];
        assert!(ends[0].1 <= level && ends[1].1 >= level, "{round}: {ends:?} {level}");
        let size = start.abs() + height(&m);
        for ((time, _), [exact, speed]) in ends.into_iter().zip(passages(&m, start, level)) {
            let rounding = 4.0 * f64::EPSILON * (size / speed.abs() + exact);
            assert!((time - exact).abs() <= rounding, "{round}: {time} {exact}");
        }
    }
}

/// Two equal positions: each passage ends one step, which records both.
#[test]
fn positions_that_are_passed_together_are_noted_together() {
    let mut random = Random::new(2);
    let mut looked = 0;
    for round in 0..1000 {
        let mut m = thrown();
        let start = m.kinematics().relative.displacement;
        let level = start - random.between(0.1, 0.9) * height(&m);
        let [_, [back, _]] = passages(&m, start, level);
        let mut stops = Stops::new(&m, false, &[level, level]);
        let mut reads = Vec::new();
        while m.time() < 1.01 * back && reads.len() < 5 {
            let (_, stop) = m.advance_keeping_start(1.01 * back, Some(&mut stops)).expect("a step");
            reads.extend(stop.position.map(|_| m.kinematics().relative.displacement));
        }
        // If the output is the level itself, the next step decides which side the other position is on.
        if !reads.contains(&level) {
            assert_eq!(reads.len(), 2, "{round}: {reads:?} {level}");
            looked += 1;
        }
    }
    assert!(looked > 20, "{looked}");
}

/// If a position is where the piston is, the direction of its speed decides the side, and without speed that of its
/// acceleration. Thrown up, the piston passes there when it returns, `2 SPEED m / FORCE` later; let go, it never
/// does.
#[test]
fn a_position_where_the_piston_stands_is_passed_only_on_the_way_back() {
    let mut m = thrown();
    let start = m.kinematics().relative.displacement;
    let back = 2.0 * SPEED * m.parameters().piston_mass() / FORCE;
    let mut stops = Stops::new(&m, false, &[start]);
    let (_, stop) = m.advance_keeping_start(1.01 * back, Some(&mut stops)).expect("a step");
    // Four roundings of the position over the speed, and four of the time.
    let rounding = 4.0 * f64::EPSILON * ((start.abs() + height(&m)) / SPEED + back);
    assert_eq!(stop.position, Some(0));
    assert!((m.time() - back).abs() <= rounding, "{} {back}", m.time());

    let mut p = *thrown().parameters();
    p.piston.initial_velocity = 0.0;
    let inputs = InputValues { drive_force: FORCE, ..InputValues::default() };
    let mut m = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let falls = (2.0 * start.abs() * m.parameters().piston_mass() / FORCE).sqrt();
    let mut stops = Stops::new(&m, false, &[start]);
    let (_, stop) = m.advance_keeping_start(0.99 * falls, Some(&mut stops)).expect("a step");
    assert_eq!((stop.position, m.time()), (None, 0.99 * falls));
}

/// Positions from another machine take the sides of the present piston, unless it is so near one that its guard may
/// have either side: an event that has just ended a step must not end the next.
#[test]
fn positions_are_settled_by_where_the_piston_is_unless_it_is_at_one() {
    let mut random = Random::new(3);
    for round in 0..100 {
        let mut m = thrown();
        let start = m.kinematics().relative.displacement;
        let level = start - random.between(0.01, 0.99) * height(&m);
        let [[up, _], [back, speed]] = passages(&m, start, level);
        let mut stops = Stops::new(&m, false, &[level]);
        if round % 2 == 0 {
            m.advance(0.5 * (up + back)).expect("a step");
        } else {
            m.advance_keeping_start(1.0, Some(&mut stops)).expect("a step");
        }
        stops.settle(&m);
        let (_, stop) = m.advance_keeping_start(1.01 * back, Some(&mut stops)).expect("a step");
        assert_eq!(stop.position, Some(0), "{round}");
        let rounding = 4.0 * f64::EPSILON * ((start.abs() + height(&m)) / speed.abs() + back);
        assert!((m.time() - back).abs() <= rounding, "{round}: {} {back}", m.time());
    }
}

/// Very near a position, where the guard may have missed the piston, the stored side counts: the next step ends there
/// at once. Farther beyond, the piston has passed.
#[test]
fn a_position_that_is_just_passed_is_still_to_be_noted() {
    for (beyond, is_near) in [(1e-15, true), (1e-6, false)] {
        let mut m = thrown();
        let start = m.kinematics().relative.displacement;
        let level = start - 0.5 * height(&m);
        let [[up, _], [back, _]] = passages(&m, start, level);
        let mut stops = Stops::new(&m, false, &[level]);
        assert!(stops.are(false, &[level]) && !stops.are(true, &[level]));
        assert!(!stops.are(false, &[level, level]) && !stops.are(false, &[start]));
        m.advance(up + beyond / SPEED).expect("a step");
        assert!(m.kinematics().relative.displacement <= level);
        stops.settle(&m);
        let (_, stop) = m.advance_keeping_start(1.01 * back, Some(&mut stops)).expect("a step");
        assert_eq!(stop.position, Some(0));
        // The passages are hundredths of a second apart, and each is known as in the tests above, to some 1e-16 s.
        assert!(
            (m.time() - if is_near { up } else { back }).abs() < 1e-12,
            "{beyond}: {}",
            m.time()
        );
    }
}

/// Blows and passages of the reference hammer, one by one. The blows are those of a run without stops. At each
/// passage the output is at its level, with the piston on the other side afterwards, and none is missing.
#[test]
fn a_hammer_stops_at_every_blow_and_at_every_passage_and_nowhere_else() {
    let (p, inputs, end) = (Parameters::default(), InputValues::default(), 0.2);
    let levels = [-0.03, -0.004];
    let mut plain = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let (mut blows, mut passages) = (Vec::new(), 0);
    let sides = |m: &Machine| levels.map(|level| m.kinematics().relative.displacement > level);
    for step in 1..=20_000 {
        let before = sides(&plain);
        plain.advance(end * f64::from(step) / 2e4).expect("a step");
        blows.extend(plain.step_blows().iter().map(|blow| blow.time));
        passages += before.iter().zip(sides(&plain)).filter(|(a, b)| **a != *b).count();
    }
    let mut m = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let mut stops = Stops::new(&m, true, &levels);
    let (mut struck, mut passed) = (Vec::new(), 0);
    loop {
        let (_, stop) = m.advance_keeping_start(end, Some(&mut stops)).expect("a step");
        if !stop.any() {
            break;
        }
        struck.extend(stop.blow.then_some(m.time()));
        if let Some(index) = stop.position {
            passed += 1;
            let off = m.kinematics().relative.displacement - levels[index];
            // During the rounding of 0.2 s it moves by 5e-16 m; a passage is known to a resolution, 1e-14 m.
            assert!(off.abs() < p.resolutions()[0], "{}: {off:e}", m.time());
        }
    }
    assert_eq!((struck, passed, m.time()), (blows, passages, end));
    assert!(passed > 8);
}

/// Far from 0 a host's double names a blow's instant 1e-12 to 6e-8 s before or after it. A step that ends there, one
/// of size 0 after it and one to the next double all continue from the blow itself. No body moves back (which an
/// assertion of this build would detect), and the blows are to the bit those of a start at 0.
#[test]
fn a_host_that_stops_at_blows_far_from_zero_gets_those_of_a_start_at_zero() {
    let speeds = |p: &Parameters, start: f64| {
        let mut m = Machine::new(p, &InputValues::default(), start).expect("a scene");
        let mut stops = Stops::new(&m, true, &[]);
        let mut speeds = Vec::new();
        while speeds.len() < 5 {
            let to = start + 1.0;
            let (_, stop) = m.advance_keeping_start(to, Some(&mut stops)).expect("a step");
            assert!(stop.blow, "{start}");
            speeds.push(m.blow().expect("a blow").speed.to_bits());
            let now = m.time();
            m.advance(now).expect("a step of no length");
            m.advance(now.next_up()).expect("a step as short as can be");
        }
        speeds
    };
    let mut cased = Parameters::default();
    (cased.casing.mass, cased.casing.impedance) = (40.0, 4e3);
    let rigid = Parameters { fidelity: Fidelity::Rigid, ..cased };
    for p in [Parameters::default(), cased, rigid] {
        let near = speeds(&p, 0.0);
        for start in [1.7e4, 3.3e4 + 0.1, 1e6, 1e9] {
            assert_eq!(speeds(&p, start), near, "{start}");
        }
    }
}
