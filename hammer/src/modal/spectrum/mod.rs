//! Spectrum of a structure: from its free modes to blocks of two coordinates. Each file uses only those above it:
//!
//! ```text
//! block        two coordinates of the result
//! deflation    modes of equal frequency taken out
//! jet          functions of s with their derivatives
//! secular      the function whose zeros are the eigenvalues, and its vectors
//! bordered     the same of more than two attachments
//! exact        the same in twice the digits
//! roots        all zeros at once
//! cluster      vectors of roots among several modes of nearly equal frequency
//! refinement   an eigenpair by Newton's method, its residuals in twice the digits
//! quotient     remainders over the factor of two roots, to twice the digits
//! confluence   two that nearly coincide
//! residual     how far a block is from an invariant pair
//! separation   real roots that are known to few digits
//! pairing      roots into blocks
//! joined       the modes of bodies that are joined
//! reaction     the displacement of a stiff attachment, from the force in it
//! ```

pub(crate) mod block;
mod bordered;
mod cluster;
mod confluence;
pub(crate) mod deflation;
mod exact;
mod jet;
pub(crate) mod joined;
mod pairing;
mod quotient;
pub(crate) mod reaction;
mod refinement;
mod residual;
mod roots;
mod secular;
mod separation;

use crate::error::SpectrumError;
use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::pairing::Pairing;
use crate::modal::spectrum::residual::misses;
use crate::modal::spectrum::roots::Roots;
use crate::modal::spectrum::secular::Secular;
use crate::modal::spectrum::separation::separated;
use crate::modal::structure::Structure;
use std::collections::BTreeMap;

/// A block with a larger residual, relative to its own terms and beyond rounding, is refused. A
/// wrong eigenvalue has a residual near one; two modes that meet through the stiffest dashpots have
/// 3e-5.
const DEFECT: f64 = 1e-2;

/// What is done for accurate blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub(crate) enum Care {
    /// Eigenpairs are refined where minors cancel.
    Usual,
    /// Every eigenpair is refined to the last digit of each amplitude.
    Thorough,
    /// Beside that, real roots that lie close together are refined each to a pair of its own.
    Separating,
    /// The secular function itself has twice the digits.
    Exact,
}

/// Blocks of a structure, the translation first, then by rising rate.
///
/// # Errors
///
/// [`SpectrumError`], if the roots cannot be computed to working accuracy.
pub(crate) fn blocks(structure: &Structure, care: Care) -> Result<Vec<Block>, SpectrumError> {
    if structure.attachments.is_empty() {
        return Ok(free_blocks(structure));
    }
    let (left, mut blocks) = Deflated::new(structure);
    let secular = Secular::new(left);
    let coupled = match paired(&secular, care) {
        Ok(coupled) => coupled,
        Err(error) => paired(&secular.crowded().ok_or(error)?, care)?,
    };
    blocks.extend(coupled);
    // The rigid block first, then by rising rate: the slow ones outlive the fast.
    blocks.sort_by(|a, b| (!a.rigid).cmp(&!b.rigid).then(a.rate[0].total_cmp(&b.rate[0])));
    Ok(blocks)
}

/// Blocks of the modes that are coupled to the attachments.
fn paired(secular: &Secular, care: Care) -> Result<Vec<Block>, SpectrumError> {
    let iteration = Roots::new(secular);
    let is_exact = care == Care::Exact;
    let mut roots = if is_exact { iteration.solve_exactly() } else { iteration.solve() }?;
    let separates = care >= Care::Separating;
    let close = if separates { separated(secular, &mut roots) } else { BTreeMap::new() };
    let paired = Pairing::new(secular, &roots, care > Care::Usual, close).blocks()?;
    let misses = |block: &Block| misses(&secular.system, block, DEFECT);
    if paired.iter().any(misses) { Err(SpectrumError::Residual) } else { Ok(paired) }
}

/// Without attachments each mode is a block.
fn free_blocks(structure: &Structure) -> Vec<Block> {
    let n = structure.omega2.len();
    (0..n)
        .map(|i| {
            let mut shape = vec![0.0; n];
            shape[i] = 1.0;
            Block::free(structure.omega2[i], structure.beta, shape)
        })
        .collect()
}
