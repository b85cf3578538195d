//! Tangents against central differences, where both sides see the same events.

use hammer::tangent::{Derivative, Parameter, Seed, Tangents};
use hammer::{Event, InputValues, Machine, Parameters};

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

/// A derivative's outputs over their natural sizes.
pub fn outputs(d: &Derivative) -> Vec<f64> {
    let ledger = d.ledger.expect("asked for");
    let list = list!(&d.kinematics, &d.blow, ledger, d.peaks.expect("asked for"));
    list.iter().zip(SIZES).map(|(x, size)| x / size).collect()
}

/// Events and outputs of a scene at `t`.
pub fn run(p: &Parameters, t: f64) -> Option<(Vec<Event>, Vec<f64>)> {
    let mut m = Machine::new(p, &InputValues::default(), 0.0).ok()?;
    m.keep_journal(true);
    m.advance(t).ok()?;
    let events = m.take_journal().iter().map(|r| r.event).collect();
    let now = *m.kinematics();
    let ledger = (m.energies(), m.impulses());
    Some((events, list!(&now, m.blow().copied().unwrap_or_default(), ledger, m.peaks())))
}

/// Tangents and derivatives at `t`, of all that can be asked for.
pub fn tangents(p: &Parameters, seeds: &[Seed], t: f64) -> Option<(Tangents, Vec<Derivative>)> {
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
pub fn compare(p: &Parameters, t: f64, worst: &mut f64) -> usize {
    let read: Vec<_> = Parameter::ALL.iter().filter(|q| q.is_read(p)).collect();
    let seeds: Vec<_> = read.iter().map(|q| Seed::Parameter(**q)).collect();
    let Some((tangents, exact)) = tangents(p, &seeds, t) else { return 0 };
    let Some((events, values)) = run(p, t) else { return 0 };
    if tangents.cautious() > 0 {
        return 0;
    }
    let mut compared = 0;
    for (index, quantity) in read.into_iter().enumerate() {
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
