//! The rule for the mesh, over drawn hammers: the contact's largest force on the advised mesh, against that on spans
//! half as long and of the highest degree, whose error is far less by the rule.

use crate::scenes::Random;
use hammer::{
    Body, InputValues, MAX_DEGREE, MAX_ELEMENTS, Machine, Parameters, Reading, Segment, Tie,
};

/// Largest force of the contact at the first impact, and the chuck's.
fn peaks(p: &Parameters) -> [f64; 2] {
    let mut machine = Machine::new(p, &InputValues::default(), 0.0).expect("a scene");
    while machine.counters().blows == 0 {
        machine.advance(machine.time() + 1e-3).expect("a run");
    }
    let before = machine.peaks();
    machine.advance(machine.time() + 2e-3).expect("a run");
    let after = machine.peaks();
    [Tie::Contact, Tie::Chuck].map(|tie| before.tie_force(tie).max(after.tie_force(tie)))
}

fn drawn(random: &mut Random) -> Parameters {
    let mut p = Parameters::default();
    (p.piston.length, p.bit.length) = (0.1 + 0.2 * random.unit(), 0.1 + 0.2 * random.unit());
    p.contact.stiffness *= (2.4 * (random.unit() - 0.7)).exp();
    p.material.damping_time *= (2.4 * (random.unit() - 0.3)).exp();
    if random.unit() < 0.5 {
        let mut part =
            || Segment { length: 0.03 + 0.1 * random.unit(), area: 1.5e-3 + 2e-3 * random.unit() };
        let [a, b, c, d] = std::array::from_fn(|_| part());
        p.piston.segments.set(&[a, c]);
        p.bit.segments.set(&[b, d]);
    }
    p
}

#[test]
fn forces_on_the_advised_mesh_err_by_no_more_than_was_asked_for() {
    let (mut random, mut needed) = (Random::new(23), 0);
    for case in 0..8 {
        let error = [1e-2, 1e-3][case % 2];
        let mut p = drawn(&mut random);
        let Some(mesh) = p.mesh_for(Reading::Force, error) else { panic!("no mesh for {p:?}") };
        mesh.apply(&mut p);
        let found = peaks(&p)[0];
        let mut fine = p;
        fine.mesh.degree = MAX_DEGREE;
        Body::ALL.iter().for_each(|body| *fine.elements_mut(*body) *= 2);
        let exact = peaks(&fine)[0];
        let off = (found / exact - 1.0).abs();
        assert!(off <= error, "{off:e} where {error:e} was asked for: {mesh:?} {p:?}");
        let mut coarse = p;
        Body::ALL.iter().for_each(|body| *coarse.elements_mut(*body) /= 3);
        needed += usize::from((peaks(&coarse)[0] / exact - 1.0).abs() > error);
    }
    // The rule is not too fine either: a third of the spans is too coarse for most hammers (except where another wave
    // makes the largest force).
    assert!(needed >= 5, "{needed} of 8");
}

