//! States `(x, x')` in the modes of the secular function. The two numbers of each mode are stored together.
//!
//! The system is `z' = A z` for such a state `z`. With
//!
//! ```text
//! N = [[C, 1], [1, 0]],      H = N A = [[-K, 0], [0, 1]]
//! ```
//!
//! the vectors of different roots are orthogonal in `N` and in `H`.

use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::pairing::{Eigenpair, is_decay};
use crate::numerics::kernel::inner_product as dot;
use crate::numerics::math;
use nalgebra::DMatrix;
use num_complex::Complex64 as C;

/// If the normalised product of two vectors of nearly equal roots is above this, they belong to one pair.
const SHARED: f64 = 1e-3;
/// Roots that differ by more than this, relative to their size, belong to different pairs.
const NEAR: f64 = 1e-6;

/// An eigenpair with its dual, which is `N` times its state, and the product of dual and state.
pub(crate) struct Vector {
    pub(crate) pair: Eigenpair,
    dual: Vec<C>,
    square: C,
}

impl Vector {
    pub(crate) fn new(system: &Deflated, (s, x): Eigenpair) -> Self {
        let part = |part: fn(&C) -> f64| damped(system, &x.iter().map(part).collect::<Vec<_>>());
        let damped = part(|z| z.re).into_iter().zip(part(|z| z.im));
        let modes = damped.map(|(re, im)| C::new(re, im)).zip(&x);
        let dual: Vec<C> = modes.flat_map(|(damped, x)| [damped + s * x, *x]).collect();
        let square = product(&dual, s, &x);
        Self { pair: (s, x), dual, square }
    }

    /// True if this vector and another are nearly the same.
    pub(crate) fn repeats(&self, other: &Self) -> bool {
        let limit = SHARED * SHARED * math::norm(self.square) * math::norm(other.square);
        math::norm(self.pair.0 - other.pair.0) <= NEAR * math::norm(self.pair.0)
            && product(&self.dual, other.pair.0, &other.pair.1).norm_sqr() > limit
    }

    /// Number of dimensions of the space that the vector and its conjugate span.
    pub(crate) fn taken(&self) -> usize {
        if is_decay(&self.pair) { 1 } else { 2 }
    }

    /// The share of each unit state that lies in that space.
    pub(crate) fn parts(&self) -> impl Iterator<Item = f64> {
        let (s, x) = &self.pair;
        let state = x.iter().flat_map(move |x| [*x, s * x]);
        let entries = self.dual.iter().zip(state);
        entries.map(|(dual, state)| self.taken() as f64 * (dual * state / self.square).re)
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

/// The forces of the bars' stiffness, multiplied by `share`, and of the attachments. `number` selects an attachment's
/// stiffness or viscosity.
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

/// The matrix `S` with `A Z = Z S`, where the states `Z` span an invariant space; `None` if `Z' N Z` is singular. It is
/// computed as `(Z' N Z)^-1 Z' H Z`, in which an error of `Z` along another vector is squared.
pub(crate) fn reduced(system: &Deflated, states: &[Vec<f64>]) -> Option<DMatrix<f64>> {
    let part = |first: usize| -> Vec<Vec<f64>> {
        states.iter().map(|z| z.iter().skip(first).step_by(2).copied().collect()).collect()
    };
    let (m, x, v) = (states.len(), part(0), part(1));
    let damped: Vec<_> = x.iter().map(|x| damped(system, x)).collect();
    let strained: Vec<_> = x.iter().map(|x| strained(system, x)).collect();
    let n = |i: usize, j: usize| dot(&x[i], &damped[j]) + dot(&x[i], &v[j]) + dot(&v[i], &x[j]);
    let h = |i: usize, j: usize| dot(&v[i], &v[j]) - dot(&x[i], &strained[j]);
    DMatrix::from_fn(m, m, n).lu().solve(&DMatrix::from_fn(m, m, h))
}
