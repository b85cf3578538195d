//! Generator and basis of a structure, to working accuracy.

use crate::error::SpectrumError;
use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::joined::Joined;
use crate::modal::spectrum::{Spectrum, reaction};
use crate::modal::structure::Structure;
use crate::modal::system::basis::Basis;
use crate::modal::system::generator::Generator;
use crate::numerics::matrix2::Matrix2;

/// Largest mismatch of a usable basis. A missing or duplicated vector gives a mismatch near one; rounding under the
/// stiffest dashpots gives 1e-8. A converted state is corrected once, which squares the mismatch. With a larger
/// mismatch it would have fewer than ten correct digits.
const BASIS_TOLERANCE: f64 = 1e-5;
/// If the mismatch is above this, the basis is computed again: from pairs whose amplitudes are refined (small ones matter
/// where a stiff spring acts on a light body), and with a dense solver for missing pairs.
const ACCURATE: f64 = 1e-11;
/// A pair fails if it causes at least this share of the mismatch.
const SHARE: f64 = 0.1;

/// The decomposition of a structure: generator and basis, and the displacements of stiff attachments in each block.
pub(super) struct Decomposition {
    pub(super) stiff: Vec<Vec<Option<[f64; 2]>>>,
    pub(super) generator: Generator,
    pub(super) basis: Basis,
}

impl Decomposition {
    /// The decomposition that follows from the roots of a spectrum. If its basis is inaccurate, the pairs that fail are
    /// refined, and all pairs if that is not enough. `solved` is as for [`Self::new`].
    pub(super) fn of(
        spectrum: &Spectrum,
        structure: &Structure,
        solved: (&Structure, Option<&Joined>),
    ) -> Result<Self, SpectrumError> {
        let mismatch =
            |parts: &Result<Self, _>| parts.as_ref().map_or(f64::INFINITY, |p| p.basis.mismatch);
        let better = |parts, of: &[Matrix2]| {
            let other = Self::new(structure, solved, spectrum.refined_blocks(of));
            if mismatch(&other) <= mismatch(&parts) { other } else { parts }
        };
        let mut parts = Self::new(structure, solved, spectrum.blocks());
        if mismatch(&parts) > ACCURATE {
            let suspects = parts.as_ref().map_or_else(|_| Vec::new(), |p| p.suspects(structure));
            if !suspects.is_empty() {
                parts = better(parts, &suspects);
            }
            if mismatch(&parts) > ACCURATE {
                parts = better(parts, &[]);
            }
        }
        let parts = parts?;
        let usable = parts.basis.mismatch <= BASIS_TOLERANCE;
        if usable { Ok(parts) } else { Err(SpectrumError::Mismatch) }
    }

    /// The decomposition with the `blocks` of the structure `solved`: the structure itself or, if proportional springs
    /// join bodies, the structure in the modes of the `joined` bodies.
    fn new(
        structure: &Structure,
        (solved, joined): (&Structure, Option<&Joined>),
        blocks: Result<Vec<Block>, SpectrumError>,
    ) -> Result<Self, SpectrumError> {
        let mut blocks = blocks?;
        let stiff = blocks.iter().map(|block| reaction::displacements(solved, block)).collect();
        if let Some(joined) = joined {
            blocks = blocks.into_iter().map(|block| joined.block(block)).collect();
        }
        if let Some(first) = blocks.first_mut().filter(|block| block.rigid) {
            first.turn_downward();
        }
        let generator = Generator::new(&blocks);
        let basis = Basis::new(structure, &blocks, slowest(&generator));
        let basis = basis.ok_or(SpectrumError::Cancelled)?;
        if basis.is_finite() {
            Ok(Self { stiff, generator, basis })
        } else {
            Err(SpectrumError::Infinite)
        }
    }

    /// The matrices of the blocks to which the basis owes most of its mismatch.
    fn suspects(&self, structure: &Structure) -> Vec<Matrix2> {
        let slowest = slowest(&self.generator);
        let blocks = self.basis.suspects(structure.omega2, slowest, SHARE * ACCURATE);
        blocks.into_iter().map(|i| self.generator.block(i)).collect()
    }
}

/// The rate below which a displacement counts no more in the mismatch of a basis.
fn slowest(generator: &Generator) -> f64 {
    generator.least_entry().max(1e-6 * generator.rate_max)
}
