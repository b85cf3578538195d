//! The tangent of the dashpot's work, `psi = CR int p'^2`, along stretches of one cycle.
//!
//! It is wanted only where a cycle ends at the energy barrier, so stretches are kept and worked
//! off there. Where no load varies, `int p'^2` is `z.Q z` at the start less that at the end, and
//! its tangent
//!
//! ```text
//! 2 int p' dp' = [2 z.Q dz + z.dQ z],     B^T dQ + dQ B = -(Q W + W^T Q)
//! ```
//!
//! likewise. That cancels where little is done of all the work to come, and `dQ` is not known well
//! where a mode is hardly damped: there, and where loads vary, both `p'` and `dp'` are summed as
//! their Taylor polynomials over two radians of the fastest motion at a time (`2^24 / 24!` is below
//! rounding), with the state's own recurrence `z <- B z h / k`, `dz <- (B dz + W z) h / k`.

use crate::modal::stretch::{PANEL, moments, product};
use crate::modal::system::{CHANNELS, System, TAYLOR};
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::tangent::response::{Path, Response, still};
use std::cell::OnceCell;
use std::sync::Arc;

/// The tip among the functionals of a system that has one.
const TIP: usize = 0;

/// Part of the work to come that must be done, if forms are to tell it: three digits are lost then.
const DONE: f64 = 1e-3;

/// A stretch in DFC: the oscillation at its start and at its end, and its tangents.
#[derive(Debug)]
pub(crate) struct Kept {
    pub system: Arc<System>,
    pub ends: [Vec<f64>; 2],
    pub span: f64,
    pub loads: [Poly; CHANNELS],
    pub lines: Vec<KeptLine>,
}

/// A line's share of a stretch: its tangents at both ends, and the change of the loads.
#[derive(Debug)]
pub(crate) struct KeptLine {
    pub response: Arc<Response>,
    pub ends: [Vec<f64>; 2],
    pub changes: [Poly; CHANNELS],
}

impl Kept {
    /// `int p'^2` and, a line each, `2 int p' dp'`.
    pub(crate) fn squares(&self) -> (f64, Vec<f64>) {
        self.by_form().unwrap_or_else(|| self.by_series())
    }

    fn by_form(&self) -> Option<(f64, Vec<f64>)> {
        let constant = |loads: &[Poly; CHANNELS]| loads.iter().all(Poly::is_constant);
        if !constant(&self.loads) || !self.lines.iter().all(|l| constant(&l.changes)) {
            return None;
        }
        let form = self.system.viscous_form();
        let [before, after] = self.ends.each_ref().map(|z| form.of(z));
        let whole = before - after;
        if whole <= DONE * before {
            return None;
        }
        let slopes = self.ends.each_ref().map(|z| form.gradient(z));
        let sum = |line: &KeptLine| {
            let [start, end]: [f64; 2] =
                std::array::from_fn(|k| kernel::dot(&slopes[k], &line.ends[k]));
            if line.response.is_still() {
                return Some(start - end);
            }
            let changed = line.response.viscous(&self.system)?;
            Some(start - end + changed.of(&self.ends[0]) - changed.of(&self.ends[1]))
        };
        Some((whole, self.lines.iter().map(sum).collect::<Option<_>>()?))
    }

    fn by_series(&self) -> (f64, Vec<f64>) {
        let system = &self.system;
        let tip = &system.functionals[TIP];
        let row = &tip.rows[1];
        let rate = still(tip, &self.loads).derivative();
        let drift = |line: &KeptLine| {
            let path = Path {
                system,
                start: &[],
                end: &[],
                span: self.span,
                loads: &self.loads,
                changes: &line.changes,
                turns: &OnceCell::new(),
            };
            line.response.drift(&path, tip).derivative()
        };
        let rates: Vec<Poly> = self.lines.iter().map(drift).collect();
        let mut z = self.ends[0].clone();
        let mut tangents: Vec<Vec<f64>> = self.lines.iter().map(|l| l.ends[0].clone()).collect();
        let (mut whole, mut sums) = (0.0, vec![0.0; self.lines.len()]);
        let mut terms = vec![vec![0.0; z.len()]; TAYLOR];
        let mut own = terms.clone();
        let mut t = 0.0;
        while t < self.span {
            let h = (PANEL / system.rate_max).min(self.span - t);
            powers(system, &mut z, h, &mut terms);
            let speed = series(&terms, row, &rate, t, h);
            let moments = moments(&speed);
            whole += h * product(&moments, &speed);
            for (k, line) in self.lines.iter().enumerate() {
                tangent_powers(system, &line.response, &terms, &mut tangents[k], h, &mut own);
                let d = series(&own, row, &rates[k], t, h);
                sums[k] += 2.0 * h * product(&moments, &d);
            }
            t += h;
        }
        (whole, sums)
    }
}

