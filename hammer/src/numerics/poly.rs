//! Polynomials in time.

use crate::numerics::bernstein::{self, changes};
use crate::numerics::kernel::{LANES, MOST, Row, Sums, vectorised};
use crate::numerics::series::LOW as SHORT;
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Number of coefficients. Under an input of order [`crate::MAX_INPUT_ORDER`], a rigid body moves by a polynomial two
/// degrees higher. A coordinate that is slow compared with its load needs the most (see `modal/system/response.rs`).
pub const TERMS: usize = 24;
const _: () = assert!(TERMS >= crate::MAX_INPUT_ORDER + 3 && TERMS <= bernstein::MOST);

/// `sum_k c_k t^k`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Poly(pub [f64; TERMS]);

impl Poly {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        let mut p = Self::default();
        p.0[0] = value;
        p
    }

    /// The parabola with these coefficients.
    pub fn parabola(c: [f64; 3]) -> Self {
        let mut p = Self::default();
        p.0[..3].copy_from_slice(&c);
        p
    }

    /// The Taylor polynomial with this value and these derivatives at 0.
    pub fn taylor(derivatives: &[f64]) -> Self {
        let mut p = Self::default();
        let mut factorial = 1.0;
        for (k, d) in derivatives.iter().enumerate() {
            factorial *= (k as f64).max(1.0);
            p.0[k] = d / factorial;
        }
        p
    }

    /// The highest power with a coefficient that is not zero.
    pub fn degree(&self) -> usize {
        let high = match none(&self.0[MIDDLE..]) {
            false => TERMS,
            true if none(&self.0[LOW..MIDDLE]) => LOW,
            true => MIDDLE,
        };
        self.0[..high].iter().rposition(|&c| c != 0.0).unwrap_or(0)
    }

    /// Value at `t`.
    pub fn at(&self, t: f64) -> f64 {
        if t == 0.0 {
            return self.0[0];
        }
        self.0[..=self.degree()].iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Value and first derivatives at `t`.
    pub fn derivatives_at<const COUNT: usize>(&self, t: f64) -> [f64; COUNT] {
        let (degree, mut derivatives, mut factorial) = (self.degree(), [0.0; COUNT], 1.0);
        if COUNT <= 3 {
            for c in self.0[..=degree].iter().rev() {
                for k in (1..COUNT).rev() {
                    derivatives[k] = derivatives[k] * t + derivatives[k - 1];
                }
                derivatives[0] = derivatives[0] * t + c;
            }
            derivatives.iter_mut().skip(2).for_each(|second| *second *= 2.0);
            return derivatives;
        }
        if t == 0.0 {
            for (k, (derivative, c)) in derivatives.iter_mut().zip(&self.0[..=degree]).enumerate() {
                factorial *= (k as f64).max(1.0);
                *derivative = factorial * c;
            }
            return derivatives;
        }
        let mut c = self.0;
        let c = &mut c[..=degree];
        for (k, derivative) in derivatives.iter_mut().take(degree + 1).enumerate() {
            let mut sum = 0.0;
            for c in c[k..].iter_mut().rev() {
                sum = *c + t * sum;
                *c = sum;
            }
            factorial *= (k as f64).max(1.0);
            *derivative = factorial * c[k];
        }
        derivatives
    }

    /// `int_0^t self`.
    pub fn integral(&self, t: f64) -> f64 {
        (0..=self.degree()).rev().fold(0.0, |sum, k| (sum + self.0[k] / (k + 1) as f64) * t)
    }

    /// `int_0^t self other`.
    pub fn integral_of_product(&self, other: &Self, t: f64) -> f64 {
        let (degree, more) = (self.degree(), other.degree());
        let mut product = [0.0; 2 * TERMS];
        for (i, a) in self.0[..=degree].iter().enumerate() {
            if more < MIDDLE {
                (0..MIDDLE).for_each(|k| product[i + k] += a * other.0[k]);
            } else {
                let each = product[i..].iter_mut().zip(&other.0);
                each.for_each(|(sum, b)| *sum += a * b);
            }
        }
        let terms = product[..=degree + more].iter().zip(&OVER).rev();
        terms.fold(0.0, |sum, (c, over)| (sum + c * over) * t)
    }

    /// Drops the highest powers that are negligible on `[0, t]`: those below a thousandth of a rounding of the
    /// largest term.
    pub fn trimmed(mut self, t: f64) -> Self {
        let sizes = self.scaled(t).0.map(f64::abs);
        let least = f64::EPSILON / 1024.0 * sizes.iter().fold(0.0, |a: f64, &b| a.max(b));
        for (c, size) in self.0.iter_mut().zip(sizes).skip(1).rev() {
            if size > least {
                break;
            }
            *c = 0.0;
        }
        self
    }

    /// The same function, in terms of time divided by `t`.
    pub fn scaled(mut self, t: f64) -> Self {
        let mut power = 1.0;
        for c in &mut self.0[1..] {
            power *= t;
            *c *= power;
        }
        self
    }

    /// The derivative.
    pub fn derivative(&self) -> Self {
        let mut p = Self::default();
        for k in 1..=self.degree() {
            p.0[k - 1] = k as f64 * self.0[k];
        }
        p
    }

    /// The same function, in terms of a time that begins `t` later.
    pub fn shifted(&self, t: f64) -> Self {
        let mut p = *self;
        p.shift(t);
        p
    }

    /// Moves the origin of time to `t` later.
    #[inline]
    pub fn shift(&mut self, t: f64) {
        if !self.is_constant() {
            self.shift_all(t);
        }
    }

    fn shift_all(&mut self, t: f64) {
        let degree = self.degree();
        let (lower, rest) = self.0.split_at_mut(degree);
        for i in 0..lower.len() {
            let mut sum = rest[0];
            for c in lower[i..].iter_mut().rev() {
                sum = *c + t * sum;
                *c = sum;
            }
        }
    }

    /// The times on `[0, to]` at which a parabola turns.
    #[inline]
    pub fn turn(&self, to: f64) -> Option<f64> {
        let [_, first, second, ..] = self.0;
        let last = (first + to * second) + to * second; // Rounded as in `shift`.
        let turns = first * last <= 0.0 && second != 0.0;
        turns.then(|| (-0.5 * first / second).clamp(0.0, to))
    }

    /// The times on `[0, to]` at which the polynomial turns, in order, and `to`. (If the polynomial continues after
    /// `to`, rounding may change the sign of its rate there.)
    pub fn turns(&self, to: f64) -> Vec<f64> {
        let mut turns = Vec::new();
        if self.degree() <= 2 {
            turns.extend(self.turn(to));
        } else if self.may_turn(to) {
            let rate = self.derivative().scaled(to);
            let rate = &rate.0[..=rate.degree()];
            turns.extend(changes(rate).into_iter().map(|turn| turn * to));
        }
        turns.push(to);
        turns
    }

    /// False if the rate's first term outweighs all others on `[0, to]`, so that its sign does not change.
    pub fn may_turn(&self, to: f64) -> bool {
        let (mut changes, mut power) = (0.0, 1.0);
        for (k, c) in self.0[..=self.degree()].iter().enumerate().skip(2) {
            power *= to;
            changes += k as f64 * c.abs() * power;
        }
        self.0[1].abs() <= changes
    }

    /// True if the polynomial does not vary.
    pub fn is_constant(&self) -> bool {
        self.0[1] == 0.0 && none(&self.0[2..])
    }

    /// The polynomial with these coefficients in terms of time over a span.
    pub fn of_part(powers: &[f64], span: f64) -> Self {
        let mut poly = Self::default();
        poly.0[..powers.len()].copy_from_slice(powers);
        poly.scaled(1.0 / span)
    }

    /// `self + factor * other`.
    pub fn plus(mut self, factor: f64, other: &Self) -> Self {
        self.add(factor, other);
        self
    }

    /// Adds `factor * other`.
    #[inline]
    pub fn add(&mut self, factor: f64, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a += factor * b);
    }
}

