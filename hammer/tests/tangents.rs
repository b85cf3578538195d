//! Tangents against central differences, where both sides see the same events.

mod scenes;

use hammer::tangent::{Derivative, Parameter, Seed, Tangents};
use hammer::{Event, Fidelity, InputValues, Machine, Parameters};
use scenes::Draw;

/// Outputs, in one fixed order.
macro_rules! list {
    ($k:expr, $b:expr, $l:expr, $p:expr) => {{
        let (k, b, (e, i), p) = ($k, $b, $l, $p);
        vec![
            k.piston_position,
            k.piston_velocity,
            k.piston_acceleration,
            k.bit_position,
            k.bit_velocity,
            k.bit_tip_position,
            k.bit_tip_velocity,
            k.bit_tip_acceleration,
            k.relative_position,
            k.relative_velocity,
            k.contact_gap,
            k.contact_gap_rate,
            k.contact_force,
            k.contact_force_rate,
            k.rock_force,
            k.rock_force_rate,
            k.hole_depth,
            b.time,
            b.speed,
            b.energy,
            b.period,
            b.penetration,
            b.rop,
            b.rop_mean,
            b.contact_duration,
            e.drive,
            e.gravity,
            e.feed,
            e.kinetic,
            e.strain,
            e.contact,
            e.rock_stored,
            e.rock_dissipated,
            e.viscous,
            e.damping,
            i.contact,
            i.rock,
            p.contact_force,
            p.rock_force,
        ]
    }};
}

/// Natural sizes of these: 50 mm, 10 m/s, 1e6 m/s2, 1e5 N, 1e10 N/s, 50 ms, 200 J, 100 N s.
#[rustfmt::skip]
const SIZES: [f64; 39] = [
    0.05, 10.0, 1e6, 0.05, 10.0, 0.05, 10.0, 1e6, 0.05, 10.0, 0.05, 10.0,
    1e5, 1e10, 1e5, 1e10, 0.05, 0.05, 10.0, 200.0, 0.05, 1e-3, 0.1, 0.1, 1e-4,
    200.0, 200.0, 200.0, 200.0, 200.0, 200.0, 200.0, 200.0, 200.0, 200.0, 100.0, 100.0, 1e5, 1e5,
];

/// Events and outputs of a scene at `t`.
fn run(p: &Parameters, t: f64) -> Option<(Vec<Event>, Vec<f64>)> {
    let mut m = Machine::new(p, &InputValues::default(), 0.0).ok()?;
    m.keep_journal(true);
    m.advance(t).ok()?;
    let events = m.take_journal().iter().map(|r| r.event).collect();
    let now = *m.kinematics();
    let ledger = (m.energies(), m.impulses());
    Some((events, list!(&now, m.blow(), ledger, m.peaks())))
}

fn tangents(p: &Parameters, seeds: &[Seed], t: f64) -> Option<(Tangents, Vec<Derivative>)> {
    let mut m = Machine::new(p, &InputValues::default(), 0.0).ok()?;
    let mut tangents = Tangents::of_scene(&m, seeds).ok()?.with_ledger(&m).with_peaks();
    tangents.advance(&mut m, t).ok()?;
    let derivatives = tangents.look(&m);
    Some((tangents, derivatives))
}

/// Derivatives by a logarithm (or by the number itself where that is 0), two ways.
///
/// Central differences `D(h)` and `D(h/2)` give the limit `D(h/2) + (D(h/2) - D(h)) / 3` and,
/// by their own difference, what they do not agree about. Rounding adds the outputs' scatter
/// over the step, which is measured: runs whose parameter differs by a few 1e-13 of itself
/// scatter about the tangent by rounding alone.
/// A run is found to no less than 1e-12 of a hammer's natural sizes (see `SIZES`): resolutions
/// of 2e-13 of the travel, small as an output may be at the instant. Over the step that is
/// what a difference can tell.
/// Returns how many quantities saw the same events, and the outputs compared.
fn compare(p: &Parameters, t: f64, worst: &mut f64) -> usize {
    let seeds: Vec<_> = Parameter::ALL.iter().map(|q| Seed::Parameter(*q)).collect();
    let Some((tangents, exact)) = tangents(p, &seeds, t) else { return 0 };
    let Some((events, values)) = run(p, t) else { return 0 };
    if tangents.cautious() > 0 {
        return 0;
    }
    let mut compared = 0;
    for (index, quantity) in Parameter::ALL.iter().enumerate() {
        let own = *quantity.slot(&mut p.clone());
        let unit = if own == 0.0 { 1.0 } else { own.abs() };
        let h = (0.01 * tangents.reach()[index] / unit).min(1e-4);
        if h < 1e-8 {
            continue;
        }
        let difference = |h: f64| -> Option<Vec<f64>> {
            let (mut low, mut high) = (*p, *p);
            *quantity.slot(&mut low) -= h * unit;
            *quantity.slot(&mut high) += h * unit;
            let ((a, x), (b, y)) = (run(&low, t)?, run(&high, t)?);
            let same = a == events && b == events;
            same.then(|| x.iter().zip(&y).map(|(x, y)| (y - x) / (2.0 * h)).collect())
        };
        let (Some(coarse), Some(fine)) = (difference(h), difference(0.5 * h)) else { continue };
        compared += 1;
        let Derivative { kinematics, blow, ledger, peaks, .. } = &exact[index];
        let ours = list!(kinematics, blow, ledger.expect("asked for"), peaks.expect("asked for"));
        let mut scatter = vec![0.0f64; values.len()];
        for probe in [-4e-13, -2e-13, -1e-13, 1e-13, 2e-13, 4e-13] {
            let mut near = *p;
            *quantity.slot(&mut near) += probe * unit;
            let Some((_, x)) = run(&near, t) else { continue };
            for (s, (x, (v, d))) in scatter.iter_mut().zip(x.iter().zip(values.iter().zip(&ours))) {
                *s = s.max((x - v - d * unit * probe).abs());
            }
        }
        for (k, tangent) in ours.iter().map(|x| x * unit).enumerate() {
            let apart = (coarse[k] - fine[k]).abs();
            let limit = fine[k] + (fine[k] - coarse[k]) / 3.0;
            // Six draws show the scatter to a factor of a few.
            let noise = 8.0 * scatter[k] / h;
            let floor = 1e-12 * SIZES[k] / h;
            let bound = 2.0 * apart + noise + floor + 1e-9 * tangent.abs();
            let off = (tangent - limit).abs() / bound;
            *worst = worst.max(off);
            assert!(
                off <= 1.0,
                "{} output {k} at {t} s: {tangent:e}, differences {limit:e} (bound {bound:e}, h \
                 {h:e})\n{p:?}",
                quantity.name(),
            );
        }
    }
    compared
}

