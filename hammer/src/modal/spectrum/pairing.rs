//! From roots to blocks: eigenvectors, conjugate pairs, and pairs that nearly coincide.

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::{Block, CONFLUENT, is_real};
use crate::modal::spectrum::cluster::{self, Eigenpair};
use crate::modal::spectrum::confluence::{self, Circle};
use crate::modal::spectrum::quotient::Factor;
use crate::modal::spectrum::refinement::{ALONE, MOVED, Refinement};
use crate::modal::spectrum::residual::defect;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use num_complex::Complex64 as C;
use std::collections::BTreeMap;

/// By how much the defect of two vectors must be smaller than that of a mean and a difference,
/// since the measure itself is rounded.
const APART: f64 = 16.0;

/// Relative imaginary part of a real root that nearly coincides with another: both are accurate to
/// the square root of rounding.
const REAL: f64 = 1e-6;

/// The roots of a secular function, to be combined into blocks of two.
pub(crate) struct Pairing<'a> {
    secular: &'a Secular,
    roots: &'a [Root],
    /// Eigenpairs of roots that lie close together.
    close: BTreeMap<usize, Eigenpair>,
    /// True if every pair is refined, not only those whose minors cancel.
    thorough: bool,
}

impl<'a> Pairing<'a> {
    /// `close` has eigenpairs that are known already.
    pub(crate) fn new(
        secular: &'a Secular,
        roots: &'a [Root],
        thorough: bool,
        close: BTreeMap<usize, Eigenpair>,
    ) -> Self {
        let mut pairing = Self { secular, roots, close, thorough };
        for group in cluster::groups(secular, roots) {
            let plain: Vec<Eigenpair> =
                group.iter().map(|&k| pairing.eigenpair(k, false)).collect();
            let pairs = cluster::orthogonal(secular, roots, &group, &plain).unwrap_or(plain);
            pairing.close.extend(group.into_iter().zip(pairs));
        }
        pairing
    }

    /// The blocks.
    ///
    /// # Errors
    ///
    /// [`SpectrumError::Cancelled`].
    pub(crate) fn blocks(&self) -> Result<Vec<Block>, SpectrumError> {
        let (mut reals, mut blocks) = (Vec::new(), Vec::new());
        for (k, &root) in self.roots.iter().enumerate() {
            if interrupt::is_set() {
                return Err(SpectrumError::Cancelled);
            }
            let s = self.secular.value(root);
            if is_real(s) {
                reals.push((s, k));
            } else if s.im > 0.0 {
                blocks.push(self.oscillation(k));
            }
        }
        // Slowest with fastest, and so on inward: a confluent pair meets in the middle.
        reals.sort_by(|a, b| b.0.re.total_cmp(&a.0.re));
        self.close_pairs(&mut reals, &mut blocks);
        let half = reals.len() / 2;
        for i in 0..half {
            blocks.push(self.distinct(reals[i].1, reals[reals.len() - 1 - i].1));
        }
        Ok(blocks)
    }

    /// A root and its eigenvector in the free modes, not normalised; refined where the minors cancel.
    fn eigenpair(&self, k: usize, is_real: bool) -> Eigenpair {
        if let Some(known) = self.close.get(&k) {
            return known.clone();
        }
        let (secular, root) = (self.secular, self.roots[k]);
        let row = secular.row_forces(root);
        let (s, vector) = (secular.value(root), secular.vector(root, row.1));
        let refined = || {
            let real = |z: C| if is_real { C::new(z.re, 0.0) } else { z };
            let amplitudes: Vec<C> = secular.system.merged(&vector).into_iter().map(real).collect();
            let solved = |room| Refinement::new(secular, real(s), room, &amplitudes).solve();
            // A slow root beside stiff springs is off by their rounding: it may go far where it is alone.
            let (s, amplitudes) =
                solved(MOVED * norm(s)).or_else(|| solved(ALONE * self.distance(k)))?;
            Some((s, secular.system.unmerged(&amplitudes)))
        };
        // The translation that only a dashpot resists is exact.
        let rough = self.thorough && !secular.slides(root) || secular.cancels(root, row);
        rough.then(refined).flatten().unwrap_or((s, vector))
    }

