//! The motion of a rigid hammer in a window of the air.
//!
//! Both bodies are expanded with the air in one series ([`super::steel::Pair`]), so their displacements are polynomials
//! of the time, and nothing else moves. The forces of the air are the polynomials under which this motion is exact:
//! those of the pressures, but for the two highest powers, which differ by what the series leaves out. So the energy
//! balance of the bodies is exact.

use super::part::Part;
use super::steel::Pair;
use crate::numerics::kernel::{Row, vectorised};
use crate::numerics::poly::{OVER, Poly};
use crate::numerics::series::{self, HIGH, HighPowers, ORDER};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};
use std::array::from_fn;

/// Number of powers of the integral of a squared velocity.
pub(crate) const SQUARE: usize = 2 * HIGH;

/// The motion of a rigid piston and a rigid bit over a window of the air.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// Length of the window, s. The polynomials are in the time divided by it.
    pub length: f64,
    /// Coefficients of the displacements of piston and bit, m, and of the air's forces on them, N; one row per power.
    pub rows: [[f64; 4]; HIGH + 1],
    /// Bounds on the rounding of the displacements (m) and of the velocities (m/s) at the epoch.
    pub rounding: [f64; 2],
}

vectorised! {
    /// Adopts the series of a window: the displacements `u`, and the air's forces in the first two lanes of `rows`.
    pub(super) fn adopt(course: &'a mut Course, pair: &'a Pair, u: &'a [[f64; 2]; HIGH + 1], rows: &'a [Row; ORDER + 1], length: f64) -> () as Adopt, _simd {
        let powers: HighPowers = series::powers(length);
        for ((row, [p, q]), power) in course.rows.iter_mut().zip(u).zip(powers) {
            *row = [power * p, power * q, 0.0, 0.0];
        }
        for ((row, [f, b, ..]), power) in course.rows.iter_mut().zip(rows).zip(powers) {
            [row[2], row[3]] = [power * f, power * b];
        }
        for k in [HIGH - 1, HIGH] {
            let [f, b] = pair.forces(u, k);
            [course.rows[k][2], course.rows[k][3]] = [powers[k] * f, powers[k] * b];
        }
        course.length = length;
    }
}

vectorised! {
    /// At a time over the window's length: displacements of piston and bit and the sums of their terms' sizes, then the
    /// rates of all four.
    fn ends(rows: &'a [[f64; 4]; HIGH + 1], tau: f64) -> [[f64; 4]; 2] as Ends, _simd {
        let (mut values, mut rates) = ([0.0; 4], [0.0; 4]);
        for [p, q, ..] in rows.iter().rev() {
            let row = [*p, *q, p.abs(), q.abs()];
            for i in 0..4 {
                rates[i] = rates[i] * tau + values[i];
                values[i] = values[i] * tau + row[i];
            }
        }
        [values, rates]
    }
}

/// Bounds over a window on the piston's relative position, the tip's displacement, and the tip's velocity.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounds {
    pub most: [f64; CURVES],
    pub least: [f64; CURVES],
}

impl Bounds {
    /// A bound on the sum of the sizes of a curve's terms.
    pub(crate) fn size(&self, place: usize) -> f64 {
        let (most, least) = (self.most[place], self.least[place]);
        // The first term lies between both bounds, and all others are between it and one of them.
        most - least + most.abs().max(least.abs())
    }
}

/// The number of these, with one that fills a vector.
pub(crate) const CURVES: usize = 4;

vectorised! {
    /// The bounds over the whole window.
    fn bounds(course: &'a Course) -> Bounds as Bound, _simd {
        let over = 1.0 / course.length;
        let ([[p, q, ..], second, ..], mut factors) = (course.rows, [1.0, 1.0, over, 0.0]);
        // A velocity begins with the second power.
        let start = [p - q, q, over * second[1], 0.0];
        let mut all = Bounds { most: start, least: start };
        let mut add = |terms: [f64; CURVES]| {
            for (i, term) in terms.into_iter().enumerate() {
                all.most[i] += if term > 0.0 { term } else { 0.0 };
                all.least[i] += if term < 0.0 { term } else { 0.0 };
            }
        };
        add([second[0] - second[1], second[1], 0.0, 0.0]);
        for [p, q, ..] in &course.rows[2..] {
            factors[2] += over;
            let terms = [p - q, *q, *q, 0.0];
            add(from_fn(|i| factors[i] * terms[i]));
        }
        all
    }
}

vectorised! {
    /// The square of a velocity, one power higher.
    fn squared(speed: &'a [f64; HIGH]) -> [f64; SQUARE] as Squared, _simd {
        let mut square = [0.0; SQUARE];
        for (i, a) in speed.iter().enumerate() {
            let sums = &mut square[i + 1..][..HIGH];
            for j in 0..HIGH {
                sums[j] += a * speed[j];
            }
        }
        square
    }
}

