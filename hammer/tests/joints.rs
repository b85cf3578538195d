//! Loose joints of a drill string, with a casing and without: statics, balances, the limit of tight ones, and what is refused.

use crate::scenes::Random;
use hammer::Scene;
use hammer::parameters::{Drill, Joint};
use hammer::presets::Preset;
use hammer::sensitivity::{Argument, NonSmooth, Sample, derivatives};
use hammer::{
    Error, Event, Input, InputValues, Machine, Parameters, Segment, Source, State, Tie, TieState,
    Ties,
};

/// A string of unlike rods' steel, driven over 50 mm, on meshes as coarse as is allowed.
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

/// The same hung in a casing, rigid or elastic, which a string may brake; in every other round.
fn maybe_cased(random: &mut Random, round: usize) -> (Parameters, InputValues) {
    let (mut p, mut inputs) = drawn(random);
    if round.is_multiple_of(2) {
        return (p, inputs);
    }
    p.casing.mass = p.bit_mass() * random.spread(0.3, 10.0);
    if random.unit() < 0.5 {
        (p.casing.segments, p.casing.elements) = (1, 6);
        let length = random.spread(0.2, 1.0);
        let area = p.casing.mass / (p.material.density * length);
        p.casing.segment[0] = Segment { length, area };
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

/// Mass of what is above a joint, of parts that a sleeve covers half each, kg.
fn above(p: &Parameters, joint: usize) -> f64 {
    let (d, half) = (p.drill, 0.5 * p.drill.coupling.length);
    let sleeves = (2 * joint + 1) as f64 * half * d.coupling.area;
    let shank = (d.shank.length - half) * d.shank.area;
    let rods = joint as f64 * (d.rod.length - 2.0 * half) * d.rod.area;
    p.material.density * (sleeves + shank + rods)
}

/// At the start the chuck carries feed and casing less the drive's reaction; each joint that, or the feed,
/// and the weight above it, `F^2 / (2 k)` of energy each; the rock carries all.
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
        // Displacements whose differences carry up to 1e4 times less force, at rounding.
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

/// The momentum of all bodies is what feed, gravity, rock and string gave; every energy is in the ledger.
/// Some joint opens in most scenes, some thread pulls, and the bit hangs out of casings.
#[test]
fn momentum_and_energy_are_balanced_in_drawn_strings() {
    let (mut random, end) = (Random::new(2), 0.03);
    let mut met = [[0; 3]; 2];
    for round in 0..60 {
        let mut scene = maybe_cased(&mut random, round);
        // At rest before the start: a piston that is given a speed has momentum already.
        scene.0.piston.initial_velocity = 0.0;
        let (mut m, (p, inputs)) = (machine(&scene), &scene);
        m.keep_journal(true);
        let start = m.kinematics().casing_position;
        m.advance(end).expect("a run");
        let (k, sums) = (*m.kinematics(), m.impulses());
        let string = p.casing.impedance * (k.casing_position - start);
        let mut momentum = p.bit_mass() * k.bit_velocity;
        let mut fed = (inputs.feed_force + p.bit_mass() * p.gravity) * end;
        let mut given = fed + sums.contact - sums.rock;
        if p.has_casing() {
            // With the piston: of what the drive does to both nothing is left.
            momentum += p.casing_mass() * k.casing_velocity + p.piston_mass() * k.piston_velocity;
            fed += (p.casing_mass() + p.piston_mass()) * p.gravity * end;
            given = fed - sums.rock - string;
        }
        // Two roundings an event of what is summed; a basis loses up to 1e5 of them at a transition.
        let scale = fed + sums.contact + sums.rock + string.abs();
        let events = 10.0 + m.counters().events as f64;
        let rounding = 1e5 * f64::EPSILON * events * scale;
        // The string takes what its end moves, which of an elastic casing is not shown.
        let is_told = p.casing.impedance == 0.0 || p.casing.segments == 0;
        let apart = (momentum - given).abs();
        assert!(!is_told || apart < rounding, "{round}: {momentum} {given} of {rounding}");
        let energies = m.energies();
        assert!(energies.residual.abs() < 1e-10 * energies.turnover(), "{round}: {energies:?}");
        for record in m.take_journal() {
            match record.event {
                Event::Tie(Tie::Joint(_), to) => met[0][to as usize] += 1,
                Event::Tie(Tie::Chuck, to) => met[1][to as usize] += 1,
                _ => {}
            }
        }
    }
    assert!(met[0].iter().all(|&count| count > 30), "{met:?}");
    assert!(met[1].iter().all(|&count| count > 10), "{met:?}");
}

/// Without slack a joint is a spring: of ten times the stiffness its difference from a tight one is a
/// tenth, as far as both are first order in `1 / kj`, and the same events happen in both: over the
/// first wave's way, before contacts chatter.
#[test]
fn a_joint_without_slack_tends_to_a_tight_one_as_its_compliance() {
    let (mut random, end) = (Random::new(4), 5e-4);
    for round in 0..10 {
        let (mut p, inputs) = maybe_cased(&mut random, round);
        // Sleeves are one section of a tight string and two of a loose one: other meshes.
        (p.drill.coupling.length, p.drill.joint.slack) = (0.0, 0.0);
        // The relay sees the shank of a loose string, and all of a tight one.
        p.drive.source = Source::Force;
        p.piston.initial_velocity = 10.0;
        p.contact.initial_gap = 1e-3;
        let tip = |stiffness: f64| {
            let mut p = p;
            p.drill.joint.stiffness = stiffness;
            let mut m = machine(&(p, inputs));
            let steps = (1..=40).map(|k| end * f64::from(k) / 40.0);
            let tips: Vec<f64> = steps
                .map(|t| m.advance(t).map(|()| m.kinematics().bit_tip_position))
                .collect::<Result<_, _>>()
                .expect("a run");
            tips
        };
        let tight = tip(0.0);
        let apart = |stiffness: f64| {
            let squares = tip(stiffness).into_iter().zip(&tight).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>().sqrt()
        };
        let own = p.material.youngs_modulus * p.drill.rod.area / p.drill.rod.length;
        let [near, nearer] = [1e4 * own, 1e5 * own].map(apart);
        assert!((9.0..11.0).contains(&(near / nearer)), "{round}: {near:e} {nearer:e}");
    }
}

/// Rates are rates, with joints open and pulling, of what the drive sees and of the bit.
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
            // Half a step of the next rate: of two springs of 1e9 N/m at 10 m/s on 0.2 kg, 1e11 m/s3.
            for (a, b, rate) in [
                (a.relative_velocity, b.relative_velocity, a.relative_acceleration),
                (a.bit_velocity, b.bit_velocity, a.bit_acceleration),
                (a.piston_velocity, b.piston_velocity, a.piston_acceleration),
                (a.casing_velocity, b.casing_velocity, a.casing_acceleration),
            ] {
                let slope = (b - a) / step;
                assert!((slope - rate).abs() < 1e-4 * rate.abs() + 50.0, "{slope} {rate}");
            }
            // The same of accelerations up to 1e6 m/s2; displacements of up to 0.1 m are rounded to 1e-17 m.
            for (a, b, rate) in [
                (a.relative_position, b.relative_position, a.relative_velocity),
                (a.bit_position, b.bit_position, a.bit_velocity),
                (a.piston_position, b.piston_position, a.piston_velocity),
                (a.casing_position, b.casing_position, a.casing_velocity),
            ] {
                let slope = (b - a) / step;
                assert!((slope - rate).abs() < 1e-4 * rate.abs() + 1e-3, "{slope} {rate}");
            }
        }
    }
    assert!(looked > 50, "{looked}");
}

