//! The polynomial of a window, evaluated at all points of a grid by vector instructions (see
//! [`crate::numerics::kernel`]).

use crate::numerics::kernel::vectorised;
use crate::numerics::vectors::dispatch;
use pulp::{Simd, WithSimd};

/// Number of points of a [`Grid`]: as many as the widest vectors hold. With more points every window would take longer;
/// with fewer points more parts would have to be scanned. This number needs the least work on the reference hammer.
pub const GRID: usize = 8;

/// Values and bounds of a polynomial at the points `(i + 1) / GRID`.
#[derive(Default)]
pub struct Grid {
    /// Values at the points.
    pub value: [f64; GRID],
    /// Second derivatives at the points.
    pub second: [f64; GRID],
    /// Bounds on the third derivative between 0 and each point. They are the third derivative with absolute
    /// coefficients, which only rises.
    pub third_bound: [f64; GRID],
    /// Upper bounds on the second derivative between the previous point and each point.
    pub bend: [f64; GRID],
    /// Upper bounds on the polynomial between the previous point and each point.
    pub top: [f64; GRID],
}

impl Grid {
    /// Computes the bounds between neighbouring points from the values at these points. `q` are the polynomial's
    /// coefficients.
    #[inline(always)]
    fn bound<S: Simd>(&mut self, simd: S, q: &[f64; POLY]) {
        let part = const { 1.0 / GRID as f64 };
        let at_ends = |first: f64, rest: &[f64; GRID]| {
            let mut ends = [first; GRID + 1];
            ends[1..].copy_from_slice(rest);
            ends
        };
        let (values, seconds) = (at_ends(q[0], &self.value), at_ends(2.0 * q[2], &self.second));
        let ends = |x: &[f64; GRID + 1], i: usize| {
            let start = i * S::F64_LANES;
            [start, start + 1].map(|k| S::as_simd_f64s(&x[k..k + S::F64_LANES]).0[0])
        };
        // Between two points, the nearer one is at most half a part away.
        let [half, sag, zero] = [0.5 * part, 0.125 * part * part, 0.0].map(|x| simd.splat_f64s(x));
        let out = S::as_mut_simd_f64s(&mut self.bend).0.iter_mut();
        let out = out.zip(S::as_mut_simd_f64s(&mut self.top).0);
        for (i, ((bend, top), third)) in out.zip(S::as_simd_f64s(&self.third_bound).0).enumerate() {
            let ([left, right], [a, b]) = (ends(&values, i), ends(&seconds, i));
            let drift = simd.mul_f64s(half, *third);
            *bend = simd.add_f64s(simd.max_f64s(a, b), drift);
            // Between two points a function exceeds the larger value by at most dip width^2 / 8.
            let dip = simd.max_f64s(simd.sub_f64s(drift, simd.min_f64s(a, b)), zero);
            *top = simd.add_f64s(simd.max_f64s(left, right), simd.mul_f64s(sag, dip));
        }
    }
}

static POINTS: [f64; GRID] = {
    let (mut x, mut i) = ([0.0; GRID], 0);
    while i < GRID {
        x[i] = (i + 1) as f64 / GRID as f64;
        i += 1;
    }
    x
};

/// `k (k - 1)` and `k (k - 1) (k - 2)` for each power `k`.
static FALLING: [[f64; 2]; POLY] = {
    let (mut f, mut k) = ([[0.0; 2]; POLY], 2);
    while k < POLY {
        f[k] = [(k * (k - 1)) as f64, (k * (k - 1) * (k - 2)) as f64];
        k += 1;
    }
    f
};

/// Number of coefficients of a polynomial on a [`Grid`].
const POLY: usize = 24;

/// One step of Horner's rule, `y := y x + c`, at each point.
#[inline(always)]
fn horner_with<S: Simd>(simd: S, y: &mut [S::f64s], x: &[S::f64s], c: f64) {
    let c = simd.splat_f64s(c);
    for (y, x) in y.iter_mut().zip(x) {
        *y = simd.add_f64s(simd.mul_f64s(*y, *x), c);
    }
}

vectorised! {
    /// Evaluates `sum q_k x^k` at all points by Horner's rule, and bounds it between them.
    pub fn on_grid(q: &'a [f64; POLY]) -> Grid as OnGrid, simd {
        let mut f = Grid::default();
        let (zero, count) = (simd.splat_f64s(0.0), GRID / S::F64_LANES);
        let x = S::as_simd_f64s(&POINTS).0;
        let (mut p, mut s, mut t) = ([zero; GRID], [zero; GRID], [zero; GRID]);
        for (k, (c, falling)) in q.iter().zip(&FALLING).enumerate().rev() {
            horner_with(simd, &mut p[..count], x, *c);
            if k >= 2 {
                horner_with(simd, &mut s[..count], x, falling[0] * c);
            }
            if k >= 3 {
                horner_with(simd, &mut t[..count], x, falling[1] * c.abs());
            }
        }
        S::as_mut_simd_f64s(&mut f.value).0.copy_from_slice(&p[..count]);
        S::as_mut_simd_f64s(&mut f.second).0.copy_from_slice(&s[..count]);
        S::as_mut_simd_f64s(&mut f.third_bound).0.copy_from_slice(&t[..count]);
        f.bound(simd, q);
        f
    }
}