impl Course {
    /// Bodies at these displacements and velocities, before a window begins.
    pub(crate) fn from([p, q]: [f64; 2], [v, w]: [f64; 2]) -> Self {
        let mut course = Self { length: 1.0, ..Self::default() };
        (course.rows[0], course.rows[1]) = ([p, q, 0.0, 0.0], [v, w, 0.0, 0.0]);
        course
    }

    /// A displacement with these shares of piston and bit, and its first rates (at most three), at `t` after the epoch.
    pub(crate) fn rates<const COUNT: usize>(&self, shares: [f64; 2], t: f64) -> [f64; COUNT] {
        let (tau, mut rates) = (t / self.length, [0.0; COUNT]);
        for [p, q, ..] in self.rows.iter().rev() {
            for k in (1..COUNT).rev() {
                rates[k] = rates[k] * tau + rates[k - 1];
            }
            rates[0] = rates[0] * tau + (shares[0] * p + shares[1] * q);
        }
        let mut factor = 1.0;
        for (k, rate) in rates.iter_mut().enumerate().skip(1) {
            factor *= k as f64 / self.length;
            *rate *= factor;
        }
        rates
    }

    /// False if the piston certainly moves in one direction until `t`.
    pub(crate) fn piston_may_turn(&self, t: f64) -> bool {
        let (tau, mut changes) = (t / self.length, 0.0);
        for (k, row) in self.rows.iter().enumerate().skip(2).rev() {
            changes = (changes + k as f64 * row[0].abs()) * tau;
        }
        self.rows[1][0].abs() <= changes
    }

    /// Moves the origin of displacements to `shift` further down, where the bit then is at `tip`.
    pub(crate) fn move_origin(&mut self, shift: f64, tip: f64) {
        self.rows[0][0] -= shift;
        self.rows[0][1] = tip;
    }

    /// Displacements and velocities of piston and bit at the epoch.
    pub(crate) fn start(&self) -> [[f64; 2]; 2] {
        let ([p, q, ..], [v, w, ..]) = (self.rows[0], self.rows[1]);
        [[p, q], [v / self.length, w / self.length]]
    }

    /// Displacements and velocities of piston and bit at `t` after the epoch.
    pub(crate) fn at(&self, t: f64) -> [[f64; 2]; 2] {
        let [[p, q, ..], [v, w, ..]] = ends(&self.rows, t / self.length);
        [[p, q], [v / self.length, w / self.length]]
    }

    /// The bodies at `t` after the epoch, before the next window begins.
    pub(crate) fn shifted(&self, t: f64) -> Self {
        let ([[p, q, a, b], [v, w, c, d]], over) =
            (ends(&self.rows, t / self.length), 1.0 / self.length);
        let unit = HIGH as f64 * f64::EPSILON;
        let rounding = [unit * (a + b), unit * (c + d) * over];
        Self { rounding, ..Self::from([p, q], [v * over, w * over]) }
    }

    /// A window of 1 s in which the bit has this displacement, and nothing else moves.
    #[cfg(test)]
    pub(crate) fn of_tip(powers: &HighPowers) -> Self {
        let mut course = Self::from([0.0; 2], [0.0; 2]);
        course.rows.iter_mut().zip(powers).for_each(|(row, c)| row[1] = *c);
        course
    }

    /// Bounds over the whole window.
    pub(crate) fn bounds(&self) -> Bounds {
        bounds(self)
    }

    /// A displacement with these shares of piston and bit, in the time over the window's length.
    pub(crate) fn powers(&self, [first, second]: [f64; 2]) -> HighPowers {
        self.rows.map(|[p, q, ..]| first * p + second * q)
    }

    /// The same displacement as a polynomial of time.
    pub(crate) fn poly(&self, shares: [f64; 2]) -> Poly {
        Poly::of_part(&self.powers(shares), self.length)
    }

    /// The forces of the air on piston and bit.
    pub(crate) fn forces(&self) -> [Poly; 2] {
        [2, 3].map(|i| Poly::of_part(&self.rows.map(|row| row[i]), self.length))
    }

    /// The window up to `t`, over which works and impulses are integrated.
    pub(crate) fn part(&self, t: f64) -> Part {
        Part::new(&self.rows, t, t / self.length)
    }

    /// `int u_2'^2 dt` of the bit as a polynomial of the time over the window's length, m2/s.
    pub(crate) fn bit_square(&self) -> [f64; SQUARE] {
        let over = 1.0 / self.length;
        let speed: [f64; HIGH] = from_fn(|k| (k + 1) as f64 * self.rows[k + 1][1] * over);
        let mut square = squared(&speed);
        square[1..].iter_mut().zip(OVER).for_each(|(c, over)| *c *= self.length * over);
        square
    }

