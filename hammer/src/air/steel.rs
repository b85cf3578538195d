//! The expanded coordinates of the steel.

use super::Places;
use super::lanes::Half;
use crate::numerics::series::LOW;
use std::array::from_fn;

/// Two coordinates of the steel, `z' = B z + b f`, and their share of the piston's positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub start: [f64; 2],
    /// `B`, column by column.
    pub matrix: [[f64; 2]; 2],
    /// `b` for the force `F_A` on the piston, and for the return chamber's force on the bit.
    pub pushed: [[f64; 2]; 2],
    /// What the other loads contribute to `b f`: a power series in time.
    pub others: [[f64; 2]; LOW],
    /// Shares of the coordinates in `x` and in `y`.
    pub parts: [[f64; 2]; 2],
}

/// Two blocks, whose four coordinates are expanded side by side. All numbers are those of [`Block`].
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    /// The last coefficients.
    last: Half,
    matrix: [Half; 2],
    pushed: [Half; 2],
    others: [Half; LOW],
    /// For each coordinate, its share in both positions.
    parts: [Places; 4],
}

impl Pair {
    /// Sets the first (0) or the second block (1).
    fn set(&mut self, place: usize, block: &Block) {
        let put = |half: &mut Half, of: [f64; 2]| half.as_chunks_mut().0[place] = of;
        put(&mut self.last, block.start);
        for i in 0..2 {
            put(&mut self.matrix[i], block.matrix[i]);
            put(&mut self.pushed[i], block.pushed[i]);
            for (position, parts) in block.parts.iter().enumerate() {
                self.parts[2 * place + i][position] = parts[i];
            }
        }
        self.others.iter_mut().zip(&block.others).for_each(|(half, other)| put(half, *other));
    }

    /// `B z`.
    #[inline(always)]
    fn rates(&self) -> Half {
        let ([p, q, r, s], [by_first, by_second]) = (self.last, &self.matrix);
        let (first, second) = ([p, p, r, r], [q, q, s, s]);
        from_fn(|i| by_first[i] * first[i] + by_second[i] * second[i])
    }

    /// Contribution of such coordinates to the piston's positions.
    #[inline(always)]
    fn along(&self, coordinates: &Half) -> Places {
        let each = |c: usize| self.parts[c].map(|part| part * coordinates[c]);
        add(add(each(0), each(1)), add(each(2), each(3)))
    }
}

/// The expanded coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct Steel(Vec<Pair>);

impl Steel {
    /// Begins with the start of these blocks.
    pub(super) fn begin(&mut self, blocks: &[Block]) {
        self.0.clear();
        for two in blocks.chunks(2) {
            let mut pair = Pair::default();
            two.iter().enumerate().for_each(|(place, block)| pair.set(place, block));
            self.0.push(pair);
        }
    }

    /// Contribution of the last coefficients to the piston's positions.
    #[inline(always)]
    pub(super) fn places(&self) -> Places {
        let pairs = self.0.iter();
        pairs.fold([0.0; 2], |sums, pair| add(sums, pair.along(&pair.last)))
    }

    /// Contribution of the next coefficients to `x`, as far as the last ones alone determine them.
    #[inline(always)]
    pub(super) fn speed(&self) -> f64 {
        self.0.iter().map(|pair| pair.along(&pair.rates())[0]).sum()
    }

    /// Steps from coefficient `k` to `k + 1`, given coefficient `k` of the forces. Returns [`Self::places`].
    #[inline(always)]
    pub(super) fn go_on(&mut self, [f, g]: [f64; 2], (k, over): (usize, f64)) -> Places {
        let mut sums = [0.0; 2];
        for pair in &mut self.0 {
            let (rates, [by_first, by_second]) = (pair.rates(), &pair.pushed);
            let mut next: Half = from_fn(|i| rates[i] + (by_first[i] * f + by_second[i] * g));
            if k < LOW {
                next = from_fn(|i| next[i] + pair.others[k][i]);
            }
            pair.last = next.map(|rate| rate * over);
            sums = add(sums, pair.along(&pair.last));
        }
        sums
    }
}

#[inline(always)]
fn add([a, b]: Places, [c, d]: Places) -> Places {
    [a + c, b + d]
}
