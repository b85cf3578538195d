//! The derivative of the work of a load that varies along a stretch.
//!
//! With `u` the displacement of the point on which a load `F` acts, and `d` the derivative,
//!
//! ```text
//! d int F u' dt = [dF u] - int dF' u dt + [F du] - int F' du dt
//! ```
//!
//! Both integrals are moments of a polynomial `g`. Of the motion, `u = c . z + poly` with
//! `z' = B z`; of the tangent, `du = c . dz + poly` with `dz' = B dz + W z`. With `c1 = c B^-1`,
//! by parts, the degree of `g` falling,
//!
//! ```text
//! int g c . z dt  = [g c1 . z] - int g' c1 . z dt
//! int g c . dz dt = [g c1 . dz] - int g' c1 . dz dt - int g (c1 W) . z dt
//! ```
//!
//! A translation has no `B^-1`: its tangent is a polynomial less `X z` (see `response`).

use crate::laws::event::Displacement;
use crate::modal::model::Channel;
use crate::modal::system::Functional;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::tangent::leg::{Leg, Run};
use crate::tangent::response::{Path, Response, antiderivative, still};

/// `[a b]` over a stretch.
fn grown(g: &Poly, span: f64, [start, end]: [f64; 2]) -> f64 {
    g.at(span) * end - g.0[0] * start
}

/// `int g row . z dt` of an oscillation.
fn moment(path: &Path, row: &[f64], g: &Poly) -> f64 {
    let (mut sum, mut sign, mut g) = (0.0, 1.0, *g);
    let mut row = row.to_vec();
    while g != Poly::default() {
        row = path.system.integral_of(&row);
        let ends = [path.start, path.end].map(|z| kernel::dot(&row, z));
        sum += sign * grown(&g, path.span, ends);
        (g, sign) = (g.derivative(), -sign);
    }
    sum
}

/// `int g u dt` of a displacement of the motion.
fn moved(path: &Path, run: &Run, f: &Functional, g: &Poly) -> f64 {
    let rest = still(f, path.loads).plus(f.rigid, &run.translation);
    moment(path, &f.rows[0], g) + g.integral_of_product(&rest, path.span)
}

/// Of the loads that vary along a leg, `int dF' u + F' du dt`: of drive and feed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Works(pub [f64; 2]);

impl Works {
    /// Adds a run's share.
    pub(super) fn add(
        &mut self,
        leg: &Leg,
        run: &Run,
        path: &Path,
        response: &Response,
        ends: &[Vec<f64>; 2],
    ) {
        let points =
            [(Channel::Drive, Displacement::PistonMean), (Channel::Feed, Displacement::BitTop)];
        for (sum, (channel, point)) in self.0.iter_mut().zip(points) {
            let Some(functional) = run.span.share(point) else { continue };
            let f = &run.system.functionals[functional];
            let [load, change] =
                [&leg.loads, path.changes].map(|loads| loads[channel as usize].derivative());
            if change != Poly::default() {
                *sum += moved(path, run, f, &change);
            }
            if load != Poly::default() {
                *sum += response.moment(path, f, ends, &load);
            }
        }
    }
}

impl Response {
    /// `int g du dt` of the tangent of a displacement, whose oscillation has these tangents at the
    /// stretch's ends.
    pub(super) fn moment(
        &self,
        path: &Path,
        f: &Functional,
        ends: &[Vec<f64>; 2],
        g: &Poly,
    ) -> f64 {
        let (system, span) = (path.system, path.span);
        let mut sum = g.integral_of_product(&self.drift(path, f), span);
        if system.rigid {
            let (poly, row) = self.translated(path, &ends[0]);
            let part = g.integral_of_product(&poly, span);
            let swept = row.map_or(0.0, |row| moment(path, row, g));
            sum += f.rigid * (part - swept);
        }
        let (mut sign, mut g) = (1.0, *g);
        let mut row = f.rows[0].clone();
        while g != Poly::default() {
            row = system.integral_of(&row);
            let ends = ends.each_ref().map(|dz| kernel::dot(&row, dz));
            let pushed = moment(path, &self.pulled(&row), &g);
            sum += sign * (grown(&g, span, ends) - pushed);
            (g, sign) = (g.derivative(), -sign);
        }
        sum
    }

    /// The tangent of the translation: a polynomial, less a row times `z`.
    fn translated(&self, path: &Path, start: &[f64]) -> (Poly, Option<&[f64]>) {
        let n = path.system.blocks();
        let swept = |k: usize| self.swept_row(k).map_or(0.0, |row| kernel::dot(row, path.start));
        let (mut poly, [speed, kick]) = (Poly::default(), self.translating(path));
        poly.0[0] = start[0] + swept(0);
        poly.0[1] = start[n] + swept(n);
        (poly.plus(1.0, &antiderivative(&speed.plus(1.0, &kick))), self.swept_row(0))
    }
}