    /// True if every number is finite, and the window has a length.
    pub(crate) fn is_sound(&self) -> bool {
        let numbers = self.rows.iter().flatten().chain(&self.rounding).chain([&self.length]);
        numbers.into_iter().all(|x| x.is_finite()) && self.length > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::rock::Coefficients;
    use crate::numerics::series::LOW;

    /// Two bodies whose displacements are parabolas, over a window of 2 ms.
    fn parabolas() -> (Pair, Course) {
        let mut pair = Pair { masses: [9.0, 14.0], contact: 3e6, unit: 1.0, ..Pair::default() };
        pair.rock = Coefficients { stiffness: 2e6, viscosity: 5e3 };
        (pair.others[0][0], pair.others[1][1]) = (88.0, 3e4);
        let mut u = [[0.0; 2]; HIGH + 1];
        (u[0], u[1], u[2]) = ([-2e-3, 1e-3], [8.0, -0.5], [-900.0, 300.0]);
        let mut rows = [[0.0; 8]; ORDER + 1];
        for (k, row) in rows.iter_mut().enumerate() {
            [row[0], row[1]] = pair.forces(&u, k);
        }
        let mut course = Course::default();
        adopt(&mut course, &pair, &u, &rows, 2e-3);
        (pair, course)
    }

    /// The forces are those of Newton's second law, for parabolas in closed form, at any instant.
    #[test]
    fn the_forces_are_those_under_which_the_bodies_move_so() {
        let (pair, course) = parabolas();
        let [drive, anvil] = course.forces();
        for t in [0.0, 3e-4, 2e-3] {
            let [u, v] = course.at(t);
            let pressed = pair.contact * (u[0] - u[1]);
            let expected = [
                pair.masses[0] * -1800.0 + pressed - 88.0,
                pair.masses[1] * 600.0 - pressed + 2e6 * u[1] + 5e3 * v[1] - 3e4 * t,
            ];
            for (force, expected) in [drive, anvil].map(|force| force.at(t)).iter().zip(expected) {
                // Roundings of terms below 5e4 N.
                assert!((force - expected).abs() < 1e-9, "{t}: {force} for {expected}");
            }
            let rates: [f64; 3] = course.rates([1.0, -1.0], t);
            let closed = [-3e-3 + (8.5 - 1200.0 * t) * t, 8.5 - 2400.0 * t, -2400.0];
            for (rate, closed) in rates.iter().zip(closed) {
                assert!((rate - closed).abs() < 1e-12 * closed.abs().max(1.0), "{rate} {closed}");
            }
        }
    }

    /// Works of the air are what the bodies gain in kinetic energy and in that of the springs, less the work of the other
    /// loads and with what the dashpot takes: the balance of energy in closed form.
    #[test]
    fn works_integrals_and_squares_balance_the_energy() {
        let (pair, course) = parabolas();
        for t in [1e-4, 2e-3] {
            let [[first, _], [_, second]] = course.part(t).works();
            let energy = |t: f64| {
                let [u, v] = course.at(t);
                let kinetic = pair.masses[0] * v[0] * v[0] + pair.masses[1] * v[1] * v[1];
                let gap = u[0] - u[1];
                0.5 * (kinetic + pair.contact * gap * gap + pair.rock.stiffness * u[1] * u[1])
            };
            let square = course.bit_square();
            let tau = t / course.length;
            let lost = 5e3 * square.iter().rev().fold(0.0, |sum, c| sum * tau + c);
            let mut others = [[0.0; LOW]; 2];
            (others[0][0], others[1][1]) = (88.0, 3e4);
            let [given, _] = course.part(t).works_of(&others[0]);
            let [_, fed] = course.part(t).works_of(&others[1]);
            let left = first + second + given + fed - (energy(t) - energy(0.0)) - lost;
            // Roundings of energies of some hundred joules.
            assert!(left.abs() < 1e-11, "{t}: {left:e}");
            let integral = course.part(t).integral([1.0, -1.0]);
            let closed = t * (-3e-3 + t * (4.25 - 400.0 * t));
            assert!((integral - closed).abs() < 1e-18, "{integral:e} {closed:e}");
        }
    }

    /// The bounds contain the curves everywhere in the window, and a moved epoch changes nothing but the rounding.
    #[test]
    fn bounds_contain_what_they_bound() {
        let (_, course) = parabolas();
        let bounds = course.bounds();
        let Bounds { most, least } = bounds;
        for i in 0..=20 {
            let [[p, q], [_, w]] = course.at(1e-4 * f64::from(i));
            for (k, x) in [p - q, q, w].into_iter().enumerate() {
                assert!(least[k] <= x && x <= most[k] && x.abs() <= bounds.size(k), "{i} {k}: {x}");
            }
        }
        let moved = course.shifted(7e-4);
        let ([u, v], at) = (moved.start(), course.at(7e-4));
        for (one, other) in [u, v].as_flattened().iter().zip(at.as_flattened()) {
            assert!((one - other).abs() <= 4.0 * f64::EPSILON * other.abs());
        }
        assert!(moved.rounding[0] > 0.0 && moved.rounding[0] < 1e-16 && moved.is_sound());
    }
}
