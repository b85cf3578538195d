//! Integrals over the first part of a window in which a rigid hammer is expanded with the air.

use crate::numerics::kernel::vectorised;
use crate::numerics::poly::OVER;
use crate::numerics::series::{self, HIGH, HighPowers, LOW};
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Coefficients of a [`Course`](super::course::Course).
type Rows = [[f64; 4]; HIGH + 1];

/// The polynomials of a course over `[0, 1]`, the time over the part's length.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Length of the part, s.
    span: f64,
    rows: Rows,
    /// Displacements of piston and bit at the end, m, and their means over the part.
    ends: [f64; 2],
    means: [f64; 2],
}

vectorised! {
    /// The coefficients in the time over a part, which is this share of the window, and their sums at the end of the
    /// part and over it.
    fn scaled(rows: &'a Rows, share: f64) -> (Rows, [[f64; 4]; 2]) as Scaled, _simd {
        let powers: HighPowers = series::powers(share);
        let (mut out, mut ends, mut means) = (*rows, [0.0; 4], [0.0; 4]);
        for k in (0..HIGH + 1).rev() {
            out[k] = out[k].map(|c| c * powers[k]);
            for i in 0..4 {
                ends[i] += out[k][i];
                means[i] += OVER[k] * out[k][i];
            }
        }
        (out, [ends, means])
    }
}

vectorised! {
    /// For each power `j` of a displacement, `int F j t^(j - 1)` over `[0, 1]` of the forces in the last two lanes.
    fn along(rows: &'a [[f64; 4]; HIGH + 1]) -> [[f64; HIGH]; 2] as Along, _simd {
        let mut all = [[0.0; HIGH]; 2];
        for ([.., f, b], shares) in rows.iter().zip(&SHARES) {
            for j in 0..HIGH {
                all[0][j] += f * shares[j];
                all[1][j] += b * shares[j];
            }
        }
        all
    }
}

/// `int t^i d(t^(j + 1))` over `[0, 1]`, in the order `[i][j]`.
static SHARES: [[f64; HIGH]; HIGH + 1] = {
    let (mut all, mut i) = ([[0.0; HIGH]; HIGH + 1], 0);
    while i <= HIGH {
        let mut j = 0;
        while j < HIGH {
            all[i][j] = (j + 1) as f64 / (i + j + 1) as f64;
            j += 1;
        }
        i += 1;
    }
    all
};

impl Part {
    /// The part of this length of a window of which it is this share.
    pub(super) fn new(rows: &Rows, span: f64, share: f64) -> Self {
        let (rows, [[p, q, ..], [mean, other, ..]]) = scaled(rows, share);
        Self { span, rows, ends: [p, q], means: [mean, other] }
    }

    /// Displacements of the bodies at the start, then at the end, m.
    pub(crate) fn ends(&self) -> [[f64; 2]; 2] {
        let [p, q, ..] = self.rows[0];
        [[p, q], self.ends]
    }

    /// Works `int F_i du_j` of the air's force on body `i` along the displacement of body `j`, J.
    pub(crate) fn works(&self) -> [[f64; 2]; 2] {
        along(&self.rows).map(|means| {
            let each = self.rows[1..].iter().zip(means);
            each.fold([0.0; 2], |[a, b], ([p, q, ..], mean)| [a + p * mean, b + q * mean])
        })
    }

    /// Work of another load along the displacements of both bodies, J. Its coefficients are in the time, s.
    pub(crate) fn works_of(&self, load: &[f64; LOW]) -> [f64; 2] {
        let [start, end] = self.ends();
        let mut works = [0, 1].map(|body| load[0] * (end[body] - start[body]));
        let mut power = 1.0;
        for (i, c) in load.iter().enumerate().skip(1) {
            power *= self.span;
            if *c == 0.0 {
                continue;
            }
            for (row, share) in self.rows[1..].iter().zip(&SHARES[i]) {
                (0..2).for_each(|body| works[body] += power * c * row[body] * share);
            }
        }
        works
    }

    /// Integral of a displacement with these shares of both bodies, m s.
    pub(crate) fn integral(&self, [first, second]: [f64; 2]) -> f64 {
        self.span * (first * self.means[0] + second * self.means[1])
    }
}
