//! The hammer in its casing: statics, balances, the string's dashpot, idling.

use crate::scenes::{Random, cased, machine, overdamped};
use hammer::{
    Body, Error, Event, Fidelity, Input, InputValues, Machine, Parameters, Record, Relay, Segment,
    Source, State, Tie, TieState,
};

/// A casing of any weight, chuck and string, and a feed that holds it down.
fn drawn(random: &mut Random, stepped: bool) -> (Parameters, f64) {
    let mut p = if stepped { random.stepped() } else { random.scene() };
    p.gravity = random.between(0.0, 9.81);
    p.casing.mass = p.bit_mass() * random.spread(0.3, 100.0);
    if random.unit() < 0.5 {
        (p.casing.segments, p.casing.elements) = (1 + (random.unit() * 3.0) as usize, 6);
        for part in &mut p.casing.segment[..p.casing.segments] {
            (part.length, part.area) = (random.spread(0.05, 1.0), random.spread(1e-3, 1e-2));
        }
    }
    p.casing.impedance =
        if random.unit() < 0.4 { 0.0 } else { random.spread(10.0 * p.casing_mass(), 1e6) };
    p.chuck.stiffness = random.spread(1e7, 1e11);
    p.chuck.viscosity = if random.unit() < 0.3 { 0.0 } else { random.spread(1e2, 1e5) };
    p.chuck.travel = random.spread(1e-4, 0.05);
    p.chuck.idle_travel = if random.unit() < 0.5 { 0.0 } else { 0.7 * p.chuck.travel };
    let least = p.drive.amplitude - p.casing_mass() * p.gravity;
    (p, least.max(0.0) + random.spread(10.0, 2e4))
}

/// The shoulder carries `FS + Mc G - F_A`, the rock that and the bit.
#[test]
fn it_starts_in_equilibrium_with_the_drives_reaction() {
    let mut random = Random::new(1);
    for round in 0..40 {
        let (p, feed) = drawn(&mut random, round % 2 == 0);
        let m = machine(&p, feed);
        let at = m.kinematics();
        let chuck = feed + p.casing_mass() * p.gravity - p.drive.amplitude;
        let rock = chuck + p.bit_mass() * p.gravity;
        // Some hundred roundings of displacements whose differences carry up to 1e4 times less force.
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (feed + p.drive.amplitude);
        assert!(close(at.chuck_force, chuck), "{round}: {} {chuck}", at.chuck_force);
        assert!(close(at.rock_force, rock), "{round}: {} {rock}", at.rock_force);
        assert!(at.casing_velocity.abs() + at.bit_velocity.abs() <= 1e-12, "{round}");
        assert_eq!(m.mode().ties.of(Tie::Chuck), TieState::Pressed);
    }
}

#[test]
fn a_chuck_that_never_vents_and_a_string_too_weak_are_refused_by_name() {
    let p = cased();
    let inputs = |feed_force| InputValues { feed_force, ..InputValues::default() };
    let mut vented = p;
    vented.chuck.idle_travel = vented.chuck.travel;
    let refused = Machine::new(&vented, &inputs(5e3), 0.0).expect_err("never vented");
    assert!(refused.to_string().starts_with("chuck.idle_travel = 0.03"), "{refused}");
    let mut weak = p;
    weak.casing.impedance = 399.0;
    let refused = Machine::new(&weak, &inputs(5e3), 0.0).expect_err("no string");
    assert!(refused.to_string().contains("0, or at least 400"), "{refused}");
}