    /// From a root to the nearest other one.
    fn distance(&self, k: usize) -> f64 {
        let others = (0..self.roots.len()).filter(|other| *other != k);
        let apart = others.map(|other| norm(self.secular.apart(self.roots[k], self.roots[other])));
        apart.fold(f64::INFINITY, f64::min)
    }

    /// The block of two real roots, each with a vector of its own.
    fn distinct(&self, i: usize, j: usize) -> Block {
        let [(a, x), (b, y)] = [i, j].map(|k| self.eigenpair(k, true));
        let shape = |v: Vec<C>| unit(v.iter().map(|z| z.re).collect());
        let (roots, shapes) = ([a.re, b.re], [shape(x), shape(y)]);
        if self.secular.slides(self.roots[i]) {
            return Block::braked(roots[1], shapes);
        }
        Block::real(roots, shapes)
    }

    /// The block of a root and its conjugate.
    fn oscillation(&self, k: usize) -> Block {
        let (s, v) = self.eigenpair(k, false);
        // The phase is free: a real largest component keeps the shapes of moderate size.
        let big =
            v.iter().fold(C::default(), |m, z| if z.norm_sqr() > m.norm_sqr() { *z } else { m });
        let length = v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        let phase = big.conj() / norm(big) / length;
        let shapes = [
            v.iter().map(|z| z.re * phase.re - z.im * phase.im).collect(),
            v.iter().map(|z| z.re * phase.im + z.im * phase.re).collect(),
        ];
        Block::quadratic(s.re, s.im * s.im, s.im, shapes)
    }

    fn defect(&self, block: &Block) -> f64 {
        defect(&self.secular.system, block)
    }

    /// The factor of two roots; none if the iteration does not converge.
    fn factor(&self, pair: [usize; 2]) -> Option<Factor> {
        match Circle::around(self.secular, self.roots, pair[0], pair[1]) {
            Some(circle) => circle.factor(),
            None => Factor::of(self.secular, pair.map(|k| self.roots[k])),
        }
    }

    /// Removes from `reals` the pairs that nearly coincide.
    fn close_pairs(&self, reals: &mut Vec<(C, usize)>, blocks: &mut Vec<Block>) {
        let mut i = 0;
        while i + 1 < reals.len() {
            let (a, b) = (reals[i], reals[i + 1]);
            let conjugate = norm(a.0 - b.0.conj()) < 1e-3 * norm(a.0 - b.0);
            // A real root is unrelated to a conjugate pair beside it.
            let real = |s: C| s.im.abs() <= REAL * s.re.abs();
            let alike = conjugate || real(a.0) && real(b.0);
            // Roots that crowd at `-1 / beta` have independent vectors, however close they are.
            let crowd = [a, b].map(|root| self.secular.in_crowd(self.roots[root.1]));
            let close = alike
                && norm(a.0 - b.0) <= 2.0 * CONFLUENT * norm(a.0)
                && crowd.iter().any(Option::is_none);
            let mut candidates = Vec::new();
            if let Some(factor) = close.then(|| self.factor([a.1, b.1])).flatten() {
                let rows = 0..self.secular.system.shapes.len();
                candidates.extend(rows.map(|row| confluence::block(self.secular, &factor, row)));
            }
            // The closer two separate roots are, the worse are their vectors: they must have the
            // smaller defect.
            let mut judged: Vec<(f64, Block)> = Vec::new();
            judged.extend(candidates.into_iter().map(|block| (self.defect(&block), block)));
            if conjugate {
                let upper = if a.0.im > 0.0 { a.1 } else { b.1 };
                let block = self.oscillation(upper);
                judged.push((APART * self.defect(&block), block));
            } else if !judged.is_empty() {
                let block = self.distinct(a.1, b.1);
                judged.push((APART * self.defect(&block), block));
            }
            let best = judged.into_iter().min_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((_, block)) = best {
                blocks.push(block);
                reals.drain(i..i + 2);
            } else {
                i += 1;
            }
        }
    }
}

fn unit(v: Vec<f64>) -> Vec<f64> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.iter().map(|x| x / norm).collect()
}