/// `1 / (k + 1)`, by which the integral of the power `k` is multiplied.
pub static OVER: [f64; 2 * TERMS] = {
    let (mut over, mut k) = ([1.0; 2 * TERMS], 1);
    while k < over.len() {
        over[k] /= (k + 1) as f64;
        k += 1;
    }
    over
};

vectorised! {
    /// Adds `sum_j factors_j` times derivative `j` of a short polynomial.
    pub fn add_derivatives(sum: &'a mut Poly, factors: &'a [f64], other: &'a Poly) -> () as AddDerivatives, simd {
        let width = LANES / S::F64_LANES;
        let mut padded = [0.0; SHORT + LANES];
        padded[..SHORT].copy_from_slice(&other.0[..SHORT]);
        let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
        for ((factor, rising), c) in factors.iter().zip(&RISING).zip(padded.windows(LANES)) {
            let factor = simd.splat_f64s(*factor);
            let (rising, c) = (S::as_simd_f64s(rising).0, S::as_simd_f64s(c).0);
            for g in 0..width {
                let risen = simd.mul_f64s(rising[g], c[g]);
                sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(factor, risen));
            }
        }
        let out = S::as_mut_simd_f64s(&mut sum.0[..LANES]).0;
        for (c, sum) in out.iter_mut().zip(sums) {
            *c = simd.add_f64s(*c, sum);
        }
    }
}

/// `(k + j)! / k!`, in the order `[j][k]`: coefficient `k` of derivative `j` over coefficient `k + j`.
static RISING: [Row; SHORT] = {
    let (mut all, mut j) = ([[1.0; LANES]; SHORT], 1);
    while j < SHORT {
        let mut k = 0;
        while k < SHORT {
            all[j][k] = all[j - 1][k] * (k + j) as f64;
            k += 1;
        }
        j += 1;
    }
    all
};

/// Most polynomials have at most this many coefficients.
const LOW: usize = 4;
/// Most of the others, which describe a gas, have at most this many.
const MIDDLE: usize = 12;

/// True if all coefficients are zero. The loop has no branch, so that it is vectorised.
#[inline]
fn none(c: &[f64]) -> bool {
    // The shift removes the sign.
    c.iter().fold(0, |all, c| all | c.to_bits()) << 1 == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(t - 1)^2 (t - 3)^2` turns at 1, 2 and 3, which bisection finds to a rounding of 3. A parabola turns once.
    #[test]
    fn a_polynomial_turns_where_its_rate_changes_sign() {
        // The derivatives at 0 of 9 - 24 t + 22 t^2 - 8 t^3 + t^4.
        let p = Poly::taylor(&[9.0, -24.0, 44.0, -48.0, 24.0]);
        let turns = p.turns(4.0);
        assert_eq!(turns.len(), 4);
        let expected = [1.0, 2.0, 3.0, 4.0];
        assert!(turns.iter().zip(expected).all(|(t, at)| (t - at).abs() < 1e-14), "{turns:?}");
        assert_eq!(p.turns(0.5), [0.5]);
        let thrown = Poly::parabola([5.0, -3.0, 2.0]);
        assert_eq!((thrown.turn(1.0), thrown.turns(1.0)), (Some(0.75), vec![0.75, 1.0]));
        assert_eq!((thrown.turn(0.7), Poly::constant(2.0).turn(1.0)), (None, None));
    }
}
