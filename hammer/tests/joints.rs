//! Loose joints of a drill string, with a casing and without: statics, rates, and refusals.

use crate::scenes::Random;
use hammer::{Drill, Joint};
use hammer::{Error, InputValues, Kinematics, Machine, Parameters, Segment, Tie, TieState, Ties};

/// A string of random rods, driven over 50 mm, on meshes as coarse as allowed.
fn drawn(random: &mut Random) -> (Parameters, InputValues) {
    let mut p = Parameters::default();
    p.mesh.degree = 3;
    p.piston.elements = 4;
    p.piston.length = random.between(0.3, 0.6);
    p.cross_section = random.spread(8e-4, 3e-3);
    p.bit.length = random.between(0.05, 0.3);
    p.drill.rods = 1 + (4.0 * random.unit()) as usize;
    let part = |random: &mut Random, low, high| Segment {
        length: random.between(low, high),
        area: random.spread(8e-4, 3e-3),
    };
    (p.drill.shank, p.drill.rod) = (part(random, 0.3, 0.6), part(random, 0.4, 1.5));
    p.drill.coupling = part(random, 0.05, 0.2);
    if random.unit() < 0.3 {
        p.drill.coupling.length = 0.0;
    }
    p.bit.elements = 14 * (p.drill.rods + 1);
    p.material.damping_time = if random.unit() < 0.2 { 0.0 } else { 2e-7 };
    p.gravity = random.between(0.0, 9.81);
    p.drill.joint.stiffness = random.spread(1e8, 1e11);
    p.drill.joint.slack = if random.unit() < 0.2 { 0.0 } else { random.spread(1e-6, 1e-3) };
    let feed_force = random.spread(10.0, 2e4);
    (p, InputValues { feed_force, ..InputValues::default() })
}

/// The same in a casing, rigid or elastic, with or without a string above; in every other round.
fn maybe_cased(random: &mut Random, round: usize) -> (Parameters, InputValues) {
    let (mut p, mut inputs) = drawn(random);
    if round.is_multiple_of(2) {
        return (p, inputs);
    }
    p.casing.mass = p.bit_mass() * random.spread(0.3, 10.0);
    if random.unit() < 0.5 {
        p.casing.elements = 6;
        let length = random.spread(0.2, 1.0);
        let area = p.casing.mass / (p.material.density * length);
        p.casing.segments.set(&[Segment { length, area }]);
    }
    if random.unit() < 0.6 {
        p.casing.impedance = random.spread(10.0 * p.casing_mass(), 1e5);
    }
    p.chuck.stiffness = random.spread(1e8, 1e11);
    p.chuck.viscosity = if random.unit() < 0.3 { 0.0 } else { random.spread(1e2, 1e5) };
    p.chuck.travel = random.spread(1e-4, 1e-2);
    p.chuck.idle_travel = if random.unit() < 0.5 { 0.0 } else { 0.7 * p.chuck.travel };
    inputs.feed_force += (p.drive.amplitude - p.casing_mass() * p.gravity).max(0.0);
    (p, inputs)
}

fn machine((p, inputs): &(Parameters, InputValues)) -> Machine {
    Machine::new(p, inputs, 0.0).expect("a scene")
}

/// Mass above a joint, of which each sleeve belongs in halves to both sides, kg.
fn above(p: &Parameters, joint: usize) -> f64 {
    let (d, half) = (p.drill, 0.5 * p.drill.coupling.length);
    let sleeves = (2 * joint + 1) as f64 * half * d.coupling.area;
    let shank = (d.shank.length - half) * d.shank.area;
    let rods = joint as f64 * (d.rod.length - 2.0 * half) * d.rod.area;
    p.material.density * (sleeves + shank + rods)
}

/// At the start the chuck carries the feed and the casing less the drive's reaction. Each joint carries that force,
/// or the feed, and the weight above it, with an energy of `F^2 / (2 k)`; the rock carries everything.
#[test]
fn each_joint_starts_with_the_feed_and_the_weight_above_it() {
    let mut random = Random::new(1);
    for round in 0..80 {
        let scene = maybe_cased(&mut random, round);
        let (m, (p, inputs)) = (machine(&scene), &scene);
        let reaction = if p.has_casing() { p.drive.amplitude } else { 0.0 };
        let held = inputs.feed_force + p.casing_mass() * p.gravity - reaction;
        let chuck = p.has_casing().then_some((held, p.chuck.stiffness));
        let joints = (0..p.drill.rods)
            .map(|joint| (held + above(p, joint) * p.gravity, p.drill.joint.stiffness));
        // Rounding of displacements whose differences carry up to 1e4 times less force.
        let close = 1e-9 * (inputs.feed_force + reaction);
        let (mut known, mut allowed) = (0.0, 0.0);
        for (force, stiffness) in chuck.into_iter().chain(joints) {
            known += force * force / (2.0 * stiffness);
            allowed += close * force / stiffness;
        }
        let found = m.energies().contact;
        assert!((found - known).abs() < allowed, "{round}: {found} {known} by {allowed}");
        let rock = held + p.bit_mass() * p.gravity;
        assert!((m.kinematics().rock_force - rock).abs() < close, "{round}");
        let carried = if p.has_casing() { held } else { 0.0 };
        assert!((m.kinematics().chuck_force - carried).abs() < close, "{round}");
        let mode = m.mode().with(Tie::Chuck, TieState::Open);
        assert_eq!(mode.ties, Ties::START);
    }
}

