//! Exact integrals over a stretch between two events.
//!
//! Over such a stretch loads are polynomials and displacements are `c . z(t) + poly(t)` (slow
//! coordinates, for which `B` is nearly singular, are in `poly`: see [`crate::modal::system::response`]),
//! and
//!
//! * `int f(t) c . z dt` follows from `z = (B^-1 z)'` by parts, once per degree;
//! * `int z.W z dt = z.Q z` at the start less that at the end, with the Lyapunov solution
//!   `B^T Q + Q B = -W`: the damping's work (`W` the damping power of the velocities) and
//!   the viscous work (`W` the square of the tip's velocity).

use crate::modal::system::driven::Driven;
use crate::modal::system::{Functional, System, TAYLOR};
use crate::modal::track::Track;
use crate::numerics::kernel;
use crate::numerics::poly::Poly;
use crate::scene::graph::CHANNELS;

/// Radians of the fastest motion that a series covers: `2^24 / 24!` is below rounding.
pub(crate) const PANEL: f64 = 2.0;

/// If a work is less than this part of the terms that cancel in it, fewer than thirteen of its digits
/// survive.
pub(crate) const LITTLE: f64 = 1e-3;

/// One track over a stretch that starts at time 0.
pub struct Stretch<'a> {
    /// The system.
    pub system: &'a System,
    /// Modal vector at the start.
    pub start: &'a [f64],
    /// Modal vector at the end.
    pub end: &'a [f64],
    /// Duration, s.
    pub span: f64,
    /// Loads.
    pub loads: &'a [Poly; CHANNELS],
    /// The polynomial part of the motion.
    pub driven: &'a Driven,
}

impl<'a> Stretch<'a> {
    /// A track from its anchor to `end`.
    pub fn new(
        track: &'a Track,
        start: &'a [f64],
        span: f64,
        loads: &'a [Poly; CHANNELS],
        driven: &'a Driven,
    ) -> Self {
        Self { system: &track.system, start, end: &track.z, span, loads, driven }
    }

    /// Rate of the polynomial part of a displacement.
    pub(crate) fn drift_rate(&self, index: usize) -> Poly {
        self.poly(index).derivative()
    }

    fn functional(&self, index: usize) -> &Functional {
        &self.system.functionals[index]
    }

    fn poly(&self, index: usize) -> Poly {
        self.system.poly(index, self.loads, self.driven)
    }

    /// Change of a displacement.
    pub fn change(&self, index: usize) -> f64 {
        let f = self.functional(index);
        let poly = self.poly(index);
        let modal = kernel::dot(&f.rows[0], self.end) - kernel::dot(&f.rows[0], self.start);
        poly.at(self.span) - poly.0[0] + modal
    }

    /// Integral of a displacement over time.
    pub fn integral(&self, index: usize) -> f64 {
        let f = self.functional(index);
        let poly = self.poly(index).integral(self.span);
        poly + kernel::dot(&f.integral, self.end) - kernel::dot(&f.integral, self.start)
    }

    /// `int load(t) u'(t) dt` of a load for the displacement `index`, which changes by `change`.
    pub fn work(&self, index: usize, load: &Poly, change: f64) -> f64 {
        if load.is_constant() {
            return load.0[0] * change;
        }
        let rate = self.poly(index).derivative();
        let [modal, _] = self.moment_and_size(index, load);
        load.integral_of_product(&rate, self.span) + modal
    }

    /// `int load(t) c . z(t) dt` of a displacement's rate `c . z`, by parts, and the sum of the sizes of
    /// its terms.
    fn moment_and_size(&self, index: usize, load: &Poly) -> [f64; 2] {
        let (mut sum, mut size, mut sign) = (0.0, 0.0, 1.0);
        let (ready, mut more, mut p) = (self.system.rate_integrals(index), Vec::new(), *load);
        for k in 0..=load.degree() {
            if k >= ready.len() {
                more = self.system.integral_of(if more.is_empty() { &ready[k - 1] } else { &more });
            }
            let row = ready.get(k).unwrap_or(&more);
            let (end, start) = (kernel::dot(row, self.end), kernel::dot(row, self.start));
            let terms = [p.at(self.span) * end, p.0[0] * start];
            sum += sign * (terms[0] - terms[1]);
            size += terms[0].abs() + terms[1].abs();
            p = p.derivative();
            sign = -sign;
        }
        [sum, size]
    }

    /// Work lost in the bars; `energy` gives `z.Q z` at start and end.
    pub fn damping(&self, energy: [f64; 2]) -> f64 {
        let own = energy[0] - energy[1];
        if self.system.varies(self.loads) || self.system.is_braked() {
            own + self.forced_damping()
        } else {
            own
        }
    }

