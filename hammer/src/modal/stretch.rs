//! Exact integrals over a stretch between two events.
//!
//! Over such a stretch loads are polynomials, and displacements are `c . z(t) + poly(t)`. (Slow coordinates, for which
//! `B` is nearly singular, are part of `poly`: see `modal/system/response.rs`.) Therefore
//!
//! * `int f(t) c . z dt` follows from `z = (B^-1 z)'` by integration by parts, repeated for each degree of `f`;
//! * `int z.W z dt` is the value of `z.Q z` at the start minus that at the end, with `Q` from Lyapunov's equation `B^T
//!   Q + Q B = -W`. If `W` is the damping power of the velocities, this is the work of the damping; if it is the square
//!   of the tip's velocity, it is the viscous work over the viscosity.

use crate::modal::system::driven::Driven;
use crate::modal::system::{Functional, System, TAYLOR};
use crate::modal::track::Track;
use crate::numerics::kernel;
use crate::numerics::poly::{Poly, TERMS};
use crate::numerics::series::LOW;
use crate::scene::graph::CHANNELS;
use std::cell::OnceCell;

/// Radians of the fastest motion that one series covers. The first omitted term, `2^24 / 24!`, is below rounding.
pub(crate) const PANEL: f64 = 2.0;

/// A work below this share of the terms that cancel in it has fewer than thirteen correct digits.
pub(crate) const LITTLE: f64 = 1e-3;

/// One track over a stretch of time that starts at 0.
pub struct Stretch<'a> {
    /// The track's system.
    pub system: &'a System,
    /// Modal vector at the start.
    pub start: &'a [f64],
    /// Modal vector at the end.
    pub end: &'a [f64],
    /// Duration, s.
    pub span: f64,
    /// Loads as polynomials of the time since the start.
    pub loads: &'a [Poly; CHANNELS],
    /// The polynomial part of the motion.
    pub driven: &'a Driven,
}

impl<'a> Stretch<'a> {
    /// The stretch from a track's state at its anchor, `start`, to its present state.
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

    /// Change of a displacement over the stretch.
    pub fn change(&self, index: usize) -> f64 {
        self.change_of(index, &self.poly(index))
    }

    /// [`Self::change`] of a displacement whose polynomial part is `poly`.
    fn change_of(&self, index: usize, poly: &Poly) -> f64 {
        let f = self.functional(index);
        let modal = kernel::dot(&f.rows[0], self.end) - kernel::dot(&f.rows[0], self.start);
        poly.at(self.span) - poly.0[0] + modal
    }

    /// Integral of a displacement over time.
    pub fn integral(&self, index: usize) -> f64 {
        let f = self.functional(index);
        let poly = self.poly(index).integral(self.span);
        poly + kernel::dot(&f.integral, self.end) - kernel::dot(&f.integral, self.start)
    }

    /// The work `int load(t) u'(t) dt` of the load of each channel on the displacement `index`.
    pub fn works(&self, index: usize) -> impl Fn(usize) -> f64 {
        let poly = self.poly(index);
        let (change, varying) = (self.change_of(index, &poly), OnceCell::new());
        let still = self.functional(index).still;
        move |channel| {
            let load = &self.loads[channel];
            if load.is_constant() {
                return load.0[0] * change;
            }
            let degree = || self.loads.iter().map(Poly::degree).max().unwrap_or_default();
            let make = || (poly.derivative(), self.rate_moments(index, degree()));
            let (rate, moments) = varying.get_or_init(make);
            let modal = if still { 0.0 } else { self.moment_and_size(moments, load)[0] };
            load.integral_of_product(rate, self.span) + modal
        }
    }

    /// [`Self::moments`] of a displacement's rate.
    fn rate_moments(&self, index: usize, degree: usize) -> Vec<[f64; 2]> {
        if self.functional(index).still {
            return Vec::new();
        }
        self.moments(self.system.rate_integrals(index), degree)
    }

    /// The repeated integrals of `c . z` at the end and at the start, as many as a polynomial of this degree needs.
    /// `known` are the coefficients of the first of them.
    fn moments(&self, known: &[Vec<f64>], degree: usize) -> Vec<[f64; 2]> {
        let mut last = Vec::new();
        let moment = |k: usize| {
            if k >= known.len() {
                last = self.system.integral_of(if last.is_empty() { &known[k - 1] } else { &last });
            }
            let row = known.get(k).unwrap_or(&last);
            [self.end, self.start].map(|z| kernel::dot(row, z))
        };
        (0..=degree).map(moment).collect()
    }