/// Rates are the slopes of positions, with joints open and pulling, for the drive's relative position and for the
/// bit.
#[test]
fn the_rates_of_positions_are_their_slopes() {
    let (mut random, step) = (Random::new(5), 1e-9);
    let mut looked = 0;
    for round in 0..50 {
        let mut scene = maybe_cased(&mut random, round);
        (scene.0.contact.stiffness, scene.0.drill.joint.stiffness) = (1e9, random.spread(1e8, 1e9));
        let mut m = machine(&scene);
        for k in 1..40 {
            let at = 5e-4 * f64::from(k);
            m.advance(at).expect("a run");
            let (a, events) = (*m.kinematics(), m.counters().events);
            let strained = m.mode().ties.with(Tie::Contact, TieState::Open) != Ties::START;
            m.advance(at + step).expect("a run");
            let b = *m.kinematics();
            if m.counters().events > events || !strained {
                continue;
            }
            looked += 1;
            let rates = |k: &Kinematics| {
                [
                    [k.relative.displacement, k.relative.velocity, k.relative.acceleration],
                    [k.bit.displacement, k.bit.velocity, k.bit.acceleration],
                    [k.piston.displacement, k.piston.velocity, k.piston.acceleration],
                    [k.casing.displacement, k.casing.velocity, k.casing.acceleration],
                ]
            };
            for (a, b) in rates(&a).into_iter().zip(rates(&b)) {
                // Half a step of the next rate: with two springs of 1e9 N/m at 10 m/s on 0.2 kg, 1e11 m/s3, and
                // accelerations up to 1e6 m/s2. Displacements of up to 0.1 m are rounded to 1e-17 m.
                for (k, allowed) in [1e-3, 50.0].into_iter().enumerate() {
                    let (slope, rate) = ((b[k] - a[k]) / step, a[k + 1]);
                    assert!((slope - rate).abs() < 1e-4 * rate.abs() + allowed, "{slope} {rate}");
                }
            }
        }
    }
    assert!(looked > 50, "{looked}");
}

/// A joint that would be pulled at the start, and one that is too soft.
#[test]
fn strings_that_cannot_be_are_refused_by_name() {
    let mut random = Random::new(6);
    let (mut p, inputs) = drawn(&mut random);
    (p.gravity, p.drill.joint.slack) = (9.81, 1e-4);
    let lifted = InputValues { feed_force: -above(&p, 0) * p.gravity - 1.0, ..inputs };
    let refused = Machine::new(&p, &lifted, 0.0).expect_err("pulled");
    assert!(
        matches!(refused, Error::TiePulled { tie: Tie::Joint(0), force } if (force + 1.0).abs() < 1e-9)
    );
    assert!(refused.to_string().starts_with("joint 1 of the drill string"), "{refused}");
    let tied = Parameters {
        drill: Drill { joint: Joint { slack: 0.0, ..p.drill.joint }, ..p.drill },
        ..p
    };
    assert!(Machine::new(&tied, &lifted, 0.0).is_ok(), "held both ways");
    let mut soft = p;
    let own = p.material.youngs_modulus * p.drill.rod.area / p.drill.rod.length;
    soft.drill.joint.stiffness = 0.999e-3 * own;
    let refused = Machine::new(&soft, &inputs, 0.0).expect_err("no joint").to_string();
    assert!(
        refused.contains("0, or at least") && refused.contains("of a rod's own stiffness"),
        "{refused}"
    );
    soft.drill.joint.stiffness = 1.001e-3 * own;
    let mut softest = machine(&(soft, inputs));
    softest.advance(0.02).expect("a run");
    let energies = softest.energies();
    assert!(energies.residual.abs() < 1e-10 * energies.turnover(), "{energies:?}");
}
