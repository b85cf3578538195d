//! Real roots that the secular function gives to few digits, each refined to one of its own.
//!
//! Among many overdamped modes of bars that are equal, or nearly so, the minors of three attachments or four
//! cancel: several roots that differ by 1e-8 of themselves are known to as much only. Newton's method, which
//! starts from a vector as poor, may take two of them to one pair and leave another out. So a root that
//! moved takes a vector of its own first: by inverse iteration at the root where it is, in which what
//! known pairs share in it is taken out at each step (vectors of different roots are orthogonal in the form
//! `(s + t) x . y + x . C y`).

use crate::interrupt;
use crate::modal::spectrum::block::is_real;
use crate::modal::spectrum::cluster::Eigenpair;
use crate::modal::spectrum::refinement::{MOVED, Refinement};
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use num_complex::Complex64 as C;
use std::collections::BTreeMap;

/// A root that Newton's method moves by less than this part of the way to the next was that pair's.
const STAYED: f64 = 1e-3;
/// Roots further apart than this, relative to their size, have vectors that do not mix.
const NEAR: f64 = 1e-4;

/// Refined pairs of the real roots that have others nearby; those of `roots` that were known to few digits
/// are moved to where they are.
pub(crate) fn separated(secular: &Secular, roots: &mut [Root]) -> BTreeMap<usize, Eigenpair> {
    let mut pairs = BTreeMap::new();
    for group in groups(secular, roots) {
        let mut known = Vec::new();
        let mut doubtful = Vec::new();
        for &k in group.iter().take_while(|_| !interrupt::is_set()) {
            let (start, amplitudes) = start(secular, roots[k]);
            let apart = group.iter().filter(|&&other| other != k);
            let apart = apart.map(|&other| norm(secular.apart(roots[k], roots[other])));
            let room = STAYED * apart.fold(f64::INFINITY, f64::min);
            // Whatever the start is off by in its last digit is not a way.
            let room = room.max(4.0 * f64::EPSILON * norm(start));
            match Refinement::new(secular, start, room, &amplitudes).solve() {
                Some(pair) => known.push((k, pair)),
                None => doubtful.push((k, start, amplitudes)),
            }
        }
        for (k, start, amplitudes) in doubtful {
            if interrupt::is_set() {
                break; // The pairing ends at it.
            }
            let others: Vec<&Eigenpair> = known.iter().map(|(_, pair)| pair).collect();
            let refinement = Refinement::new(secular, start, MOVED * norm(start), &amplitudes);
            if let Some(pair) = refinement.solve_beside(&others) {
                roots[k].offset = pair.0 - secular.poles[roots[k].pole];
                known.push((k, pair));
            }
        }
        let whole = |(k, (s, x)): (usize, Eigenpair)| (k, (s, secular.system.unmerged(&x)));
        pairs.extend(known.into_iter().map(whole));
    }
    pairs
}

/// Real roots, those together that lie close to each other.
fn groups(secular: &Secular, roots: &[Root]) -> Vec<Vec<usize>> {
    let value = |k: usize| secular.value(roots[k]);
    let mut real: Vec<usize> = (0..roots.len())
        .filter(|&k| is_real(value(k)))
        .filter(|&k| !secular.slides(roots[k]))
        .collect();
    real.sort_by(|&i, &j| value(i).re.total_cmp(&value(j).re));
    let near = |&i: &usize, &j: &usize| norm(value(i) - value(j)) <= NEAR * norm(value(i));
    real.chunk_by(near).filter(|group| group.len() > 1).map(<[usize]>::to_vec).collect()
}

/// A real root, and the amplitudes of its vector in the modes of the secular function.
fn start(secular: &Secular, root: Root) -> Eigenpair {
    let (_, forces) = secular.row_forces(root);
    let vector = secular.system.merged(&secular.vector(root, forces));
    let real = |z: C| C::new(z.re, 0.0);
    (real(secular.value(root)), vector.into_iter().map(real).collect())
}