    /// `int load(t) c . z(t) dt`, by parts, from the moments of `c . z`; and the sum of the magnitudes of its terms.
    fn moment_and_size(&self, moments: &[[f64; 2]], load: &Poly) -> [f64; 2] {
        let degree = load.degree();
        let mut at_end = [0.0; TERMS];
        if degree < LOW {
            at_end[..LOW].copy_from_slice(&load.derivatives_at::<LOW>(self.span));
        } else {
            at_end = load.derivatives_at(self.span);
        }
        let (mut sum, mut size, mut factorial) = (0.0, 0.0, 1.0);
        for (k, [end, start]) in moments.iter().enumerate().take(degree + 1) {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            factorial *= k.max(1) as f64;
            let terms = [at_end[k] * end, factorial * load.0[k] * start];
            sum += sign * (terms[0] - terms[1]);
            size += terms[0].abs() + terms[1].abs();
        }
        [sum, size]
    }

    /// Work that damping dissipates in the bars. Under constant loads it follows from `z.Q z` at the start and the end,
    /// which `energy` returns. Under varying loads it follows from the whole motion `y' = B y + b f`: `d/dt y.Q y` is
    /// `2 y.Q b f` minus the damping power.
    pub fn damping(&self, energy: impl FnOnce() -> [f64; 2]) -> f64 {
        if !self.system.varies(self.loads) && !self.system.is_braked() {
            let [start, end] = energy();
            return start - end;
        }
        let form = |end| self.system.damping_of_whole(self.loads, self.driven, end);
        let mut work = form((0.0, self.start)) - form((self.span, self.end));
        for (load, poly, integrals) in self.system.damped_loads(self.loads, self.driven) {
            let moments = self.moments(integrals, load.degree());
            let [modal, _] = self.moment_and_size(&moments, load);
            work += load.integral_of_product(&poly, self.span) + modal;
        }
        work
    }

    /// `int p'^2 dt` of the tip from the time `at`, for which `z` is the modal vector, to the end. It is found from
    /// Taylor polynomials, each of which covers a [`PANEL`].
    /// Its relative error is small even if the tip hardly moves and the forms of [`Self::tip_square`] would cancel.
    /// `drift` is the rate of the polynomial part of the tip's displacement.
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

    /// Number of panels that [`Self::tip_square_by_series`] takes for a span.
    pub(crate) fn panels(system: &System, span: f64) -> u64 {
        (span * system.rate_max / PANEL).ceil() as u64
    }

    /// `int p'^2 dt` of the tip, whose polynomial part has the rate `drift`. `start` is the value of the viscous form
    /// at the start.
    pub(crate) fn tip_square(&self, tip: usize, drift: &Poly, start: f64) -> f64 {
        self.tip_square_and_size(tip, drift, start)[0]
    }

    /// [`Self::tip_square`], or `None` if its terms cancel so much that it has too few correct digits.
    pub(crate) fn tip_square_uncancelled(
        &self,
        tip: usize,
        drift: &Poly,
        start: f64,
    ) -> Option<f64> {
        let [square, size] = self.tip_square_and_size(tip, drift, start);
        (square >= LITTLE * size).then_some(square)
    }

    /// [`Self::tip_square`], and the sum of the sizes of the terms that cancel in it.
    pub(crate) fn tip_square_and_size(&self, tip: usize, drift: &Poly, start: f64) -> [f64; 2] {
        let free = start - self.system.viscous_form().of(self.end);
        if !self.system.varies(self.loads) {
            return [free, start];
        }
        let rate = drift.trimmed(self.span);
        let moments = self.rate_moments(tip, rate.degree());
        let [cross_term, size] = self.moment_and_size(&moments, &rate);
        let forced = rate.integral_of_product(&rate, self.span);
        [free + 2.0 * cross_term + forced, start + 2.0 * size + forced]
    }
}

/// `1 / (i + k + 1)`, the integral of `t^i t^k` over `[0, 1]`.
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

/// `int_0^1 t^k a(t) dt` for each `k`.
pub(crate) fn moments(a: &[f64; TAYLOR]) -> [f64; TAYLOR] {
    let mut sums = [0.0; TAYLOR];
    for (x, row) in a.iter().zip(&INTEGRALS) {
        sums.iter_mut().zip(row).for_each(|(s, r)| *s += x * r);
    }
    sums
}

/// `int_0^1 a(t) b(t) dt`, from the [`moments`] of `a`.
pub(crate) fn product(moments: &[f64; TAYLOR], b: &[f64; TAYLOR]) -> f64 {
    moments.iter().zip(b).map(|(m, b)| m * b).sum()
}
