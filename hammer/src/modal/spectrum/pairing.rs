//! Pairs roots into eigenpairs, and eigenpairs into blocks. A block consists of two conjugate roots or of two real
//! roots.

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::{Block, CONFLUENT, is_real};
use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use num_complex::Complex64 as C;

/// Two real roots within [`CONFLUENT`] coincide if the cosine of their vectors is larger than this.
const PARALLEL: f64 = 0.7;

/// A root and its eigenvector's amplitudes in the modes of the secular function, not normalised.
pub(crate) type Eigenpair = (C, Vec<C>);

/// The eigenpairs of these roots. Of two conjugates only the one with the positive imaginary part is returned.
///
/// # Errors
///
/// [`SpectrumError::Cancelled`].
pub(crate) fn pairs(secular: &Secular, roots: &[Root]) -> Result<Vec<Eigenpair>, SpectrumError> {
    let mut pairs = Vec::with_capacity(roots.len());
    for &root in roots {
        if interrupt::is_set() {
            return Err(SpectrumError::Cancelled);
        }
        let s = secular.value(root);
        if is_real(s) {
            let real = |z: C| C::new(z.re, 0.0);
            pairs.push((real(s), secular.vector(root).into_iter().map(real).collect()));
        } else if s.im > 0.0 {
            pairs.push((s, secular.vector(root)));
        }
    }
    Ok(pairs)
}

/// True for a pair whose root is real.
pub(crate) fn is_decay((s, _): &Eigenpair) -> bool {
    s.im == 0.0
}

/// Sorts the pairs: first the oscillations, then the decays; each group from slow to fast decay.
pub(crate) fn sort(pairs: &mut [Eigenpair]) {
    pairs.sort_by(|a, b| is_decay(a).cmp(&is_decay(b)).then(b.0.re.total_cmp(&a.0.re)));
}

/// True if two real roots nearly coincide, and their vectors too.
pub(crate) fn coincide(one: &Eigenpair, other: &Eigenpair) -> bool {
    let is_close = norm(one.0 - other.0) <= 2.0 * CONFLUENT * norm(one.0);
    is_close && is_decay(one) && is_decay(other) && {
        let dot = |x: &[C], y: &[C]| x.iter().zip(y).map(|(x, y)| x.re * y.re).sum::<f64>();
        let (x, y) = (&one.1, &other.1);
        dot(x, y).abs() > PARALLEL * (dot(x, x) * dot(y, y)).sqrt()
    }
}

/// The blocks of sorted pairs.
///
/// # Errors
///
/// [`SpectrumError::Unpaired`] for an odd number of real roots.
pub(crate) fn blocks(system: &Deflated, pairs: &[Eigenpair]) -> Result<Vec<Block>, SpectrumError> {
    let (upper, reals) = pairs.split_at(pairs.partition_point(|pair| !is_decay(pair)));
    let mut blocks: Vec<Block> =
        upper.iter().map(|(s, x)| oscillation(*s, &system.unmerged(x))).collect();
    // The slowest real root is paired with the fastest, the second slowest with the second fastest, and so on.
    for (slow, fast) in reals[..reals.len() / 2].iter().zip(reals.iter().rev()) {
        let shape = |x: &[C]| unit(system.unmerged(x).iter().map(|z| z.re).collect());
        let roots = [slow.0.re, fast.0.re];
        blocks.push(match &system.sliding {
            // If only a dashpot resists the translation, its shape is known exactly.
            Some(translation) if roots[0] == 0.0 => {
                Block::braked(roots[1], [unit(translation.clone()), shape(&fast.1)])
            }
            _ => Block::real(roots, [shape(&slow.1), shape(&fast.1)]),
        });
    }
    if reals.len().is_multiple_of(2) { Ok(blocks) } else { Err(SpectrumError::Unpaired) }
}

/// The block of a root and its conjugate. The root's eigenvector `v` is given in the free modes.
fn oscillation(s: C, v: &[C]) -> Block {
    // The phase of the vector is arbitrary. It is chosen so that the largest component is real, which gives shapes of
    // moderate size.
    let larger = |m: C, z: &C| if z.norm_sqr() > m.norm_sqr() { *z } else { m };
    let largest = v.iter().fold(C::default(), larger);
    let length = v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
    let phase = largest.conj() / norm(largest) / length;
    let shapes = [
        v.iter().map(|z| z.re * phase.re - z.im * phase.im).collect(),
        v.iter().map(|z| z.re * phase.im + z.im * phase.re).collect(),
    ];
    Block::quadratic(s.re, s.im * s.im, s.im, shapes)
}

/// The vector, scaled to norm 1.
pub(crate) fn unit(v: Vec<f64>) -> Vec<f64> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.iter().map(|x| x / norm).collect()
}
