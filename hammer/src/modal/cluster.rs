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

use crate::modal::deflation::Deflated;
use crate::modal::secular::{Root, Secular};
use crate::numerics::math::norm;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64 as C;

/// Relative distance of roots, and of poles from a root, that are one cluster.
const NEAR: f64 = 1e-4;
/// Two roots nearer to each other than this, relative to their size, share one matrix.
const SAME: f64 = 1e-10;
/// Bound on the steps of the singular value decomposition: a few for each mode are needed.
const MAX_SWEEPS: usize = 1000;
/// Overlap of two vectors, relative to their sizes, from which a cluster is solved anew.
const OVERLAP: f64 = 1e-12;

/// A root and its eigenvector in the free modes.
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
    let form = |x: &Eigenpair, y: &Eigenpair| form(&secular.system, x, y);
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

/// `(s + t) x . y + x . C y` of two eigenpairs.
fn form(system: &Deflated, (s, x): &Eigenpair, (t, y): &Eigenpair) -> C {
    let dot = |shape: &[f64], x: &[C]| shape.iter().zip(x).map(|(p, x)| p * x).sum::<C>();
    let [x, y] = [x, y].map(|v| system.merged(v));
    let both = *s + *t;
    let modes = x.iter().zip(&y).zip(&system.omega2);
    let mut sum: C = modes.map(|((x, y), w2)| (both + system.beta * w2) * x * y).sum();
    for (shape, (_, viscosity)) in system.shapes.iter().zip(&system.springs) {
        sum += *viscosity * dot(shape, &x) * dot(shape, &y);
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
    let vectors = matrix.try_svd(false, true, f64::EPSILON, MAX_SWEEPS)?.v_t?;
    // Singular values descend.
    let row = modes.len().checked_sub(1 + place)?;
    let amplitudes: DVector<C> = vectors.row(row).adjoint();
    let forces = -(reaction * &amplitudes);
    let mut full: Vec<C> = (0..system.omega2.len())
        .map(|i| (0..order).map(|a| system.shapes[a][i] * forces[a]).sum::<C>() * compliances[i])
        .collect();
    modes.iter().zip(&amplitudes).for_each(|(&i, a)| full[i] = *a);
    Some(system.unmerged(&full))
}
