//! The contribution of each block to two displacements, and the coordinates at rest under constant loads.

use crate::modal::system::functional::Functional;
use crate::modal::system::generator::Generator;
use crate::modal::system::response::Response;
use crate::numerics::matrix2::Matrix2;
use crate::scene::graph::CHANNELS;
use std::array::from_fn;

/// Indices of the functionals of two displacements; `None` if this system has no functional of the displacement.
pub(crate) type Pair = [Option<usize>; 2];

/// A block that contributes to two displacements. Its two coordinates obey `y' = B y + b f`.
#[derive(Clone, Debug, Default)]
pub(crate) struct VisibleBlock {
    pub index: usize,
    /// `B`, row by row. The coordinates of a translation are its position and its velocity.
    pub matrix: Matrix2,
    /// `b` of each channel.
    pub pushes: [[f64; 2]; CHANNELS],
    /// Weights of the coordinates in each displacement, and the norms of these weights.
    pub parts: [[f64; 2]; 2],
    pub sizes: [f64; 2],
    pub is_translation: bool,
    /// True if the coordinates are coupled. Then the norm of the two never grows; otherwise the magnitude of each never
    /// grows.
    pub turns: bool,
    /// The slower and the faster of the coordinates' rates, 1/s.
    pub rates: [f64; 2],
    /// For a unit load of each channel: the coordinates at rest under it (`rest`) and their part in both displacements
    /// (`held`); by how much a displacement lags if the load grows in proportion to time (`behind`), and a bound on how
    /// much more it lags if the load grows with the square of time (`further`); and the rate of the first displacement
    /// (`quick`).
    pub rest: [[f64; 2]; CHANNELS],
    pub held: [[f64; 2]; CHANNELS],
    pub behind: [[f64; 2]; CHANNELS],
    pub further: [[f64; 2]; CHANNELS],
    pub quick: [f64; CHANNELS],
    /// [`Self::most`] of a unit load of each channel.
    pub pushed: [[f64; 2]; CHANNELS],
}

impl VisibleBlock {
    /// Upper bound of the contribution of the coordinates `[p, q]` to a displacement, now and later.
    pub(crate) fn most(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        if self.turns {
            self.sizes[place] * (p * p + q * q).sqrt()
        } else {
            (self.parts[place][0] * p).abs() + (self.parts[place][1] * q).abs()
        }
    }

    /// The present contribution of the coordinates `[p, q]` to a displacement.
    fn along(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        self.parts[place][0] * p + self.parts[place][1] * q
    }
}

/// The blocks that contribute to two displacements, the fastest first.
pub(crate) fn blocks(
    pair: Pair,
    (generator, response): (&Generator, &Response),
    functionals: &[Functional],
) -> Vec<VisibleBlock> {
    let n = generator.n;
    let block = |index: usize| {
        let is_translation = generator.rigid && index == 0;
        let parts = pair.map(|functional| {
            let Some(functional) = functional.map(|k| &functionals[k]) else {
                return [0.0; 2];
            };
            let [first, second] = [index, n + index].map(|k| functional.rows[0][k]);
            [first + if is_translation { functional.rigid } else { 0.0 }, second]
        });
        if parts == [[0.0; 2]; 2] {
            return None;
        }
        let own = generator.block(index);
        let matrix = match (is_translation, generator.braked) {
            (false, _) => own,
            (true, false) => [0.0, 1.0, 0.0, 0.0],
            (true, true) => [0.0, 0.0, 0.0, own[3]],
        };
        let [first, second] = [index, n + index].map(|k| response.drive(k));
        let rates = generator.rates[index];
        let mut block = VisibleBlock {
            index,
            matrix,
            pushes: from_fn(|c| [first[c], second[c]]),
            parts,
            sizes: parts.map(|[p, q]| (p * p + q * q).sqrt()),
            is_translation,
            turns: !generator.is_diagonal(index),
            rates: [rates[0].min(rates[1]), rates[0].max(rates[1])],
            ..VisibleBlock::default()
        };
        if is_translation {
            return Some(block);
        }
        for c in 0..CHANNELS {
            block.rest[c] = equilibrium(&matrix, block.pushes[c]);
            let lag = equilibrium(&matrix, block.rest[c]);
            block.quick[c] = block.along(0, block.pushes[c]);
            for place in 0..2 {
                block.pushed[c][place] = block.most(place, block.pushes[c]);
                block.held[c][place] = block.along(place, block.rest[c]);
                block.behind[c][place] = block.along(place, lag).abs();
                block.further[c][place] = 2.0 * block.most(place, equilibrium(&matrix, lag));
            }
        }
        Some(block)
    };
    let mut blocks: Vec<_> = (0..generator.rates.len()).filter_map(block).collect();
    blocks.sort_by(|one, other| other.rates[1].total_cmp(&one.rates[1]));
    blocks
}

/// The coordinates at rest under a constant load, `-B^-1 b`, where `m` is `B`.
fn equilibrium(m: &Matrix2, b: [f64; 2]) -> [f64; 2] {
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[1] * b[1] - m[3] * b[0]) / determinant, (m[2] * b[0] - m[0] * b[1]) / determinant]
}
