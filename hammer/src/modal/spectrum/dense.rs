//! Eigenpairs that the search for roots does not find. A dense solver finds them, however close their roots are.
//!
//! The states that are orthogonal to every known vector (in the product of [`states`](super::states)) form an invariant
//! space. The solver is given only this space, which usually has few dimensions.

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::pairing::{Eigenpair, coincide, sort};
use crate::modal::spectrum::schur;
use crate::modal::spectrum::secular::Secular;
use crate::modal::spectrum::states::Vector;
use crate::numerics::kernel::norm;

/// A direction is new if at least this share of it is orthogonal to the others.
const SPANNED: f64 = 1e-3;

/// All eigenpairs, sorted, and the blocks of roots that nearly coincide. `pairs` are the known eigenpairs; some of them
/// may occur twice.
///
/// # Errors
///
/// [`SpectrumError::Cancelled`]; [`SpectrumError::Unsettled`] if the other pairs are not found.
pub(crate) fn complete(
    secular: &Secular,
    pairs: Vec<Eigenpair>,
) -> Result<(Vec<Eigenpair>, Vec<Block>), SpectrumError> {
    let mut known = distinct(&secular.system, pairs);
    let states = rest(&secular.system, &known)?;
    let blocks = schur::blocks(secular, &mut known, &states)?;
    let mut pairs: Vec<Eigenpair> = known.into_iter().map(|vector| vector.pair).collect();
    sort(&mut pairs);
    Ok((pairs, blocks))
}

/// The pairs without repetitions, and without real ones that coincide.
fn distinct(system: &Deflated, mut pairs: Vec<Eigenpair>) -> Vec<Vector> {
    sort(&mut pairs);
    let mut known: Vec<Vector> = Vec::new();
    for vector in pairs.into_iter().map(|pair| Vector::new(system, pair)) {
        if !known.iter().any(|other| vector.repeats(other)) {
            known.push(vector);
        }
    }
    let mut i = 0;
    while i + 1 < known.len() {
        if coincide(&known[i].pair, &known[i + 1].pair) {
            known.drain(i..i + 2);
        } else {
            i += 1;
        }
    }
    known
}

/// The columns of a basis `Z` of the states that are orthogonal to the known vectors. Each column is the remainder of a
/// unit state; unit states with large remainders are taken first. The columns are orthogonal to one another, with
/// displacements weighted by their rates.
fn rest(system: &Deflated, known: &[Vector]) -> Result<Vec<Vec<f64>>, SpectrumError> {
    let len = 2 * system.omega2.len();
    let count = len.checked_sub(known.iter().map(Vector::taken).sum());
    let count = count.ok_or(SpectrumError::Unpaired)?;
    if count == 0 {
        return Ok(Vec::new());
    }
    let springs = || system.shapes.iter().zip(&system.springs);
    let stiffening = |i: usize| springs().map(|(phi, (k, _))| k * phi[i] * phi[i]).sum::<f64>();
    let rate =
        |i: usize| Some((system.omega2[i] + stiffening(i)).sqrt()).filter(|rate| *rate > 0.0);
    let weights: Vec<f64> = (0..len / 2).flat_map(|i| [rate(i).unwrap_or(1.0), 1.0]).collect();
    // The squared size of each unit state's remainder is the diagonal of the projection.
    let mut remainders = vec![1.0; len];
    for vector in known {
        remainders.iter_mut().zip(vector.parts()).for_each(|(remainder, part)| *remainder -= part);
    }
    let mut columns: Vec<(usize, Vec<f64>)> = Vec::with_capacity(count);
    while columns.len() < count {
        if interrupt::is_set() {
            return Err(SpectrumError::Cancelled);
        }
        let largest = (0..len).max_by(|&i, &j| remainders[i].total_cmp(&remainders[j]));
        let k = largest.filter(|&k| remainders[k].is_finite()).ok_or(SpectrumError::Unsettled)?;
        remainders[k] = f64::NEG_INFINITY;
        let mut z = vec![0.0; len];
        z[k] = 1.0 / weights[k];
        // Two orthogonalisations are enough (Kahan).
        for _ in 0..2 {
            known.iter().for_each(|vector| vector.leave(&mut z));
            for (_, other) in &columns {
                let share: f64 = (0..len).map(|i| weights[i] * weights[i] * other[i] * z[i]).sum();
                z.iter_mut().zip(other).for_each(|(z, x)| *z -= share * x);
            }
        }
        let size = norm(&z.iter().zip(&weights).map(|(z, w)| w * z).collect::<Vec<_>>());
        if size > SPANNED {
            z.iter_mut().for_each(|z| *z /= size);
            let parts = z.iter().zip(&weights).map(|(z, weight)| weight * z);
            remainders.iter_mut().zip(parts).for_each(|(remainder, z)| *remainder -= z * z);
            columns.push((k, z));
        }
    }
    // If the fast states come first, Francis' iteration preserves the digits of the slow ones.
    let rate = |k: usize| weights[k & !1];
    columns.sort_by(|(i, _), (j, _)| rate(*j).total_cmp(&rate(*i)).then(i.cmp(j)));
    Ok(columns.into_iter().map(|(_, z)| z).collect())
}