/// Tight is not the limit of soft: at 0 there is nothing to differentiate by, and elsewhere there is.
#[test]
fn a_tight_joint_has_no_derivative_by_its_stiffness_and_a_loose_one_has() {
    let mut random = Random::new(8);
    let (mut p, inputs) = drawn(&mut random);
    (p.drill.rods, p.bit.elements, p.drive.source) = (1, 28, Source::Force);
    (p.piston.initial_velocity, p.contact.initial_gap) = (5.0, 1e-3);
    (p.drill.joint.stiffness, p.drill.joint.slack) = (3e9, 1e-4);
    let by = ["drill.joint.stiffness"].map(|name| Argument::named(name).expect("a name"));
    let depth = |scene: &Scene| {
        Sample::of_run(&mut scene.machine()?, &[6e-4], &|m| vec![m.kinematics().bit_tip_position])
    };
    let rows = |parameters: Parameters| {
        derivatives(&Scene { parameters, inputs }, &by, &depth).expect("rows").remove(0)
    };
    let row = rows(p);
    let ahead = |step: f64| {
        let mut p = p;
        p.drill.joint.stiffness += step;
        let mut m = machine(&(p, inputs));
        m.advance(6e-4).expect("a run");
        m.kinematics().bit_tip_position
    };
    let slope = (ahead(3e5) - ahead(-3e5)) / 6e5;
    // The second difference of a step of 1e-4 of it.
    assert!((row.values[0] - slope).abs() < 1e-4 * slope.abs(), "{} {slope}", row.values[0]);
    p.drill.joint.stiffness = 0.0;
    let tight = rows(p).nonsmooth;
    let edges = tight.iter().filter(|why| matches!(why, NonSmooth::Edge { .. }));
    assert_eq!(edges.count(), 2, "{tight:?}");
}

