//! Eigenvectors of roots that lie close together among several modes of nearly equal frequency.
//!
//! At the upper end of the spectrum of splines each body has two modes, of its two ends, of one
//! frequency but for some 1e-13; of equal bodies there are four. Attachments move some of their roots
//! away, and the rest stay trapped between the poles. There every mode of the cluster `c` is an unknown
//! of its own, and only the others are eliminated: with their receptances `R` alone, an eigenvector's
//! amplitudes `a` in the cluster satisfy
//!
//! ```text
//! S(s) a = 0,    S = diag(d_i) + Phi' (1 + kappa R)^-1 kappa Phi,    i in c
//! ```
//!
//! in which nothing cancels. As many roots as coincide have the same `S` to rounding, so each takes
//! another of its smallest singular vectors.
//!
//! Vectors of different roots are orthogonal in the form `(s + t) x . y + x . C y`. Where two roots
//! differ by a relative `e`, rounding leaves an overlap of `eps / e`, which may be all of a vector;
//! taking it out changes a vector by that much, and its residual by a rounding.

use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64 as C;

/// Relative distance of roots, and of poles from a root, that are one cluster.
const NEAR: f64 = 1e-4;
/// Two roots nearer to each other than this, relative to their size, share one matrix.
const SAME: f64 = 1e-10;
/// Bound on the sweeps over all pairs of columns: about ten are needed.
const MAX_SWEEPS: usize = 60;
/// Overlap of two vectors, relative to their sizes, from which a cluster is solved anew.
const OVERLAP: f64 = 1e-12;

/// A root and its eigenvector, in the free modes if nothing else is said.
pub(crate) type Eigenpair = (C, Vec<C>);

/// Groups of oscillating roots that lie close together.
pub(crate) fn groups(secular: &Secular, roots: &[Root]) -> Vec<Vec<usize>> {
    let value = |k: usize| secular.value(roots[k]);
    let mut upper: Vec<usize> = (0..roots.len()).filter(|&k| value(k).im > 0.0).collect();
    upper.sort_by(|&i, &j| value(i).im.total_cmp(&value(j).im));
    let near = |&i: &usize, &j: &usize| norm(value(i) - value(j)) <= NEAR * norm(value(i));
    upper.chunk_by(near).filter(|group| group.len() > 1).map(<[usize]>::to_vec).collect()
}

/// The vectors of a group, made orthogonal to each other; none if they are so already.
pub(crate) fn orthogonal(
    secular: &Secular,
    roots: &[Root],
    group: &[usize],
    plain: &[Eigenpair],
) -> Option<Vec<Eigenpair>> {
    let merged = |(s, x): &Eigenpair| (*s, secular.system.merged(x));
    let form = |x: &Eigenpair, y: &Eigenpair| form(&secular.system, &merged(x), &merged(y));
    let overlaps = |(j, x): (usize, &Eigenpair)| {
        plain[..j].iter().any(|y| {
            let sizes = norm(form(x, x)) * norm(form(y, y));
            form(x, y).norm_sqr() > OVERLAP * OVERLAP * sizes
        })
    };
    if !plain.iter().enumerate().any(overlaps) {
        return None;
    }
    let mut done: Vec<Eigenpair> = Vec::new();
    for (j, &k) in group.iter().enumerate() {
        let s = secular.value(roots[k]);
        let same = |&&other: &&usize| norm(secular.apart(roots[other], roots[k])) <= SAME * norm(s);
        let place = group[..j].iter().filter(same).count();
        let mut pair = (plain[j].0, vector(secular, roots[k], place)?);
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for known in &done {
                let share = form(known, &pair) / form(known, known);
                pair.1.iter_mut().zip(&known.1).for_each(|(x, y)| *x -= share * y);
            }
        }
        done.push(pair);
    }
    Some(done)
}

/// `(s + t) x . y + x . C y` of two eigenpairs in the modes of the secular function.
pub(crate) fn form(system: &Deflated, (s, x): &Eigenpair, (t, y): &Eigenpair) -> C {
    let dot = |shape: &[f64], x: &[C]| shape.iter().zip(x).map(|(p, x)| p * x).sum::<C>();
    let both = *s + *t;
    let modes = x.iter().zip(y).zip(&system.omega2);
    let mut sum: C = modes.map(|((x, y), w2)| (both + system.beta * w2) * x * y).sum();
    for (shape, (_, viscosity)) in system.shapes.iter().zip(&system.springs) {
        sum += *viscosity * dot(shape, x) * dot(shape, y);
    }
    sum
}

