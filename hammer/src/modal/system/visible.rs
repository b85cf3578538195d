//! The part of each block in two displacements, and where constant loads hold the blocks.

use crate::modal::system::functional::Functional;
use crate::modal::system::generator::Generator;
use crate::modal::system::response::Response;
use crate::numerics::matrix2::Matrix2;
use crate::scene::graph::CHANNELS;
use std::array::from_fn;

/// Numbers of the functionals of two displacements.
pub(crate) type Pair = [Option<usize>; 2];

/// A block as the equation `y' = B y + b f` of two coordinates, which two displacements see.
#[derive(Clone, Debug, Default)]
pub(crate) struct VisibleBlock {
    pub index: usize,
    /// `B`, row by row; a translation is a place and its rate.
    pub matrix: Matrix2,
    /// `b`, per channel.
    pub pushes: [[f64; 2]; CHANNELS],
    /// Their part in each displacement, and its size.
    pub parts: [[f64; 2]; 2],
    pub sizes: [f64; 2],
    pub is_translation: bool,
    /// True if the coordinates are coupled: the length of both together never grows. Otherwise neither of them grows.
    pub turns: bool,
    /// The slower and the faster of their rates, 1/s.
    pub rates: [f64; 2],
    /// For a unit load of each channel: the coordinates at rest under it, and their part in each displacement
    /// (`held`); by how much a displacement lags if the load grows in proportion to time (`behind`), and a bound on how
    /// much more it lags if the load grows with its square (`further`).
    pub rest: [[f64; 2]; CHANNELS],
    pub held: [[f64; CHANNELS]; 2],
    pub behind: [[f64; CHANNELS]; 2],
    pub further: [[f64; CHANNELS]; 2],
}

impl VisibleBlock {
    /// Bound on the part of such coordinates in a displacement, at present and later.
    pub(crate) fn most(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        if self.turns {
            self.sizes[place] * (p * p + q * q).sqrt()
        } else {
            (self.parts[place][0] * p).abs() + (self.parts[place][1] * q).abs()
        }
    }

    /// Their present part in it.
    pub(crate) fn along(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        self.parts[place][0] * p + self.parts[place][1] * q
    }
}

/// The blocks that two displacements see, the fastest first.
pub(crate) fn blocks(
    pair: Pair,
    (generator, response): (&Generator, &Response),
    functionals: &[Functional],
) -> Vec<VisibleBlock> {
    let n = generator.n;
    let of = |index: usize| {
        let is_translation = generator.rigid && index == 0;
        let parts = pair.map(|functional| {
            let Some(functional) = functional.map(|k| &functionals[k]) else {
                return [0.0; 2];
            };
            let [place, other] = [index, n + index].map(|k| functional.rows[0][k]);
            [place + if is_translation { functional.rigid } else { 0.0 }, other]
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
            block.rest[c] = held(&matrix, block.pushes[c]);
            let lag = held(&matrix, block.rest[c]);
            for place in 0..2 {
                block.held[place][c] = block.along(place, block.rest[c]);
                block.behind[place][c] = block.along(place, lag).abs();
                block.further[place][c] = 2.0 * block.most(place, held(&matrix, lag));
            }
        }
        Some(block)
    };
    let mut blocks: Vec<_> = (0..generator.rates.len()).filter_map(of).collect();
    blocks.sort_by(|one, other| other.rates[1].total_cmp(&one.rates[1]));
    blocks
}

/// Where a constant push `b` holds coordinates with the matrix `B`: `-B^-1 b`.
fn held(m: &Matrix2, b: [f64; 2]) -> [f64; 2] {
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[1] * b[1] - m[3] * b[0]) / determinant, (m[2] * b[0] - m[0] * b[1]) / determinant]
}
