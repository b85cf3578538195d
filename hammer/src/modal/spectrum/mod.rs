//! Spectrum of a structure: from its free modes to blocks of two coordinates. Each file uses only those above it:
//!
//! ```text
//! block        two coordinates of the result
//! deflation    modes of equal frequency taken out
//! jet          functions of s with their derivatives
//! secular      the function whose zeros are the eigenvalues, and its vectors
//! bordered the same for more than two attachments
//! roots        all zeros at once
//! pairing      roots into pairs, and pairs into blocks
//! states       displacements with velocities, in which vectors are orthogonal
//! refinement   an eigenpair by Newton's method, its residuals in twice the digits
//! schur        eigenvectors of a matrix
//! dense        eigenpairs that the roots do not give
//! joined       the modes of bodies that are joined
//! reaction     the displacement of a stiff attachment, from the force in it
//! ```

pub(crate) mod block;
mod bordered;
pub(crate) mod deflation;
mod dense;
mod jet;
pub(crate) mod joined;
mod pairing;
pub(crate) mod reaction;
mod refinement;
mod roots;
mod schur;
mod secular;
mod states;

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::pairing::coincide;
use crate::modal::spectrum::refinement::{MOVED, Refinement};
use crate::modal::spectrum::roots::Roots;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::modal::structure::Structure;
use crate::numerics::math::norm;
use crate::numerics::matrix2::Matrix2;
use num_complex::Complex64 as C;

/// Everything that was computed about a structure's eigenvalues.
pub(crate) struct Spectrum {
    /// The blocks of modes that no attachment moves.
    alone: Vec<Block>,
    coupled: Option<Coupled>,
}

/// The roots of the other modes, and the error if some are missing.
struct Coupled {
    secular: Secular,
    roots: Vec<Root>,
    end: Result<(), SpectrumError>,
}

impl Spectrum {
    /// Computes the eigenvalues.
    ///
    /// # Errors
    ///
    /// [`SpectrumError::Cancelled`].
    pub(crate) fn new(structure: &Structure) -> Result<Self, SpectrumError> {
        if structure.attachments.is_empty() {
            return Ok(Self { alone: free_blocks(structure), coupled: None });
        }
        let (left, mut alone) = Deflated::new(structure);
        if let Some(block) = single(&left) {
            alone.push(block);
            return Ok(Self { alone, coupled: None });
        }
        let mut coupled = Coupled::new(Secular::new(left));
        if coupled.end.is_err() && coupled.secular.is_crowded() {
            coupled = Coupled::new(coupled.secular.measured_from_crowd());
        }
        match coupled.end {
            Err(SpectrumError::Cancelled) => Err(SpectrumError::Cancelled),
            _ => Ok(Self { alone, coupled: Some(coupled) }),
        }
    }

    /// The blocks that follow from the roots alone: the translation first, then by rising rate.
    ///
    /// # Errors
    ///
    /// [`SpectrumError`], if the roots are not known to working accuracy.
    pub(crate) fn blocks(&self) -> Result<Vec<Block>, SpectrumError> {
        self.sorted(Coupled::blocks)
    }

    /// The blocks with the pairs of the blocks `of` refined from their roots, or with every pair refined if `of` is
    /// empty. A dense solver finds the pairs that do not converge.
    ///
    /// # Errors
    ///
    /// [`SpectrumError`], if some pairs are not found.
    pub(crate) fn refined_blocks(&self, of: &[Matrix2]) -> Result<Vec<Block>, SpectrumError> {
        self.sorted(|coupled| coupled.refined_blocks(of))
    }

    fn sorted(
        &self,
        found: impl Fn(&Coupled) -> Result<Vec<Block>, SpectrumError>,
    ) -> Result<Vec<Block>, SpectrumError> {
        let mut blocks = self.alone.clone();
        if let Some(coupled) = &self.coupled {
            blocks.extend(found(coupled)?);
        }
        // Slow blocks come first.
        blocks.sort_by(|a, b| (!a.rigid).cmp(&!b.rigid).then(a.rate[0].total_cmp(&b.rate[0])));
        Ok(blocks)
    }
}

impl Coupled {
    fn new(secular: Secular) -> Self {
        let (roots, end) = Roots::new(&secular).solve();
        Self { secular, roots, end }
    }

    fn blocks(&self) -> Result<Vec<Block>, SpectrumError> {
        self.end?;
        let (system, mut pairs) =
            (&self.secular.system, pairing::pairs(&self.secular, &self.roots)?);
        pairing::sort(&mut pairs);
        if pairs.windows(2).any(|two| coincide(&two[0], &two[1])) {
            return Err(SpectrumError::Unpaired);
        }
        pairing::blocks(system, &pairs)
    }

    fn refined_blocks(&self, of: &[Matrix2]) -> Result<Vec<Block>, SpectrumError> {
        // A block of two decays has their roots on its diagonal.
        let is_of = |s: C| of.iter().any(|b| (b[0] == s.re && b[1] == s.im) || b[3] == s.re);
        let mut known = Vec::new();
        for (s, x) in pairing::pairs(&self.secular, &self.roots)? {
            if interrupt::is_set() {
                return Err(SpectrumError::Cancelled);
            }
            // The translation that only a dashpot resists is exact.
            known.extend(if s == C::default() || !(of.is_empty() || is_of(s)) {
                Some((s, x))
            } else {
                Refinement::new(&self.secular, s, MOVED * norm(s), &x).solve()
            });
        }
        let (pairs, mut blocks) = dense::complete(&self.secular, known)?;
        blocks.extend(pairing::blocks(&self.secular.system, &pairs)?);
        Ok(blocks)
    }
}

/// The block of a single remaining mode, such as that of a rigid bit on rock. It is known in closed form, even at
/// critical damping, where the roots of the secular function coincide.
fn single(left: &Deflated) -> Option<Block> {
    let [own] = left.omega2[..] else { return None };
    let attached = || left.shapes.iter().map(|shape| shape[0] * shape[0]).zip(&left.springs);
    let omega2 = own + attached().map(|(part, (k, _))| k * part).sum::<f64>();
    let damping = left.beta * own + attached().map(|(part, (_, c))| c * part).sum::<f64>();
    // Without a spring the mode slides against a dashpot.
    let shape = || left.unmerged(&[C::new(1.0, 0.0)]).iter().map(|z| z.re).collect();
    (omega2 > 0.0).then(|| Block::single(omega2, damping, shape()))
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
