//! States `(x, x')` in the modes of the secular function, the two numbers of each mode together. In them the system
//! is `A`, and with
//!
//! ```text
//! N = [[C, 1], [1, 0]],      H = N A = [[-K, 0], [0, 1]]
//! ```
//!
//! vectors of different roots are orthogonal in `N` and in `H`.

use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::pairing::{Eigenpair, is_decay};
use crate::numerics::kernel::inner_product as dot;
use crate::numerics::math;
use nalgebra::DMatrix;
use num_complex::Complex64 as C;

/// Two vectors of nearly equal roots that share more than this are of one pair.
const SHARED: f64 = 1e-3;
/// Roots further apart than this, relative to their size, are of different pairs.
const NEAR: f64 = 1e-6;

/// An eigenpair with its dual, which is the product of `N` and its state, and the product of both.
pub(crate) struct Vector {
    pub(crate) pair: Eigenpair,
    dual: Vec<C>,
    square: C,
}

impl Vector {
    pub(crate) fn new(system: &Deflated, (s, x): Eigenpair) -> Self {
        let parts = |part: fn(&C) -> f64| damped(system, &x.iter().map(part).collect::<Vec<_>>());
        let damped = parts(|z| z.re).into_iter().zip(parts(|z| z.im));
        let both = damped.map(|(re, im)| C::new(re, im)).zip(&x);
        let dual: Vec<C> = both.flat_map(|(damped, x)| [damped + s * x, *x]).collect();
        let square = product(&dual, s, &x);
        Self { pair: (s, x), dual, square }
    }

    /// True if both are nearly the same.
    pub(crate) fn repeats(&self, other: &Self) -> bool {
        let limit = SHARED * SHARED * math::norm(self.square) * math::norm(other.square);
        math::norm(self.pair.0 - other.pair.0) <= NEAR * math::norm(self.pair.0)
            && product(&self.dual, other.pair.0, &other.pair.1).norm_sqr() > limit
    }

    /// Dimensions of the space that it spans with its conjugate.
    pub(crate) fn taken(&self) -> usize {
        if is_decay(&self.pair) { 1 } else { 2 }
    }

    /// Share of each unit state that is in this space.
    pub(crate) fn parts(&self) -> impl Iterator<Item = f64> {
        let (s, x) = &self.pair;
        let state = x.iter().flat_map(move |x| [*x, s * x]);
        let both = self.dual.iter().zip(state);
        both.map(|(dual, state)| self.taken() as f64 * (dual * state / self.square).re)
    }

    /// Removes from a state its components along this vector and its conjugate.
    pub(crate) fn leave(&self, z: &mut [f64]) {
        let share: C = self.dual.iter().zip(&*z).map(|(d, z)| d * z).sum();
        let share = self.taken() as f64 * share / self.square;
        for (z, x) in z.chunks_exact_mut(2).zip(&self.pair.1) {
            z[0] -= (share * x).re;
            z[1] -= (share * self.pair.0 * x).re;
        }
    }
}

/// The product of a dual with the state of an eigenpair.
fn product(dual: &[C], s: C, x: &[C]) -> C {
    dual.chunks_exact(2).zip(x).map(|(d, x)| (d[0] + s * d[1]) * x).sum()
}

/// Forces of the bars, by `share` of their stiffness, and of the attachments, by one of their two numbers.
fn forces(system: &Deflated, share: f64, number: fn(&(f64, f64)) -> f64, x: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = system.omega2.iter().zip(x).map(|(w2, x)| share * w2 * x).collect();
    for (shape, spring) in system.shapes.iter().zip(&system.springs) {
        let force = number(spring) * dot(shape, x);
        out.iter_mut().zip(shape).for_each(|(out, phi)| *out += force * phi);
    }
    out
}

/// `C x`.
pub(crate) fn damped(system: &Deflated, x: &[f64]) -> Vec<f64> {
    forces(system, system.beta, |(_, viscosity)| *viscosity, x)
}

/// `K x`.
pub(crate) fn strained(system: &Deflated, x: &[f64]) -> Vec<f64> {
    forces(system, 1.0, |(stiffness, _)| *stiffness, x)
}

/// `S` of states `Z` that span an invariant space, `A Z = Z S`. It is computed as `(Z' N Z)^-1 Z' H Z`, in which an
/// error of `Z` along another vector is squared. None if `Z' N Z` is singular.
pub(crate) fn reduced(system: &Deflated, states: &[Vec<f64>]) -> Option<DMatrix<f64>> {
    let part = |at: usize| -> Vec<Vec<f64>> {
        states.iter().map(|z| z.iter().skip(at).step_by(2).copied().collect()).collect()
    };
    let (m, x, v) = (states.len(), part(0), part(1));
    let damped: Vec<_> = x.iter().map(|x| damped(system, x)).collect();
    let strained: Vec<_> = x.iter().map(|x| strained(system, x)).collect();
    let n = |i: usize, j: usize| dot(&x[i], &damped[j]) + dot(&x[i], &v[j]) + dot(&v[i], &x[j]);
    let h = |i: usize, j: usize| dot(&v[i], &v[j]) - dot(&x[i], &strained[j]);
    DMatrix::from_fn(m, m, n).lu().solve(&DMatrix::from_fn(m, m, h))
}