/// Inner forces cancel in pairs: the momentum of all three bodies is what feed, gravity, rock and
/// string gave. And every energy is in the ledger.
#[test]
fn momentum_and_energy_are_balanced_in_drawn_scenes() {
    let mut random = Random::new(2);
    let mut counts = [0; 4];
    for round in 0..60 {
        let (mut p, feed) = drawn(&mut random, round % 3 == 0);
        // At rest before the start: a piston that is given a speed has momentum already.
        p.piston.initial_velocity = 0.0;
        let mut m = machine(&p, feed);
        m.keep_journal(true);
        let start = m.kinematics().casing_position;
        // Some thousand events, each with 256 roundings of half an `eps`: 3e-11 of what is summed.
        let end = 0.08;
        for k in 1..=4 {
            m.advance(0.25 * end * f64::from(k)).unwrap_or_else(|e| panic!("{round}: {e}"));
        }
        for Record { event, .. } in m.take_journal() {
            let kind = match event {
                Event::Tie(Tie::Chuck, TieState::Open) => 0,
                Event::Tie(Tie::Chuck, TieState::Pressed) => 1,
                Event::Tie(Tie::Chuck, TieState::Pulled) => 2,
                Event::Vent(_) => 3,
                _ => continue,
            };
            counts[kind] += 1;
        }
        let at = *m.kinematics();
        let masses = [p.piston_mass(), p.bit_mass(), p.casing_mass()];
        let speeds = [at.piston_velocity, at.bit_velocity, at.casing_velocity];
        let momentum: f64 = masses.iter().zip(speeds).map(|(m, v)| m * v).sum();
        let weight = masses.iter().sum::<f64>() * p.gravity;
        let string = p.casing.impedance * (at.casing_position - start);
        let given = (feed + weight) * end - m.impulses().rock - string;
        let size = (feed + weight) * end + m.impulses().rock.abs() + string.abs();
        // The string takes what its end moves, which of an elastic casing is not shown.
        let is_told = p.casing.impedance == 0.0 || !p.is_elastic(Body::Casing);
        let apart = (momentum - given).abs();
        assert!(!is_told || apart <= 1e-9 * size, "{round}: {momentum} {given} of {size}");
        let energies = m.energies();
        let bound = 1e-10 * energies.turnover();
        assert!(energies.residual.abs() <= bound, "{round}: {energies:?} {p:?} {feed}");
    }
    assert!(counts.iter().all(|&count| count > 5), "every tie was met: {counts:?}");
}

/// Between shoulder and ring the casing is alone with its loads and the string:
/// `Mc v' = FS + Mc G - F_A - Zs v`, in closed form.
#[test]
fn between_shoulder_and_ring_the_string_brakes_the_casing() {
    for impedance in [0.0, 400.0, 3e3, 3e5] {
        let mut p = cased();
        p.casing.impedance = impedance;
        let feed = 3000.0;
        let mut m = machine(&p, feed);
        m.keep_journal(true);
        m.advance(0.2).expect("a run");
        let records = m.take_journal();
        let free = records.windows(2).filter(|pair| {
            let parts = pair[0].event == Event::Tie(Tie::Chuck, TieState::Open);
            parts && pair[1].time - pair[0].time > 1e-5
        });
        let mut flights = 0;
        let mut m = machine(&p, feed);
        for pair in free.take(20) {
            let [from, to] = [pair[0].time.next_up(), pair[1].time];
            m.advance(from).expect("a step");
            let before = *m.kinematics();
            m.advance(from + 0.9 * (to - from)).expect("a step");
            let (after, t) = (m.kinematics(), m.time() - from);
            let load = feed + p.casing.mass * p.gravity - before.applied_drive_force;
            let (rate, v0) = (impedance / p.casing.mass, before.casing_velocity);
            let speed = if impedance == 0.0 {
                v0 + load / p.casing.mass * t
            } else {
                v0 + (v0 - load / impedance) * (-rate * t).exp_m1()
            };
            // Some hundred roundings of the speeds, of that which the loads could reach among them.
            let reach = if impedance == 0.0 { 0.0 } else { load.abs() / impedance };
            let bound = 1e-14 * (v0.abs() + speed.abs() + reach) + 1e-16 * load / p.casing.mass;
            assert!((after.casing_velocity - speed).abs() <= bound, "{impedance} at {from}");
            flights += 1;
        }
        assert!(flights > 3, "{impedance}: {flights}");
    }
}