/// `(B h)^k / k! z` for each order; `z` moves on by `h`.
pub(crate) fn powers(system: &System, z: &mut [f64], h: f64, all: &mut [Vec<f64>]) {
    all[0].copy_from_slice(z);
    for k in 1..TAYLOR {
        let (before, here) = all.split_at_mut(k);
        here[0].copy_from_slice(&before[k - 1]);
        kernel::turn(system.generators(), &mut here[0]);
        for (t, z) in here[0].iter_mut().zip(z.iter_mut()) {
            *t *= h / k as f64;
            *z += *t;
        }
    }
}

fn tangent_powers(
    system: &System,
    response: &Response,
    powers: &[Vec<f64>],
    d: &mut [f64],
    h: f64,
    all: &mut [Vec<f64>],
) {
    all[0].copy_from_slice(d);
    for k in 1..TAYLOR {
        let (before, here) = all.split_at_mut(k);
        here[0].copy_from_slice(&before[k - 1]);
        kernel::turn(system.generators(), &mut here[0]);
        response.push(&powers[k - 1], &mut here[0]);
        for (t, d) in here[0].iter_mut().zip(d.iter_mut()) {
            *t *= h / k as f64;
            *d += *t;
        }
    }
}

/// Coefficients, in time over `h` from `t` on, of `row . z + poly`.
pub(crate) fn series(
    powers: &[Vec<f64>],
    row: &[f64],
    poly: &Poly,
    t: f64,
    h: f64,
) -> [f64; TAYLOR] {
    let mut out: [f64; TAYLOR] = std::array::from_fn(|k| kernel::dot(row, &powers[k]));
    let mut scale = 1.0;
    for (o, c) in out.iter_mut().zip(&poly.shifted(t).0) {
        *o += c * scale;
        scale *= h;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::mode::RockMode;
    use crate::machine::Machine;
    use crate::quantities::parameters::{InputValues, Parameters};
    use crate::tangent::{Parameter, Seed, Tangents};

    /// Both are good to rounding of the work to come, of which a thousandth at least is done; the
    /// forms lose what quotients by differences of eigenvalues do, three digits more.
    #[test]
    fn forms_and_series_tell_the_same_of_the_dashpots_work() {
        let mut p = Parameters::default();
        (p.piston.elements, p.bit.elements, p.piston.segments) = (5, 6, 3);
        (p.contact.initial_gap, p.piston.initial_velocity) = (1e-3, 8.0);
        let read = Parameter::ALL.iter().filter(|q| q.is_read(&p));
        let seeds: Vec<Seed> = read.map(|q| Seed::Parameter(*q)).collect();
        let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        let mut tangents = Tangents::of_scene(&machine, &seeds).expect("tangents");
        let mut compared = 0;
        while machine.time() < 5e-4 {
            let to = machine.time() + 2e-6;
            tangents.advance(&mut machine, to).expect("a run");
            if machine.motion().mode().rock != RockMode::DissipativeForward {
                continue;
            }
            let kept = |here: &Tangents| -> Vec<_> {
                let both = |kept: &Kept| kept.by_form().map(|form| (form, kept.by_series()));
                here.kept.iter().filter_map(both).collect()
            };
            for ((whole, forms), (sum, series)) in tangents.at_present(&machine, kept) {
                assert!((whole - sum).abs() < 1e-10 * sum, "{whole:e} {sum:e}");
                let sizes = seeds.iter().map(|seed| match seed {
                    Seed::Parameter(q) => *q.slot(&mut p.clone()),
                    _ => 1.0,
                });
                for ((a, b), size) in forms.iter().zip(&series).zip(sizes) {
                    assert!(
                        ((a - b) * size).abs() < 1e-9 * (sum + (b * size).abs()),
                        "{a:e} {b:e}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 100, "{compared}");
    }
}
