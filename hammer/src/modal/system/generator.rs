//! The generator `B` of a decomposed system, which has 2 by 2 blocks on its diagonal.
//!
//! A modal vector holds the first coordinates of all blocks, then their second coordinates. Each half is padded with
//! zeros to the length `n`, a whole number of groups of lanes. In some systems block 0 is a uniform translation, whose
//! motion is a polynomial that is stored elsewhere; `B` is zero in this block. If a dashpot to the ground brakes the
//! translation, only the first coordinate of block 0 is of this kind, and the second one is a decay.

use crate::modal::spectrum::block::Block;
use crate::numerics::form::Form;
use crate::numerics::kernel;
use crate::numerics::matrix2::{self, Matrix2};
use crate::numerics::poly::{Poly, TERMS};
use std::sync::OnceLock;

/// The shortest tabulated rotation is over 2^-SHORTEST s.
const SHORTEST: i32 = 44;
/// Number of tabulated rotations. There are two for each octave, over 2^k s and 1.5 times that, up to 16 s.
const LEVELS: usize = 97;
/// Longest span for which tabulated rotations are composed, s. A corrupt state may ask for any span.
const TABULATED: f64 = 65_536.0;
/// A rate is slow if it is below this share of the largest rate.
const SLOW: f64 = 1e-2;
/// Coefficients below this are set to zero.
const NOTHING: f64 = 1e-200;

/// The matrix `B`, and a table of its exponentials over the spans 2^k s and 1.5 times 2^k s.
#[derive(Debug)]
pub(crate) struct Generator {
    /// Number of blocks, including the empty ones that fill the last group of lanes.
    pub(crate) n: usize,
    /// True if block 0 is a uniform translation.
    pub(crate) rigid: bool,
    /// True if a dashpot to the ground brakes the translation.
    pub(crate) braked: bool,
    /// Largest `|B|`, 1/s.
    pub(crate) rate_max: f64,
    /// The rate `|b|` of each coordinate of each block, 1/s.
    pub(crate) rates: Vec<[f64; 2]>,
    blocks: Vec<Matrix2>,
    /// The blocks in the order in which [`kernel::rotate`] reads them.
    columns: Vec<f64>,
    rotations: Vec<OnceLock<Vec<f64>>>,
    /// Coefficients of the exponential's series, in the order in which [`kernel::short`] reads them.
    series: Vec<f64>,
}

impl Generator {
    pub(crate) fn new(blocks: &[Block]) -> Self {
        let n = blocks.len().next_multiple_of(kernel::LANES);
        let mut columns = vec![0.0; 4 * n];
        let braked = blocks[0].rigid && blocks[0].is_diagonal();
        let moves = |(_, block): &(usize, &Block)| !block.rigid || braked;
        for (i, block) in blocks.iter().enumerate().filter(moves) {
            for k in 0..4 {
                columns[k * n + i] = block.b[k];
            }
        }
        Self {
            n,
            rigid: blocks[0].rigid,
            braked,
            rate_max: blocks.iter().flat_map(|b| b.rate).fold(0.0, f64::max),
            rates: blocks.iter().map(|b| b.rate).collect(),
            blocks: blocks.iter().map(|b| b.b).collect(),
            columns: kernel::interleaved(&columns, n),
            rotations: (0..LEVELS).map(|_| OnceLock::new()).collect(),
            series: Vec::new(),
        }
        .with_series()
    }

    /// Adds the coefficients of the exponential's series. By Cayley and Hamilton, `B^k = alpha_k + beta_k B` for each
    /// block, so these coefficients are scalars. `B` is measured in units of the largest rate.
    fn with_series(mut self) -> Self {
        let n = self.n;
        let unit = if self.rate_max > 0.0 { self.rate_max.recip() } else { 0.0 };
        let mut series = vec![0.0; 2 * kernel::POWERS * n];
        for (i, b) in self.blocks.iter().enumerate().skip(self.still()) {
            let b = b.map(|x| unit * x);
            let (trace, det) = (b[0] + b[3], b[0] * b[3] - b[1] * b[2]);
            let (mut alpha, mut beta, mut factorial) = (0.0, 1.0, 1.0);
            for (k, terms) in series.chunks_exact_mut(2 * n).enumerate() {
                (alpha, beta) = (-det * beta, alpha + trace * beta);
                factorial *= (k + 2) as f64;
                (terms[i], terms[n + i]) = (alpha / factorial, beta / factorial);
            }
        }
        self.series = kernel::interleaved(&series, n);
        self
    }

    /// Number of blocks at the beginning (0 or 1) in which no coordinate moves by `exp(B t)`.
    fn still(&self) -> usize {
        usize::from(self.rigid && !self.braked)
    }

    /// Number of coordinates of block 0 whose motion is a polynomial.
    pub(crate) fn polynomial(&self) -> usize {
        usize::from(self.rigid) + self.still()
    }

    /// Magnitude of the smallest entry of `B` that is not zero.
    pub(crate) fn least_entry(&self) -> f64 {
        self.columns.iter().map(|b| b.abs()).filter(|&b| b > 0.0).fold(self.rate_max, f64::min)
    }