/// Mean rate and energy of ten blows after thirty, on the mesh for a rate of 1 %, beside that on spans a third as
/// long of degree 5, whose error is a fiftieth of that.
#[test]
fn rates_on_the_advised_mesh_err_by_no_more_than_was_asked_for() {
    let mean = |p: &Parameters| {
        let inputs = InputValues { feed_force: 2.0 * p.drive.amplitude, ..InputValues::default() };
        let mut machine = Machine::new(p, &inputs, 0.0).expect("a scene");
        let (mut sums, mut last) = ([0.0; 4], 0);
        while last < 40 {
            machine.advance(machine.time() + 5e-3).expect("a run");
            let blow = machine.blow().copied().unwrap_or_default();
            if machine.counters().blows > last.max(30) {
                let new = [blow.rop * blow.period, blow.penetration, blow.energy, blow.period];
                sums.iter_mut().zip(new).for_each(|(sum, x)| *sum += x);
            }
            last = machine.counters().blows;
        }
        [sums[0] / sums[3], sums[1] / sums[3], sums[2] / 10.0]
    };
    let mut scenes = vec![Parameters::default()];
    let mut random = Random::new(31);
    while scenes.len() < 6 {
        let mut p = drawn(&mut random);
        // The damping makes blows repeat.
        p.material.damping_time = p.damping_time_of(0.005).expect("modes");
        scenes.push(p);
    }
    for mut p in scenes {
        let mesh = p.mesh_for(Reading::Rate, 0.01).expect("a mesh");
        mesh.apply(&mut p);
        let mut fine = p;
        fine.mesh.degree = 5;
        Body::ALL.iter().for_each(|body| *fine.elements_mut(*body) *= 3);
        let exact = mean(&fine);
        assert!(p.rate_error().expect("splines") <= 0.01);
        // A mesh of a user's own, with two thirds of the spans, errs by no more than is told of it.
        let mut own = p;
        Body::ALL
            .iter()
            .for_each(|body| *own.elements_mut(*body) = (2 * p.spans(*body)).div_ceil(3));
        for (scene, told) in [(p, 0.01), (own, own.rate_error().expect("splines"))] {
            for (found, exact) in mean(&scene).into_iter().zip(exact) {
                let off = found / exact - 1.0;
                assert!(off.abs() <= told, "{off:e}, told {told:e}: {scene:?}");
            }
        }
    }
}

#[test]
fn what_no_mesh_resolves_is_said() {
    let mut p = Parameters::default();
    p.contact.stiffness = 1e15;
    assert_eq!(p.mesh_for(Reading::Force, 1e-3), None);
    // Without damping, only the contact widens the front.
    let mut p = Parameters::default();
    p.material.damping_time = 0.0;
    assert!(p.mesh_for(Reading::Force, 0.05).is_some());
    assert_eq!(p.mesh_for(Reading::Force, 1e-5), None);
}

/// A chuck without viscosity on a casing of sections: its largest force, beside that on 400 spans.
#[test]
fn the_chucks_force_on_an_advised_casing_errs_by_no_more_than_was_asked_for() {
    let (mut random, mut needed) = (Random::new(31), 0);
    let error = 1e-3;
    for case in 0..6 {
        let mut p = drawn(&mut random);
        p.contact.stiffness = Parameters::default().contact.stiffness;
        let unit = |k: u32| (random.bits() >> (11 + 6 * k) & 63) as f64 / 64.0;
        let part = |k| Segment { length: 0.2 + 0.6 * unit(k), area: 2e-3 + 5e-3 * unit(k + 2) };
        p.casing.segments.set(&[part(0), part(1)]);
        p.casing.segments.set_count(1 + case % 2);
        (p.chuck.stiffness, p.chuck.viscosity) = (1e9 * (1.5 * unit(5)).exp(), 0.0);
        let mesh = p.mesh_for(Reading::Force, error).expect("a mesh");
        let casing = mesh.of(Body::Casing).expect("it is elastic");
        mesh.apply(&mut p);
        let on = |elements| {
            let mut p = p;
            p.casing.elements = elements;
            peaks(&p)[1]
        };
        let fine = on(MAX_ELEMENTS);
        let off = (on(casing) / fine - 1.0).abs();
        assert!(off <= error, "{off:e} where {error:e} was asked for: {mesh:?} {p:?}");
        needed += usize::from((on((casing / 6).max(1)) / fine - 1.0).abs() > error);
    }
    assert!(needed >= 3, "a sixth of the spans is too coarse for most: {needed} of 6");
    let mut bare = Parameters::default();
    assert_eq!(bare.mesh_for(Reading::Force, 1e-3).expect("a mesh").of(Body::Casing), None);
    // A chuck that is stiffer than the contact also makes the bit's sharpest front.
    let width = bare.front_width();
    (bare.casing.mass, bare.chuck.stiffness) = (40.0, 4.0 * bare.contact.stiffness);
    let z = bare.impedance_of(bare.cross_section);
    let chuck = bare.wave_speed() * z / bare.chuck.stiffness;
    assert!((bare.front_width() / chuck - 1.0).abs() < 1e-14 && chuck < width);
}