/// An eigenvector by the formula above, of the singular value that has so many smaller ones.
fn vector(secular: &Secular, root: Root, place: usize) -> Option<Vec<C>> {
    let system = &secular.system;
    let (s, omega2) = (secular.value(root), system.omega2[root.pole / 2]);
    let modes: Vec<usize> = (0..system.omega2.len())
        .filter(|&i| (system.omega2[i] - omega2).abs() <= 4.0 * NEAR * omega2)
        .collect();
    let mut compliances = secular.compliances(root);
    modes.iter().for_each(|&i| compliances[i] = C::default());
    let order = system.shapes.len();
    let kappa = |a: usize| system.springs[a].0 + system.springs[a].1 * s;
    let rest = DMatrix::from_fn(order, order, |a, b| {
        let pairs = system.shapes[a].iter().zip(&system.shapes[b]).zip(&compliances);
        let sum: C = pairs.map(|((x, y), c)| x * y * c).sum();
        kappa(a) * sum + f64::from(u8::from(a == b))
    });
    let pushes = DMatrix::from_fn(order, modes.len(), |a, i| kappa(a) * system.shapes[a][modes[i]]);
    let reaction = rest.lu().solve(&pushes)?;
    let matrix = DMatrix::from_fn(modes.len(), modes.len(), |i, j| {
        let sum: C = (0..order).map(|a| system.shapes[a][modes[i]] * reaction[(a, j)]).sum();
        let both = [0, 1].map(|side| secular.off_pole(root, 2 * modes[i] + side));
        sum + if i == j { both[0] * both[1] } else { C::default() }
    });
    let amplitudes = singular_vector(matrix, place)?;
    let forces = -(reaction * &amplitudes);
    let mut full: Vec<C> = (0..system.omega2.len())
        .map(|i| (0..order).map(|a| system.shapes[a][i] * forces[a]).sum::<C>() * compliances[i])
        .collect();
    modes.iter().zip(&amplitudes).for_each(|(&i, a)| full[i] = *a);
    Some(system.unmerged(&full))
}

/// The right singular vector of the singular value that has so many smaller ones, by one-sided Jacobi
/// rotations; none if they do not settle. (nalgebra's decomposition takes `hypot` from the C library,
/// so its last bits depend on the system.)
fn singular_vector(mut a: DMatrix<C>, place: usize) -> Option<DVector<C>> {
    let n = a.ncols();
    let mut v = DMatrix::<C>::identity(n, n);
    let size = |a: &DMatrix<C>, p: usize| a.column(p).iter().map(C::norm_sqr).sum::<f64>();
    // The rounding of a product of two columns, relative to their sizes.
    let rounding = n as f64 * f64::EPSILON;
    for _ in 0..MAX_SWEEPS {
        let mut is_settled = true;
        for (p, q) in (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q))) {
            let (alpha, beta, gamma) = (size(&a, p), size(&a, q), a.column(p).dotc(&a.column(q)));
            let share = gamma.norm_sqr();
            if share <= rounding * rounding * alpha * beta {
                continue;
            }
            is_settled = false;
            let zeta = (beta - alpha) / (2.0 * share.sqrt());
            let t = 1f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let (cosine, phase) = (1.0 / (1.0 + t * t).sqrt(), gamma.conj() / share.sqrt());
            for matrix in [&mut a, &mut v] {
                for i in 0..n {
                    let (x, y) = (matrix[(i, p)], matrix[(i, q)] * phase);
                    matrix[(i, p)] = (x - y * t) * cosine;
                    matrix[(i, q)] = (x * t + y) * cosine;
                }
            }
        }
        if is_settled {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&p, &q| size(&a, p).total_cmp(&size(&a, q)));
            return order.get(place).map(|&p| v.column(p).into_owned());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of `U diag(s) V*` with unitary `U` and `V` made by products of reflections: the vectors are the
    /// columns of `V`, those of the smaller values first, but for a phase. A rotation has a few
    /// roundings of `eps`, and a dozen sweeps of six of them settle; neighbours are 1e2 apart.
    #[test]
    fn singular_vectors_are_those_that_the_matrix_was_made_of() {
        let n = 4;
        let reflection = |seed: f64| {
            let x = DVector::from_fn(n, |i, _| {
                C::new((seed + i as f64).sin(), (seed * i as f64).cos())
            });
            let scale = C::new(2.0 / x.iter().map(C::norm_sqr).sum::<f64>(), 0.0);
            DMatrix::<C>::identity(n, n) - (&x * x.adjoint()) * scale
        };
        let (u, v) = (reflection(0.3) * reflection(1.7), reflection(2.9) * reflection(4.1));
        let values = [1.0, 1e-2, 1e-4, 1e-13];
        let matrix = &u
            * DMatrix::from_diagonal(&DVector::from_iterator(n, values.map(C::from)))
            * v.adjoint();
        for place in 0..n {
            let found = singular_vector(matrix.clone(), place).expect("settles");
            let share = v.column(n - 1 - place).dotc(&found).norm_sqr();
            assert!((share - 1.0).abs() < 200.0 * f64::EPSILON, "{place}: {share}");
        }
    }
}