/// `vr` is 0 at Q9 and `-D1` at Q10, by the positions that a second run reads at these instants: in
/// flight, with the bit in the chuck and out of it, where the casing rebounds; and in contact.
#[test]
fn the_relay_turns_where_the_piston_is_in_the_casing() {
    let mut counts = [0; 3];
    for (fidelity, feed) in [
        (Fidelity::Rigid, 5e3),
        (Fidelity::Elastic, 5e3),
        (Fidelity::Rigid, 1e3),
        (Fidelity::Elastic, 1e3),
    ] {
        let p = Parameters { fidelity, ..cased() };
        let [mut m, mut reader] = [(); 2].map(|()| {
            let mut m = machine(&p, 5e3);
            m.advance(0.1).expect("a run");
            m.set_input(Input::FeedForce, &[feed]).expect("a force");
            m
        });
        m.keep_journal(true);
        m.advance(1.5).expect("a run");
        let mut before = reader.mode();
        for record in m.take_journal() {
            if let Event::Relay(relay) = record.event {
                reader.advance(record.time).expect("a step");
                let at = reader.kinematics();
                let vr = at.piston_position - at.casing_position - p.contact.initial_gap;
                let place = if relay == Relay::Return { 0.0 } else { -p.drive.stroke };
                // Some hundred roundings of 0.1 m, and of an instant at 12 m/s.
                assert!((vr - place).abs() < 1e-13, "{fidelity:?} {}: {vr:e}", record.time);
                let is_out = before.ties.of(Tie::Chuck) == TieState::Open;
                counts[if before.closed() { 2 } else { usize::from(is_out) }] += 1;
            }
            before = record.mode;
        }
    }
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
}

/// The largest force of the shoulder in a step is that of a fine scan of it, and never below. A scan
/// every `h` = 0.5 us lacks `(w h)^2 / 8`, 1e-3 up to `w` = 1.8e5 rad/s, twice the bit's lowest
/// elastic mode.
#[test]
fn the_peak_of_the_shoulders_force_is_that_of_a_scan() {
    let p = Parameters { casing: cased().casing, ..overdamped() };
    let (mut whole, mut scanned) = (machine(&p, 5e3), machine(&p, 5e3));
    whole.advance(0.045).expect("a step");
    let peak = whole.peaks().tie_force(Tie::Chuck);
    let mut most = 0.0f64;
    for k in 1..=90_000 {
        scanned.advance(0.045 * f64::from(k) / 90_000.0).expect("a step");
        most = most.max(scanned.kinematics().chuck_force);
    }
    assert!(peak >= most && peak <= 1.001 * most, "{peak} {most}");
}