#[test]
fn every_parameter_of_unequal_bodies_has_the_derivative_that_differences_tend_to() {
    let mut worst = 0.0;
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        let mut p = Parameters { fidelity, ..Default::default() };
        (p.piston.elements, p.bit.elements) = (8, 5);
        p.bit.length = 0.21;
        p.piston.initial_velocity = 1.0;
        for t in [1e-3, 0.0405, 0.06, 0.1] {
            let compared = compare(&p, t, &mut worst);
            assert!(compared >= 18, "{fidelity:?} {t}: {compared}");
        }
    }
}

#[test]
fn drawn_scenes_have_the_derivatives_that_differences_tend_to() {
    let (mut draw, mut compared, mut worst) = (Draw::new(5), 0, 0.0);
    for _ in 0..10 {
        let p = draw.scene();
        compared += compare(&p, draw.between(0.005, 0.05), &mut worst);
    }
    assert!(compared > 100, "{compared}");
}

/// The piston falls freely: `g = v0 t + a t^2 / 2` with `a = F0 / Mp + G`, onto a bit that stands
/// where its loads press it, `g = g0 + (FS + Mb G) / (gamma KR)`.
///
/// The instant is found to 1e-13 of the travel's time, and its derivatives with it; a thousand
/// times that is granted.
#[test]
fn the_first_blow_of_rigid_bodies_has_the_derivatives_of_its_closed_form() {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    (p.piston.initial_velocity, p.bit.length) = (0.7, 0.23);
    let feed = InputValues::default().feed_force;
    let (v0, f0) = (p.piston.initial_velocity, p.drive.amplitude);
    let (mass, a) = (p.piston_mass(), p.drive.amplitude / p.piston_mass() + p.gravity);
    let held = p.rock.unloading_ratio * p.rock.stiffness;
    let (weight, press) = (p.bit_mass() * p.gravity, feed + p.bit_mass() * p.gravity);
    let gap = p.contact.initial_gap + press / held;
    let speed = (v0 * v0 + 2.0 * a * gap).sqrt();
    let time = (speed - v0) / a;
    // Of speed and time by gap, push and first velocity.
    let by = |gap_change: f64, push: f64| {
        let of_speed = (a * gap_change + gap * push) / speed;
        [of_speed, of_speed / a - time / a * push]
    };
    let lighter = -f0 / mass;
    let of = |value: f64| by(weight / held / value, lighter / value);
    let expected = [
        (Parameter::InitialGap, by(1.0, 0.0)),
        (Parameter::PistonVelocity, [v0 / speed, (v0 / speed - 1.0) / a]),
        (Parameter::DriveAmplitude, by(0.0, 1.0 / mass)),
        (Parameter::Gravity, by(p.bit_mass() / held, 1.0)),
        (Parameter::Density, of(p.material.density)),
        (Parameter::CrossSection, of(p.cross_section)),
        (Parameter::PistonLength, by(0.0, lighter / p.piston.length)),
        (Parameter::BitLength, by(weight / held / p.bit.length, 0.0)),
        (Parameter::RockStiffness, by(-press / held / p.rock.stiffness, 0.0)),
        (Parameter::UnloadingRatio, by(-press / held / p.rock.unloading_ratio, 0.0)),
        (Parameter::RockViscosity, [0.0; 2]),
    ];
    let seeds: Vec<_> = expected.iter().map(|(q, _)| Seed::Parameter(*q)).collect();
    let (_, found) = tangents(&p, &seeds, 1.01 * time).expect("a run");
    for ((parameter, [of_speed, of_time]), d) in expected.iter().zip(&found) {
        let own = *parameter.slot(&mut p.clone());
        for (ours, exact, size) in [(d.blow.speed, of_speed, speed), (d.blow.time, of_time, time)] {
            let off = (ours - exact).abs() * own;
            assert!(off < 1e-10 * size, "{}: {ours:e} {exact:e}", parameter.name());
        }
    }
}