    /// Index and rate (1/s) of the slowest coordinate that decays without oscillation, if it is slow compared with the
    /// fastest coordinate.
    pub(crate) fn creeping(&self) -> Option<(usize, f64)> {
        let diagonal = (0..self.rates.len()).filter(|i| self.is_diagonal(*i));
        let decays = diagonal.flat_map(|i| [0, 1].map(|c| (c * self.n + i, self.rates[i][c])));
        let is_slow = |rate: f64| rate > 0.0 && rate < SLOW * self.rate_max;
        decays.filter(|(_, rate)| is_slow(*rate)).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Block `i`.
    pub(crate) fn block(&self, i: usize) -> Matrix2 {
        self.blocks[i]
    }

    /// True if the two coordinates of block `i` are uncoupled.
    pub(crate) fn is_diagonal(&self, i: usize) -> bool {
        self.blocks[i][1] == 0.0 && self.blocks[i][2] == 0.0
    }

    /// `B^-1 y`; zero for the translation.
    pub(crate) fn solve(&self, y: &[f64]) -> Vec<f64> {
        self.divide(y, |b| (b[1], b[2]))
    }

    /// `c B^-1`, the coefficients of an integral; zero for the translation.
    pub(crate) fn integrate(&self, c: &[f64]) -> Vec<f64> {
        self.divide(c, |b| (b[2], b[1]))
    }

    /// Solves each block for `y`; `off_diagonal` are the two entries that couple the coordinates.
    fn divide(&self, y: &[f64], off_diagonal: impl Fn(&Matrix2) -> (f64, f64)) -> Vec<f64> {
        let n = self.n;
        let mut x = vec![0.0; 2 * n];
        for (i, b) in self.blocks.iter().enumerate().skip(usize::from(self.rigid)) {
            let (b12, b21) = off_diagonal(b);
            let det = b[0] * b[3] - b[1] * b[2];
            x[i] = (b[3] * y[i] - b12 * y[n + i]) / det;
            x[n + i] = (b[0] * y[n + i] - b21 * y[i]) / det;
        }
        if self.braked {
            x[n] = y[n] / self.blocks[0][3];
        }
        x
    }

    /// `c B`.
    pub(crate) fn differentiate(&self, c: &[f64]) -> Vec<f64> {
        let mut d = c.to_vec();
        self.differentiate_in_place(&mut d);
        d
    }

    fn differentiate_in_place(&self, c: &mut [f64]) {
        let (first, second) = c.split_at_mut(self.n);
        for ((x, y), b) in first.iter_mut().zip(second).zip(&self.blocks) {
            (*x, *y) = (*x * b[0] + *y * b[2], *x * b[1] + *y * b[3]);
        }
    }

    /// The power series of block `i` from `start` on, under a load with the coefficients `load(coordinate, power)`:
    /// `(k + 1) y_(k+1) = b y_k + load_k`.
    pub(crate) fn driven(
        &self,
        i: usize,
        start: [f64; 2],
        load: impl Fn(usize, usize) -> f64,
    ) -> [Poly; 2] {
        let b = &self.blocks[i];
        let [mut p, mut q] = start.map(Poly::constant);
        for k in 0..TERMS - 1 {
            let scale = 1.0 / (k + 1) as f64;
            p.0[k + 1] = scale * (b[0] * p.0[k] + b[1] * q.0[k] + load(0, k));
            q.0[k + 1] = scale * (b[2] * p.0[k] + b[3] * q.0[k] + load(1, k));
        }
        [p, q]
    }

    /// Level and span (s) of the longest tabulated rotation that is not longer than `span`.
    pub(crate) fn level_below(span: f64) -> Option<(usize, f64)> {
        if span < Self::length(0) {
            return None;
        }
        // These bits are the exponent, floor(log2 span) of a normal number, and the first bit of the mantissa.
        let halves = (span.to_bits() >> 51) as i32 & 0xfff;
        let level = ((halves - 2 * (1023 - SHORTEST)) as usize).min(LEVELS - 1);
        Some((level, Self::length(level)))
    }

    /// Span of a tabulated rotation, s.
    pub(crate) fn length(level: usize) -> f64 {
        f64::from_bits(((2 * (1023 - SHORTEST) + level as i32) as u64) << 51)
    }

    /// `z := exp(B span) z` for the span of a tabulated level.
    pub(crate) fn rotate_level(&self, level: usize, z: &mut [f64]) {
        kernel::rotate(self.rotation(level), z);
    }

    fn rotation(&self, level: usize) -> &[f64] {
        self.rotations[level].get_or_init(|| self.exponential(Self::length(level)))
    }

    /// `spare := exp(B span) z` for the span of a tabulated level. Returns [`kernel::evaluate`] of the result.
    #[inline]
    pub(crate) fn evaluate_ahead(
        &self,
        level: usize,
        rows: &kernel::EvaluationRows,
        z: &[f64],
        spare: &mut Vec<f64>,
    ) -> [f64; 4] {
        spare.resize(z.len(), 0.0);
        kernel::rotate_and_evaluate(self.rotation(level), rows, z, spare)
    }

    /// As [`Self::evaluate_ahead`], but returns only the value and the rate.
    #[inline]
    pub(crate) fn evaluate_two_ahead(
        &self,
        level: usize,
        rows: &kernel::EvaluationRows,
        z: &[f64],
        spare: &mut Vec<f64>,
    ) -> [f64; 2] {
        spare.resize(z.len(), 0.0);
        kernel::rotate_and_evaluate_two(self.rotation(level), rows, z, spare)
    }

    /// `z := exp(B span) z`. Returns the number of rotations.
    pub(crate) fn rotate(&self, span: f64, z: &mut [f64]) -> u64 {
        if span > TABULATED {
            kernel::rotate(&self.exponential(span), z);
            return 1;
        }
        let (mut remaining, mut count) = (span, 0);
        while let Some((level, length)) = Self::level_below(remaining) {
            // The series rounds less than the table, and costs as much as a few rotations.
            let x = remaining * self.rate_max;
            if x <= kernel::SHORT || x <= kernel::LONGEST && length < remaining {
                break;
            }
            self.rotate_level(level, z);
            remaining -= length;
            count += 1;
        }
        if remaining > 0.0 {
            self.rotate_short(remaining, z);
            count += 1;
        }
        count
    }

    /// `z := exp(B span) z` by the series, for a span of either sign. Does nothing and returns false if the span is too
    /// long for the series.
    pub(crate) fn rotate_slightly(&self, span: f64, z: &mut [f64]) -> bool {
        let is_short = span.abs() * self.rate_max <= kernel::LONGEST;
        if is_short {
            self.rotate_short(span, z);
        }
        is_short
    }

    fn rotate_short(&self, span: f64, z: &mut [f64]) {
        let x = span * self.rate_max;
        kernel::short(&self.columns, &self.series, kernel::Short { span, x }, z);
    }

    /// `c (B / rate_max)^k` for `k` from 0 to `count - 1`, one after the other, for each coordinate of the actual
    /// blocks.
    pub(crate) fn powers(&self, c: &[f64], count: usize) -> Vec<f64> {
        let unit = if self.rate_max > 0.0 { self.rate_max.recip() } else { 0.0 };
        let (n, blocks) = (self.n, self.blocks.len());
        let mut row = c.to_vec();
        let mut columns = vec![0.0; 2 * blocks * count];
        for k in 0..count {
            let coordinates = row[..blocks].iter().chain(&row[n..n + blocks]);
            for (column, x) in columns.chunks_exact_mut(count).zip(coordinates) {
                column[k] = *x;
            }
            self.differentiate_in_place(&mut row);
            // High powers of a slow mode are negligible, and arithmetic with such small numbers is slow.
            row.iter_mut().for_each(|x| *x = if x.abs() < NOTHING { 0.0 } else { unit * *x });
        }
        columns
    }

    fn exponential(&self, span: f64) -> Vec<f64> {
        let n = self.n;
        let mut e = vec![0.0; 4 * n];
        for i in 0..n {
            let is_fixed = i >= self.blocks.len() || i < self.still();
            let x = if is_fixed {
                [1.0, 0.0, 0.0, 1.0]
            } else {
                matrix2::exponential(&self.blocks[i], span)
            };
            for k in 0..4 {
                e[k * n + i] = x[k];
            }
        }
        kernel::interleaved(&e, n)
    }

    /// The form of `Q` that solves Lyapunov's equation `B^T Q + Q B = -W`, block by block. `W` is symmetric; `w`
    /// returns its entries up to the diagonal. Calls `stops` for each row, and returns `None` once `stops` returns
    /// true.
    pub(crate) fn lyapunov(
        &self,
        w: impl Fn(usize, usize) -> f64,
        stops: fn() -> bool,
    ) -> Option<Form> {
        let n = self.n;
        let mut form = Form::zero(2 * n);
        let mut blocks = self.blocks.clone();
        let mut by_blocks = true;
        if self.braked {
            // The first coordinate has no part in `W`, so its rate is arbitrary.
            blocks[0][0] = blocks[0][3];
        }
        for i in self.still()..self.blocks.len() {
            if stops() {
                return None;
            }
            for k in self.still()..=i {
                let source = [w(i, k), w(n + k, i), w(n + i, k), w(n + i, n + k)].map(|w| -w);
                // Undamped blocks and rigid bodies dissipate nothing, and have no equation to solve.
                if source == [0.0; 4] {
                    continue;
                }
                by_blocks &= i == k;
                let x = matrix2::sylvester(&blocks[i], &blocks[k], source);
                form.set(i, k, x[0]);
                form.set(n + k, i, x[1]);
                form.set(n + i, k, x[2]);
                form.set(n + i, n + k, x[3]);
            }
        }
        Some(if by_blocks { form.of_blocks(n) } else { form })
    }
}
