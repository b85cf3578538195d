//! The hammer in its casing: refusals, and the stress along it.

use crate::scenes::{Random, cased, machine};
use hammer::{
    Error, Event, Fidelity, Input, InputValues, Machine, Parameters, Scene, Segment, Source, State,
    Tie, TieState,
};

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

/// Light casings under strong strings, with an ever growing feed: an overflow ends the step in an error. Once, such
/// steps went on without valid numbers.
#[test]
fn a_motion_that_is_not_finite_is_an_error_and_no_output() {
    let mut random = Random::new(9);
    let (mut moved, mut refused) = (0, 0);
    for round in 0..120 {
        let mut p = cased();
        (p.piston.elements, p.bit.elements) = (3, 3);
        p.fidelity = if round % 2 == 0 { Fidelity::Rigid } else { Fidelity::Elastic };
        p.drive.source = Source::Force;
        p.work_limit = 1; // Some chatter until it ends them, which is an error too.
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
            assert!((at.casing.displacement + at.rock_force).is_finite(), "{round}: {p:?}");
            moved += 1;
        }
    }
    assert!(moved > 20 && refused > 0, "{moved} {refused}");
}

/// At the start, the casing carries the feed, and at each section its weight and the drive's reaction above it. In
/// motion, also when the bit hangs on the ring, the mean of its nodes is its mean velocity.
#[test]
fn stress_and_velocity_along_an_elastic_casing_are_those_of_what_acts_on_it() {
    let mut p = cased();
    p.mesh.degree = 1;
    let (n, area, feed) = (8usize, 4e-3, 5e3);
    (p.casing.elements, p.chuck.travel) = (n, 1e-4);
    p.casing.segments.set(&[Segment { length: 1.2, area }]);
    let mut m = machine(&p, feed);
    let spread = p.casing_mass() * p.gravity - p.drive.amplitude;
    let at_rest = m.profile();
    assert_eq!((at_rest.casing.len(), at_rest.casing_stress.len()), (n + 1, n));
    for (k, stress) in at_rest.casing_stress.iter().enumerate() {
        let carried = feed + spread * (k as f64 + 0.5) / n as f64;
        // A strain is a difference of displacements of 1e-4 m, each rounded some ten times.
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
        assert!((mean(0) - at.casing.displacement).abs() <= 1e-14, "{step}");
        assert!((mean(1) - at.casing.velocity).abs() <= 1e-12, "{step}");
        hung += usize::from(m.mode().ties.of(Tie::Chuck) == TieState::Pulled);
        stressed = profile.casing_stress.iter().fold(stressed, |most, s| most.max(s.abs()));
    }
    assert!(hung > 0 && stressed > 1e6, "{hung} {stressed}");
}

/// A chuck of four times the mesh's stiffness makes the nodes at it chatter, with more than twice the events of a
/// chuck that is as stiff as the mesh.
#[test]
fn a_chuck_that_is_too_stiff_for_the_mesh_rattles_and_is_warned_of() {
    let [slow, fast] = [1.0, 4.0].map(|ratio| {
        let mut p = cased();
        p.chuck.viscosity = 0.0;
        p.casing.segments.set(&[Segment { length: 1.0, area: 5.1e-3 }]);
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
    // Those driven by air have casings of their own: `air_presets.rs`.
    let relays = hammer::presets::PRESETS.iter();
    let relays = relays.filter(|preset| preset.start().parameters.drive.source == Source::Relay);
    for preset in relays {
        for sections in [0, 1] {
            let Scene { parameters: mut p, mut inputs } = preset.start();
            p.casing.segments.set(&vec![Segment { length: 0.125, area: 1.0 }; sections]);
            inputs.feed_force = inputs.feed_force.max(1.1 * p.drive.amplitude);
            let density = p.material.density;
            let mut run = |part: f64| {
                p.casing.mass = part * p.bit_mass();
                for part in p.casing.segments.iter_mut() {
                    part.area = p.casing.mass / (density * part.length);
                }
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
