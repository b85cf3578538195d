//! The steel in the series of a window: coordinates of modes, or two rigid bodies.

use super::Places;
use super::lanes::Half;
use crate::laws::rock::Coefficients;
use crate::numerics::series::{HIGH, LOW};
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

/// A rigid piston and a rigid bit. With the forces `F_A` and `F_B` of the air on them, all other loads `F_1` and `F_2`,
/// and their displacements `u_1` and `u_2` (0 where they touch the rock and each other)
///
/// ```text
/// m_1 u_1'' = F_A + F_1 - F_C,                F_C = k_C (u_1 - u_2) while the contact is closed,
/// m_2 u_2'' = F_B + F_2 + F_C - F_R,          F_R = k_R u_2 + c_R u_2'.
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pair {
    /// Displacements (m) and velocities (m/s) at the start; in an expansion, their coefficients.
    pub places: [f64; 2],
    pub speeds: [f64; 2],
    /// Masses, kg.
    pub masses: [f64; 2],
    /// Stiffness of the contact, N/m; 0 while it is open.
    pub contact: f64,
    /// Spring and dashpot of the rock.
    pub rock: Coefficients,
    /// All loads but those of the air, N: power series in time.
    pub others: [[f64; LOW]; 2],
    /// Displacements of this size count as one, in the sense in which the air's error is relative, m.
    pub unit: f64,
}

impl Pair {
    /// Coefficient `k` of the loads that are not the air's.
    #[inline(always)]
    fn other(&self, k: usize) -> [f64; 2] {
        if k < LOW { self.others.map(|other| other[k]) } else { [0.0; 2] }
    }

    /// Coefficient `k` of the air's forces under which the bodies move exactly by these polynomials.
    pub(super) fn forces(&self, u: &[[f64; 2]; HIGH + 1], k: usize) -> [f64; 2] {
        let of = |k: usize| if k <= HIGH { u[k] } else { [0.0; 2] };
        let ([p, q], [_, next], second, other) = (u[k], of(k + 1), of(k + 2), self.other(k));
        let pressed = self.contact * (p - q);
        let order = (k + 1) as f64;
        let risen: [f64; 2] = from_fn(|i| self.masses[i] * order * (order + 1.0) * second[i]);
        [
            risen[0] - other[0] + pressed,
            risen[1] - other[1] - pressed + self.rock.force(q, order * next),
        ]
    }
}

/// The steel that is expanded with the air: coordinates of modes, or two rigid bodies and no modes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steel {
    pub blocks: Vec<Block>,
    pub pair: Option<Pair>,
}

/// Two blocks, whose four coordinates are expanded side by side. All numbers are those of [`Block`].
#[derive(Clone, Copy, Debug, Default)]
struct Quad {
    /// The last coefficients.
    last: Half,
    matrix: [Half; 2],
    pushed: [Half; 2],
    others: [Half; LOW],
    /// For each coordinate, its share in both positions.
    parts: [Places; 4],
}

impl Quad {
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

/// The last coefficients of the expanded steel.
pub(super) trait Expansion {
    /// True if no coordinate of the steel is left out.
    const WHOLE: bool;

    /// Contribution of the last coefficients to the piston's positions.
    fn places(&self) -> Places;

    /// Contribution of the next coefficients to `x`, as far as the last ones alone determine them.
    fn speed(&self) -> f64;

    /// Steps from coefficient `k` to `k + 1`, given coefficient `k` of the forces. Returns [`Self::places`].
    fn go_on(&mut self, forces: [f64; 2], at: (usize, f64)) -> Places;

    /// Displacements of two rigid bodies; zero for other steel.
    fn bodies(&self) -> [f64; 2];
}

/// Coordinates of modes.
#[derive(Clone, Debug, Default)]
pub(super) struct Modes {
    quads: Vec<Quad>,
}

impl Modes {
    /// Begins with the start of these blocks.
    pub(super) fn begin(&mut self, blocks: &[Block]) {
        self.quads.clear();
        for two in blocks.chunks(2) {
            let mut quad = Quad::default();
            two.iter().enumerate().for_each(|(place, block)| quad.set(place, block));
            self.quads.push(quad);
        }
    }
}

impl Expansion for Modes {
    const WHOLE: bool = false;

    #[inline(always)]
    fn places(&self) -> Places {
        self.quads.iter().fold([0.0; 2], |sums, quad| add(sums, quad.along(&quad.last)))
    }

    #[inline(always)]
    fn speed(&self) -> f64 {
        self.quads.iter().map(|quad| quad.along(&quad.rates())[0]).sum()
    }

    #[inline(always)]
    fn go_on(&mut self, [f, g]: [f64; 2], (k, over): (usize, f64)) -> Places {
        let mut sums = [0.0; 2];
        for quad in &mut self.quads {
            let (rates, [by_first, by_second]) = (quad.rates(), &quad.pushed);
            let mut next: Half = from_fn(|i| rates[i] + (by_first[i] * f + by_second[i] * g));
            if k < LOW {
                next = from_fn(|i| next[i] + quad.others[k][i]);
            }
            quad.last = next.map(|rate| rate * over);
            sums = add(sums, quad.along(&quad.last));
        }
        sums
    }

    #[inline(always)]
    fn bodies(&self) -> [f64; 2] {
        [0.0; 2]
    }
}

/// Two rigid bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bodies {
    /// The last coefficients of the displacements and velocities.
    places: [f64; 2],
    speeds: [f64; 2],
    /// Reciprocals of the masses, 1/kg.
    over_masses: [f64; 2],
    contact: f64,
    rock: Coefficients,
    others: [[f64; LOW]; 2],
}

impl Bodies {
    /// Begins with the start of these bodies.
    pub(super) fn begin(pair: &Pair) -> Self {
        let Pair { places, speeds, masses, contact, rock, others, .. } = *pair;
        Self { places, speeds, over_masses: masses.map(|mass| 1.0 / mass), contact, rock, others }
    }
}

impl Expansion for Bodies {
    const WHOLE: bool = true;

    #[inline(always)]
    fn places(&self) -> Places {
        [self.places[0] - self.places[1]; 2]
    }

    #[inline(always)]
    fn speed(&self) -> f64 {
        self.speeds[0] - self.speeds[1]
    }

    #[inline(always)]
    fn go_on(&mut self, forces: [f64; 2], (k, over): (usize, f64)) -> Places {
        let ([p, q], [v, w]) = (self.places, self.speeds);
        let pressed = self.contact * (p - q);
        let mut sums = [forces[0] - pressed, forces[1] + (pressed - self.rock.force(q, w))];
        if k < LOW {
            sums = from_fn(|i| sums[i] + self.others[i][k]);
        }
        self.places = [v * over, w * over];
        self.speeds = from_fn(|i| sums[i] * (self.over_masses[i] * over));
        self.places()
    }

    #[inline(always)]
    fn bodies(&self) -> [f64; 2] {
        self.places
    }
}

#[inline(always)]
fn add([a, b]: Places, [c, d]: Places) -> Places {
    [a + c, b + d]
}
