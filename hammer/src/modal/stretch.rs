//! Exact integrals over a stretch between two events.
//!
//! Over such a stretch loads are polynomials, displacements `c . z(t) + poly(t)`, and
//!
//! * `int f(t) c . z dt` follows from `z = (B^-1 z)'` by parts, once per degree;
//! * `int z.W z dt = z.Q z` at the start less that at the end, with the Lyapunov solution
//!   `B^T Q + Q B = -W`: the damping's work (`W` the damping power of the velocities) and
//!   the viscous work (`W` the square of the tip's velocity).

use crate::modal::system::{CHANNELS, Functional, ORDERS, System};
use crate::modal::track::Track;
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::{Poly, TERMS};

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
    /// Uniform translation.
    pub translation: &'a Poly,
}

impl<'a> Stretch<'a> {
    /// A track from its anchor to `end`.
    pub fn new(
        track: &'a Track,
        start: &'a [f64],
        span: f64,
        loads: &'a [Poly; CHANNELS],
        translation: &'a Poly,
    ) -> Self {
        Self { system: &track.system, start, end: &track.z, span, loads, translation }
    }

    fn functional(&self, index: usize) -> &Functional {
        &self.system.functionals[index]
    }

    /// Change of a displacement.
    pub fn change(&self, index: usize) -> f64 {
        let f = self.functional(index);
        let poly = f.poly(self.loads, self.translation);
        let modal = kernel::dot(&f.rows[0], self.end) - kernel::dot(&f.rows[0], self.start);
        poly.at(self.span) - poly.0[0] + modal
    }

    /// Integral of a displacement over time.
    pub fn integral(&self, index: usize) -> f64 {
        let f = self.functional(index);
        let poly = integrate(&f.poly(self.loads, self.translation), self.span);
        poly + kernel::dot(&f.integral, self.end) - kernel::dot(&f.integral, self.start)
    }

    /// `int load(t) u'(t) dt` for the displacement `index`.
    pub fn work(&self, index: usize, load: &Poly) -> f64 {
        if load.is_constant() {
            return load.0[0] * self.change(index);
        }
        let f = self.functional(index);
        let rate = f.poly(self.loads, self.translation).derivative();
        integrate_product(load, &rate, self.span) + self.moment(&f.rows[1], load)
    }

    /// `int load(t) c . z(t) dt`, by parts.
    fn moment(&self, c: &[f64], load: &Poly) -> f64 {
        let (mut sum, mut sign) = (0.0, 1.0);
        let (mut row, mut p) = (c.to_vec(), *load);
        for _ in 0..TERMS {
            row = self.system.integral_of(&row);
            let (end, start) = (kernel::dot(&row, self.end), kernel::dot(&row, self.start));
            sum += sign * (p.at(self.span) * end - p.0[0] * start);
            p = p.derivative();
            sign = -sign;
        }
        sum
    }

    /// Work lost in the bars; `energy` gives `z.Q z` at start and end.
    pub fn damping(&self, energy: [f64; 2]) -> f64 {
        let mut sum = energy[0] - energy[1];
        for channel in 0..CHANNELS {
            if self.loads[channel].is_constant() {
                continue;
            }
            sum += self.forced_damping(channel);
        }
        sum
    }

    /// The part of the damping's work due to a load that varies: the static shape moves.
    fn forced_damping(&self, channel: usize) -> f64 {
        let mut sum = 0.0;
        let mut rate = self.loads[channel];
        for j in 0..ORDERS {
            let s = &self.system.statics[channel][j];
            let cross = self.system.damping_cross(s);
            sum += 2.0 * self.moment(&cross, &rate);
            for other in 0..CHANNELS {
                if self.loads[other].is_constant() {
                    continue;
                }
                let mut b = self.loads[other];
                for k in 0..ORDERS {
                    let power = kernel::dot(&cross, &self.system.statics[other][k]);
                    sum += power * integrate_product(&rate, &b, self.span);
                    b = b.derivative();
                }
            }
            rate = rate.derivative();
        }
        sum
    }

    /// `int p'^2 dt` of the tip; `start` is the viscous form at the start.
    pub fn tip_square(&self, tip: usize, start: f64) -> f64 {
        let mut sum = start - self.system.viscous_form().of(self.end);
        if self.loads.iter().any(|l| !l.is_constant()) {
            let f = self.functional(tip);
            let rate = f.poly(self.loads, self.translation).derivative();
            sum +=
                2.0 * self.moment(&f.rows[1], &rate) + integrate_product(&rate, &rate, self.span);
        }
        sum
    }
}

/// `int_0^t p`.
fn integrate(p: &Poly, t: f64) -> f64 {
    (0..TERMS).rev().fold(0.0, |sum, k| (sum + p.0[k] / (k + 1) as f64) * t)
}

/// `int_0^t p q`.
fn integrate_product(p: &Poly, q: &Poly, t: f64) -> f64 {
    let mut sum = 0.0;
    for (i, a) in p.0.iter().enumerate() {
        for (k, b) in q.0.iter().enumerate() {
            if *a != 0.0 && *b != 0.0 {
                sum += a * b * math::powi(t, i + k + 1) / (i + k + 1) as f64;
            }
        }
    }
    sum
}