/// In the engine what is above a joint is displaced while its thread pulls; nobody sees it.
#[test]
fn nothing_jumps_where_a_thread_begins_to_pull_or_ends() {
    let (mut random, aside) = (Random::new(7), 1e-9);
    let mut looked = 0;
    for round in 0..20 {
        let mut scene = maybe_cased(&mut random, round);
        scene.0.drill.joint.slack = random.spread(1e-5, 1e-3);
        let [mut m, mut other] = [0; 2].map(|_| machine(&scene));
        m.keep_journal(true);
        m.advance(0.03).expect("a run");
        let mut pulls = 0;
        for record in m.take_journal() {
            let before = std::mem::replace(
                &mut pulls,
                (0..8).filter(|k| record.mode.ties.of(Tie::Joint(*k)) == TieState::Pulled).count(),
            );
            if pulls == before || record.time - aside < other.time() {
                continue;
            }
            let [a, b] = [-aside, aside].map(|by| {
                other.advance(record.time + by).expect("a run");
                let (k, profile) = (*other.kinematics(), other.profile());
                let ends = [profile.piston[0][0], profile.bit[0][0]];
                let casing = k.casing_position;
                [k.piston_position, k.bit_position, k.relative_position, casing, ends[0], ends[1]]
            });
            looked += 1;
            // 2e-9 s at less than 50 m/s; a slack is a hundred times as long.
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() < 1e-7, "{round} {}: {a} {b}", record.event);
            }
        }
    }
    assert!(looked > 30, "{looked}");
}

/// A wave of tension `r t^2` comes down the shank to a loose joint, whose faces it parts at twice the wave's
/// speed, `2 r t^2 / Z`, as at a free end, until they are apart by the slack: after
/// `(3 Z slack / (2 r))^(1/3)`. The mesh carries what is slower than `w = 2 c / h`; of the kink `2 r` in the
/// wave it leaves `2 r / w^3` in the faces' place over `Z / 2`, which is 1e-9 s of their way, and damping
/// makes `t^2` of the wave `t^2 + beta t0`: as little.
#[test]
fn a_thread_begins_to_pull_where_the_faces_are_apart_by_the_slack() {
    const AREA: f64 = 1.4e-3;
    const RATE: f64 = 4e12;
    let part = |length| Segment { length, area: AREA };
    for slack in [2e-5, 1e-4, 3e-4] {
        let mut p = Parameters { gravity: 0.0, ..Parameters::default() };
        p.drill.rods = 1;
        (p.drill.shank, p.drill.rod, p.drill.coupling) = (part(1.2), part(0.7), part(0.0));
        (p.drill.joint.stiffness, p.drill.joint.slack) = (1.2e9, slack);
        (p.piston.segments, p.piston.segment[0], p.piston.elements) = (1, part(1.0), 100);
        (p.bit.segments, p.bit.segment[0], p.bit.elements) = (1, part(0.5), 240);
        (p.mesh.degree, p.material.damping_time, p.drive.source) = (5, 2e-9, Source::Force);
        (p.contact.initial_gap, p.rock.stiffness, p.rock.viscosity) = (1.0, 1.0, 0.0);
        let mut m = machine(&(p, InputValues { feed_force: 0.0, ..InputValues::default() }));
        m.keep_journal(true);
        m.set_input(Input::FeedForce, &[0.0, 0.0, -2.0 * RATE]).expect("an input");
        let parted = (1.5 * p.impedance_of(AREA) * slack / RATE).cbrt();
        let exact = 1.2 / p.wave_speed() + parted;
        m.advance(exact + 0.1 * parted).expect("a run");
        let pulls = |event| matches!(event, Event::Tie(Tie::Joint(_), TieState::Pulled));
        let found = m.take_journal().into_iter().find(|record| pulls(record.event));
        let time = found.expect("a pull").time;
        assert!((time - exact).abs() < 1e-8, "{slack}: {time} {exact}");
    }
}

/// A joint that is pulled at the start, one that is too soft, a tie that the scene lacks.
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
    let mut m = machine(&(p, inputs));
    m.advance(0.01).expect("a run");
    let mut forged: serde_json::Value = serde_json::to_value(m.state()).expect("text");
    forged["motion"]["mode"]["ties"][10] = serde_json::to_value(TieState::Pulled).expect("a tie");
    let state: State = serde_json::from_value(forged).expect("a state");
    let before = m.state();
    assert_eq!(m.restore(&state), Err(Error::Foreign));
    assert_eq!(m.state(), before);
}

/// Read often, each stretch finds no forms of the one before.
#[test]
fn forms_that_go_on_from_stretch_to_stretch_change_no_bit() {
    let (mut parameters, inputs) = Preset::named("top_hammer").expect("a preset").start();
    parameters.drill.joint.stiffness = 3e9;
    let scene = Scene { parameters, inputs };
    let [mut once, mut often] = [(); 2].map(|()| scene.machine().expect("a scene"));
    for step in 1..=60 {
        let time = 5e-4 * f64::from(step);
        once.advance(time).expect("a step");
        often.advance(time).expect("a step");
        assert!(often.energies().damping >= 0.0);
    }
    assert!(once.counters().events > 300, "{:?}", once.counters());
    assert_eq!(once.energies(), often.energies());
}