#[test]
fn a_state_with_a_chuck_that_the_scene_lacks_is_refused_and_nothing_changes() {
    let mut bare = machine(&Parameters::default(), 5e3);
    bare.advance(0.02).expect("a run");
    let before = bare.state();
    let text = serde_json::to_string(&before).expect("JSON");
    let ties = r#""ties":["Open","Open","Pressed""#;
    for (open, forged) in [
        (ties, r#""ties":["Open","Pulled","Pressed""#),
        (ties, r#""ties":["Open","Pressed","Pressed""#),
        (r#""vented":false"#, r#""vented":true"#),
    ] {
        assert_eq!(text.matches(open).count(), 1, "{open}");
        let state: State = serde_json::from_str(&text.replace(open, forged)).expect("a state");
        assert_eq!(bare.restore(&state), Err(Error::Foreign), "{forged}");
        assert_eq!(bare.state(), before);
    }
}

/// The stiffer a casing is, the more it is a rigid one of its mass. A casing of 40 kg and 1 mm is
/// compressible by `L / (3 E A)`, 3e-7 of what the chuck is.
#[test]
fn a_short_casing_of_a_large_section_is_a_rigid_one() {
    let rigid = cased();
    let mut short = rigid;
    (short.casing.mass, short.casing.segments, short.casing.elements) = (0.0, 1, 2);
    short.casing.segment[0].length = 1e-3;
    short.casing.segment[0].area = 40.0 / (rigid.material.density * 1e-3);
    let [mut a, mut b] = [rigid, short].map(|p| machine(&p, 5e3));
    // Before the first blow, and through the shoulder's motion after it.
    for time in [0.01, 0.0138, 0.014] {
        for m in [&mut a, &mut b] {
            m.advance(time).expect("a run");
        }
        let (x, y) = (a.kinematics(), b.kinematics());
        assert_eq!(a.counters().events, b.counters().events);
        assert!((x.casing_velocity - y.casing_velocity).abs() <= 1e-5, "{time}");
        assert!((x.chuck_force - y.chuck_force).abs() <= 1e-5 * 5e5, "{time}");
    }
    assert!(b.counters().events > 10);
    let mut heavier = short;
    heavier.casing.mass = 1.0;
    assert_eq!(machine(&heavier, 5e3).kinematics(), machine(&short, 5e3).kinematics(), "not read");
    let of_rigid_bodies = Parameters { fidelity: Fidelity::Rigid, ..short };
    assert!((of_rigid_bodies.casing_mass() - 40.0).abs() < 1e-12);
    machine(&of_rigid_bodies, 5e3).advance(0.02).expect("their mass only");
}

/// Light casings under strong strings, and a feed that grows beyond all measure: what overflows ends a
/// step in an error. Before, steps went on and gave no numbers.
#[test]
fn a_motion_that_is_not_finite_is_an_error_and_no_output() {
    let mut random = Random::new(9);
    let (mut moved, mut refused) = (0, 0);
    for round in 0..120 {
        let mut p = cased();
        (p.piston.elements, p.bit.elements) = (3, 3);
        p.fidelity = if round % 2 == 0 { Fidelity::Rigid } else { Fidelity::Elastic };
        p.drive.source = Source::Force;
        p.casing.mass = random.spread(4e-4, 4e-3);
        p.casing.impedance = random.spread(1e4, 1e10);
        p.chuck.stiffness = random.spread(1e3, 1e9);
        p.chuck.viscosity = if random.unit() < 0.5 { 0.0 } else { random.spread(1e3, 1e12) };
        let inputs = InputValues { feed_force: 1e5, ..InputValues::default() };
        let Ok(mut m) = Machine::new(&p, &inputs, 0.0) else { continue };
        for feed in [&[1e5][..], &[0.0, 1e9, 0.0, 1.0, 0.0], &[1e4], &[0.0, 1e9, 5e21]] {
            m.set_input(Input::FeedForce, feed).expect("an input");
            let step = random.spread(1e-9, 1e-3);
            if m.advance(m.time() + step).is_err() {
                refused += 1;
                break;
            }
            let at = m.kinematics();
            assert!(at.casing_position.is_finite() && at.rock_force.is_finite(), "{round}: {p:?}");
            moved += 1;
        }
    }
    assert!(moved > 20 && refused > 0, "{moved} {refused}");
}

/// At the start the casing carries the feed, and of its weight and the drive's reaction what lies above;
/// moving, hung on its ring as well, its nodes add up to its mean.
#[test]
fn stress_and_velocity_along_an_elastic_casing_are_those_of_what_acts_on_it() {
    let mut p = cased();
    p.mesh.degree = 1;
    let (n, area, feed) = (8usize, 4e-3, 5e3);
    (p.casing.segments, p.casing.elements, p.chuck.travel) = (1, n, 1e-4);
    p.casing.segment[0] = Segment { length: 1.2, area };
    let mut m = machine(&p, feed);
    let spread = p.casing_mass() * p.gravity - p.drive.amplitude;
    let at_rest = m.profile();
    assert_eq!((at_rest.casing.len(), at_rest.casing_stress.len()), (n + 1, n));
    for (k, stress) in at_rest.casing_stress.iter().enumerate() {
        let carried = feed + spread * (k as f64 + 0.5) / n as f64;
        // A strain is a difference of displacements of 1e-4 m that are rounded some ten times.
        let rounding = 1e-19 * p.material.youngs_modulus * n as f64;
        assert!((stress * area + carried).abs() <= 1e-12 * feed + rounding * area, "{k}: {stress}");
    }
    let (mut hung, mut stressed) = (0, 0.0f64);
    for step in 1..=200 {
        m.advance(2e-4 * f64::from(step)).expect("a run");
        let (profile, at) = (m.profile(), m.kinematics());
        let mean = |which: usize| {
            let ends = profile.casing.windows(2).map(|w| 0.5 * (w[0][which] + w[1][which]));
            ends.sum::<f64>() / n as f64
        };
        assert!((mean(0) - at.casing_position).abs() <= 1e-14, "{step}");
        assert!((mean(1) - at.casing_velocity).abs() <= 1e-12, "{step}");
        hung += usize::from(m.mode().ties.of(Tie::Chuck) == TieState::Pulled);
        stressed = profile.casing_stress.iter().fold(stressed, |most, s| most.max(s.abs()));
    }
    assert!(hung > 0 && stressed > 1e6, "{hung} {stressed}");
}

/// A chuck of four times the mesh's stiffness sets the nodes that meet rattling: more than twice the
/// chuck's events of one that is as stiff.
#[test]
fn a_chuck_that_is_too_stiff_for_the_mesh_rattles_and_is_warned_of() {
    let [slow, fast] = [1.0, 4.0].map(|ratio| {
        let mut p = cased();
        (p.casing.segments, p.chuck.viscosity) = (1, 0.0);
        p.casing.segment[0].length = 1.0;
        // The bit's elements are stiffer than the casing's.
        p.chuck.stiffness = ratio * p.mesh_stiffness();
        let mut m = machine(&p, 5e3);
        let warned = m.warnings().iter().any(|text| text.contains("chuck.stiffness"));
        assert_eq!(warned, ratio > 2.0, "{:?}", m.warnings());
        m.keep_journal(true);
        m.advance(0.1).expect("a run");
        let journal = m.take_journal();
        journal.iter().filter(|r| matches!(r.event, Event::Tie(Tie::Chuck, _))).count()
    });
    assert!(fast > 2 * slow && slow > 20, "{slow} {fast}");
}

#[test]
fn a_casing_far_lighter_than_the_bit_is_refused_and_the_lightest_keeps_its_digits() {
    // Of those that air drives, in a casing of their own: `air_presets.rs`.
    let relays = hammer::presets::PRESETS.iter();
    let relays = relays.filter(|preset| preset.start().0.drive.source == Source::Relay);
    for preset in relays {
        for sections in [0, 1] {
            let (mut p, mut inputs) = preset.start();
            p.casing.segments = sections;
            inputs.feed_force = inputs.feed_force.max(1.1 * p.drive.amplitude);
            let length = p.material.density * p.casing.segment[0].length;
            let mut run = |part: f64| {
                p.casing.mass = part * p.bit_mass();
                p.casing.segment[0].area = p.casing.mass / length;
                let mut m = Machine::new(&p, &inputs, 0.0)?;
                m.advance(0.03)?;
                Ok::<f64, Error>(m.energies().residual.abs() / m.energies().turnover())
            };
            let residual =
                run(1.001e-4).unwrap_or_else(|e| panic!("{} {sections}: {e}", preset.name));
            assert!(residual <= 1e-10, "{} {sections}: {residual:e}", preset.name);
            let refused = run(0.999e-4).expect_err("too light").to_string();
            let name = ["casing.mass", "casing.segment[1].area"][sections];
            assert!(
                refused.starts_with(name) && refused.contains("1e-4 of the bit's"),
                "{refused}"
            );
        }
    }
}

#[test]
fn a_chuck_of_any_stiffness_on_a_thin_casing_has_its_modes() {
    let mut p = cased();
    (p.casing.segments, p.casing.segment[0].area) = (1, 1e-6);
    p.casing.impedance = 1e9;
    for stiffness in [1e8, 1e16, 1e20] {
        p.chuck.stiffness = stiffness;
        Machine::new(&p, &InputValues::default(), 0.0).map(drop).expect("its modes");
    }
}
