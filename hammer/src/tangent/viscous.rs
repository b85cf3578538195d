//! The tangent of the dashpot's work, `psi = CR int p'^2`, along stretches of one cycle.
//!
//! It is wanted only where a cycle ends at the energy barrier, so stretches are kept and
//! worked off there. Over two radians of the fastest motion both `p'` and `dp'` are their
//! Taylor polynomials to rounding (`2^24 / 24!`), with the state's own recurrence
//! `z <- B z h / k`, `dz <- (B dz + W z) h / k`; the product is integrated exactly. Where neither
//! system nor loads change, `dz = exp(B t) dz0` and the engine's own form of the dashpot's work
//! has the answer: `2 int p' dp' = 2 z.Q dz` at the start less that at the end.

use crate::modal::stretch::{PANEL, moments, product};
use crate::modal::system::{CHANNELS, System, TAYLOR};
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::tangent::response::{Path, Response, still};
use std::sync::Arc;

/// The tip among the functionals of a system that has one.
const TIP: usize = 0;

/// A stretch in DFC: the state, and the tangents of its oscillation at its start.
#[derive(Debug)]
pub(crate) struct Kept {
    pub system: Arc<System>,
    pub start: Vec<f64>,
    pub span: f64,
    pub loads: [Poly; CHANNELS],
    /// A line each: response, tangent at the start, change of the loads.
    pub lines: Vec<(Arc<Response>, Vec<f64>, [Poly; CHANNELS])>,
}

impl Kept {
    /// `int p'^2` and, a line each, `2 int p' dp'`.
    pub(crate) fn squares(&self) -> (f64, Vec<f64>) {
        let system = &self.system;
        let tip = &system.functionals[TIP];
        let row = &tip.rows[1];
        let rate = still(tip, &self.loads).derivative();
        if self.keeps_its_form() {
            return self.by_form();
        }
        let rates: Vec<Poly> = self
            .lines
            .iter()
            .map(|(response, _, changes)| {
                let path = Path {
                    system,
                    start: &[],
                    end: &[],
                    span: self.span,
                    loads: &self.loads,
                    changes,
                };
                response.drift(&path, tip).derivative()
            })
            .collect();
        let mut z = self.start.clone();
        let mut tangents: Vec<Vec<f64>> = self.lines.iter().map(|l| l.1.clone()).collect();
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
            for (k, (response, ..)) in self.lines.iter().enumerate() {
                tangent_powers(system, response, &terms, &mut tangents[k], h, &mut own);
                let d = series(&own, row, &rates[k], t, h);
                sums[k] += 2.0 * h * product(&moments, &d);
            }
            t += h;
        }
        (whole, sums)
    }

    /// True if no line changes system or dashpot, and no load varies.
    fn keeps_its_form(&self) -> bool {
        let constant = |loads: &[Poly; CHANNELS]| loads.iter().all(Poly::is_constant);
        let still = |(response, _, changes): &(Arc<Response>, Vec<f64>, _)| {
            response.is_still() && constant(changes)
        };
        constant(&self.loads) && self.lines.iter().all(still)
    }

    fn by_form(&self) -> (f64, Vec<f64>) {
        let form = self.system.viscous_form();
        let mut end = self.start.clone();
        self.system.rotate(self.span, &mut end);
        let [before, after] = [&self.start, &end].map(|z| form.gradient(z));
        let sum = |(_, tangent, _): &(Arc<Response>, Vec<f64>, [Poly; CHANNELS])| {
            let mut carried = tangent.clone();
            self.system.rotate(self.span, &mut carried);
            kernel::dot(&before, tangent) - kernel::dot(&after, &carried)
        };
        (form.of(&self.start) - form.of(&end), self.lines.iter().map(sum).collect())
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