    /// The part of the damping's work due to loads that vary: `d_i (v_i^2 + 2 v_i V_i . z)`
    /// integrated and summed over the damped velocities, which are `v_i(t) + V_i . z(t)`.
    fn forced_damping(&self) -> f64 {
        let mut sum = 0.0;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for mode in 0..self.system.damped() {
            let (damping, row) = self.system.velocity_row(mode);
            if damping == 0.0 {
                continue;
            }
            let forced = self.system.velocity(mode, self.loads, self.driven).trimmed(self.span);
            sum += damping * forced.integral_of_product(&forced, self.span);
            let terms = forced.degree() + 1;
            rows.resize(rows.len().max(terms), vec![0.0; row.len()]);
            for (u, c) in rows.iter_mut().zip(&forced.0) {
                kernel::add(u, 2.0 * damping * c, &row);
            }
        }
        sum + self.moments(rows)
    }

    /// `int sum_k t^k rows_k . z(t) dt`, by parts.
    fn moments(&self, mut rows: Vec<Vec<f64>>) -> f64 {
        let (mut sum, mut sign) = (0.0, 1.0);
        while !rows.is_empty() {
            for row in &mut rows {
                *row = self.system.integral_of(row);
            }
            let value = |sum, row: &Vec<f64>| sum * self.span + kernel::dot(row, self.end);
            let end = rows.iter().rev().fold(0.0, value);
            sum += sign * (end - kernel::dot(&rows[0], self.start));
            sign = -sign;
            rows.remove(0);
            for (k, row) in rows.iter_mut().enumerate() {
                row.iter_mut().for_each(|x| *x *= (k + 1) as f64);
            }
        }
        sum
    }

    /// `int p'^2 dt` of the tip from `at`, where `z` stands, to the end, from its Taylor
    /// polynomials, a [`PANEL`] at a time. It has a small relative error even where the tip has
    /// hardly moved and the forms of [`Self::tip_square`] would cancel. `drift` is the rate of its
    /// polynomial part.
    pub(crate) fn tip_square_by_series(
        &self,
        tip: usize,
        drift: &Poly,
        mut at: f64,
        z: &[f64],
    ) -> f64 {
        let rate = self.system.rate_max;
        let (mut z, mut sum) = (z.to_vec(), 0.0);
        while at < self.span {
            let h = (PANEL / rate).min(self.span - at);
            let mut speed = self.system.taylor(tip, 1, &z);
            let mut scale = rate;
            for (k, c) in speed.iter_mut().enumerate() {
                *c *= scale;
                scale *= rate * h / (k + 1) as f64;
            }
            let mut power = 1.0;
            for (c, d) in speed.iter_mut().zip(&drift.shifted(at).0) {
                *c += d * power;
                power *= h;
            }
            sum += h * product(&moments(&speed), &speed);
            self.system.rotate(h, &mut z);
            at += h;
        }
        sum
    }

    /// How many panels that takes over a span.
    pub(crate) fn panels(system: &System, span: f64) -> u64 {
        (span * system.rate_max / PANEL).ceil() as u64
    }

    /// `int p'^2 dt` of the tip, whose polynomial part has the rate `drift`; `start` is the viscous form
    /// at the start.
    pub(crate) fn tip_square(&self, tip: usize, drift: &Poly, start: f64) -> f64 {
        self.tip_square_and_size(tip, drift, start)[0]
    }

    /// The same, if its digits survive the cancellation of its terms.
    pub(crate) fn tip_square_uncancelled(
        &self,
        tip: usize,
        drift: &Poly,
        start: f64,
    ) -> Option<f64> {
        let [square, size] = self.tip_square_and_size(tip, drift, start);
        (square >= LITTLE * size).then_some(square)
    }

    fn tip_square_and_size(&self, tip: usize, drift: &Poly, start: f64) -> [f64; 2] {
        let own = start - self.system.viscous_form().of(self.end);
        if !self.system.varies(self.loads) {
            return [own, start];
        }
        let rate = drift.trimmed(self.span);
        let [crossed, size] = self.moment_and_size(tip, &rate);
        let forced = rate.integral_of_product(&rate, self.span);
        [own + 2.0 * crossed + forced, start + 2.0 * size + forced]
    }
}

/// `1 / (i + k + 1)`: integrals of powers' products.
const INTEGRALS: [[f64; TAYLOR]; TAYLOR] = {
    let mut table = [[0.0; TAYLOR]; TAYLOR];
    let mut i = 0;
    while i < TAYLOR {
        let mut k = 0;
        while k < TAYLOR {
            table[i][k] = 1.0 / (i + k + 1) as f64;
            k += 1;
        }
        i += 1;
    }
    table
};

/// `int_0^1 t^k` times a polynomial.
pub(crate) fn moments(a: &[f64; TAYLOR]) -> [f64; TAYLOR] {
    let mut sums = [0.0; TAYLOR];
    for (x, row) in a.iter().zip(&INTEGRALS) {
        sums.iter_mut().zip(row).for_each(|(s, r)| *s += x * r);
    }
    sums
}

/// `int_0^1` of a polynomial times one of these moments.
pub(crate) fn product(moments: &[f64; TAYLOR], b: &[f64; TAYLOR]) -> f64 {
    moments.iter().zip(b).map(|(m, b)| m * b).sum()
}
