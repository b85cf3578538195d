//! Sums over pairs of points of the complex plane, in vectors (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, across, groups_mut, vectorised};
use crate::numerics::vectors::dispatch;
use num_complex::Complex64 as C;
use pulp::{Simd, WithSimd};

/// Position of an unused place of a group. Its contribution to a sum is below rounding, and its square does not
/// overflow.
pub const FAR: f64 = 1e60;
/// The same of both points of a pair.
pub const AWAY: [f64; 4] = [FAR, 0.0, FAR, 0.0];

/// Pairs of points with associated numbers, stored group by group, one column after the other.
#[derive(Clone, Debug)]
pub struct Pairs {
    columns: usize,
    numbers: Vec<f64>,
}

impl Pairs {
    /// `count` pairs, all with these numbers in the first columns and zeros in the others.
    pub fn new<const ENDS: usize>(count: usize, columns: usize, unused: [f64; ENDS]) -> Self {
        let count = count.next_multiple_of(LANES);
        let mut pairs = Self { columns, numbers: vec![0.0; count * columns] };
        (0..count).for_each(|i| pairs.set(i, 0, unused));
        pairs
    }

    /// Writes columns of pair `i`, from `first` on.
    pub fn set<const COUNT: usize>(&mut self, i: usize, first: usize, values: [f64; COUNT]) {
        let start = (i / LANES * self.columns + first) * LANES + i % LANES;
        let places = self.numbers[start..].iter_mut().step_by(LANES);
        places.zip(values).for_each(|(place, value)| *place = value);
    }
}

/// A point given as an offset from another point, so that differences do not cancel.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The other point.
    pub base: C,
    /// Its offset from there.
    pub offset: C,
}

/// A complex number for each lane.
type Z<S> = [<S as Simd>::f64s; 2];

#[inline(always)]
fn plus<S: Simd>(simd: S, a: Z<S>, b: Z<S>) -> Z<S> {
    [simd.add_f64s(a[0], b[0]), simd.add_f64s(a[1], b[1])]
}

#[inline(always)]
fn minus<S: Simd>(simd: S, a: Z<S>, b: Z<S>) -> Z<S> {
    [simd.sub_f64s(a[0], b[0]), simd.sub_f64s(a[1], b[1])]
}

#[inline(always)]
fn times<S: Simd>(simd: S, a: Z<S>, b: Z<S>) -> Z<S> {
    [
        simd.sub_f64s(simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1])),
        simd.add_f64s(simd.mul_f64s(a[0], b[1]), simd.mul_f64s(a[1], b[0])),
    ]
}

/// Columns `k` and `k + 1` of a group, their vectors `g`.
#[inline(always)]
fn point<S: Simd>(group: &[S::f64s], k: usize, g: usize) -> Z<S> {
    let width = LANES / S::F64_LANES;
    [group[k * width + g], group[(k + 1) * width + g]]
}

/// Square of the magnitude.
#[inline(always)]
fn square<S: Simd>(simd: S, a: Z<S>) -> S::f64s {
    simd.add_f64s(simd.mul_f64s(a[0], a[0]), simd.mul_f64s(a[1], a[1]))
}

#[inline(always)]
fn inverse<S: Simd>(simd: S, a: Z<S>) -> Z<S> {
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), square(simd, a));
    [simd.mul_f64s(a[0], inverse), simd.mul_f64s(a[1], simd.neg_f64s(inverse))]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, z: C) -> Z<S> {
    [simd.splat_f64s(z.re), simd.splat_f64s(z.im)]
}

/// Lanes of a complex sum.
type Lanes = [[f64; LANES]; 2];

/// Stores a sum's vectors `g`.
#[inline(always)]
fn keep<S: Simd>(lanes: &mut Lanes, g: usize, z: Z<S>) {
    S::as_mut_simd_f64s(&mut lanes[0]).0[g] = z[0];
    S::as_mut_simd_f64s(&mut lanes[1]).0[g] = z[1];
}

/// Adds up the lanes of a sum.
fn complex(lanes: &Lanes) -> C {
    C::new(across(&lanes[0]), across(&lanes[1]))
}

/// Result of [`weighed`].
#[derive(Clone, Copy, Debug)]
pub struct Weighed<const WEIGHTS: usize> {
    /// `sum 1 / (a - x)`.
    pub poles: C,
    /// For each weight `sum w / (a - x)`, and its derivative.
    pub sums: [[C; 2]; WEIGHTS],
}

impl<const WEIGHTS: usize> Weighed<WEIGHTS> {
    /// The same result for any number of weights.
    pub fn list(self) -> (C, Vec<[C; 2]>) {
        (self.poles, self.sums.to_vec())
    }
}

/// A point given as an offset from a real one.
pub type Beside = (f64, C);

/// The real part of `a - x` of a group's vectors `g`, and the inverse of its squared magnitude; `square` is that of the
/// imaginary part.
#[inline(always)]
fn apart<S: Simd>(simd: S, a: S::f64s, [base, offset, square]: [S::f64s; 3]) -> [S::f64s; 2] {
    let real = simd.sub_f64s(simd.sub_f64s(a, base), offset);
    let size = simd.add_f64s(simd.mul_f64s(real, real), square);
    [real, simd.div_f64s(simd.splat_f64s(1.0), size)]
}

vectorised! {
    /// Sums over real poles, stored before so many weights, at a point.
    pub fn weighed<const WEIGHTS>(pairs: &'a Pairs, x: Beside) -> Weighed<WEIGHTS> as WeighedAt, simd {
        let (base, offset) = x;
        let width = LANES / S::F64_LANES;
        let at = [base, offset.re, offset.im * offset.im].map(|x| simd.splat_f64s(x));
        let (mut poles, mut lanes) = (Lanes::default(), [[[0.0; LANES]; 4]; WEIGHTS]);
        let numbers = S::as_simd_f64s(&pairs.numbers).0;
        let zero = simd.splat_f64s(0.0);
        // Vector by vector, because the sums of a whole group do not fit into the registers.
        for g in 0..width {
            let (mut each, mut parts) = ([zero; 2], [[zero; 4]; WEIGHTS]);
            for group in numbers.chunks_exact((1 + WEIGHTS) * width) {
                // 1 / (r - i y) = q (r + i y) with q = 1 / (r^2 + y^2); its square has the real part q - 2 y^2 q^2.
                let [real, q] = apart(simd, group[g], at);
                let p = simd.mul_f64s(real, q);
                let terms = [p, q, simd.mul_f64s(q, q), simd.mul_f64s(p, q)];
                each = plus(simd, each, [p, q]);
                for (k, sums) in parts.iter_mut().enumerate() {
                    let w = group[(1 + k) * width + g];
                    for (sum, term) in sums.iter_mut().zip(terms) {
                        *sum = simd.add_f64s(*sum, simd.mul_f64s(w, term));
                    }
                }
            }
            keep::<S>(&mut poles, g, each);
            for (lanes, part) in lanes.iter_mut().flatten().zip(parts.iter().flatten()) {
                S::as_mut_simd_f64s(lanes).0[g] = *part;
            }
        }
        let y = offset.im;
        let jet = |lanes: [[f64; LANES]; 4]| {
            let [p, q, square, product] = lanes.map(|lanes| across(&lanes));
            [C::new(p, y * q), C::new(q - 2.0 * y * y * square, 2.0 * y * product)]
        };
        let [p, q] = poles.map(|lanes| across(&lanes));
        Weighed { poles: C::new(p, y * q), sums: lanes.map(jet) }
    }
}

vectorised! {
    /// `1 / (a - x)` of every pole, unused places included: real and imaginary parts.
    pub fn inverses(pairs: &'a Pairs, x: Beside) -> [Vec<f64>; 2] as Inverses, simd {
        let width = LANES / S::F64_LANES;
        let (base, offset) = x;
        let at = [base, offset.re, offset.im * offset.im].map(|x| simd.splat_f64s(x));
        let y = simd.splat_f64s(offset.im);
        let length = pairs.numbers.len() / pairs.columns;
        let (mut real, mut imaginary) = (vec![0.0; length], vec![0.0; length]);
        let to = groups_mut::<S>(&mut real).zip(groups_mut::<S>(&mut imaginary));
        let from = S::as_simd_f64s(&pairs.numbers).0.chunks_exact(pairs.columns * width);
        for (group, (real, imaginary)) in from.zip(to) {
            for g in 0..width {
                let [r, q] = apart(simd, group[g], at);
                [real[g], imaginary[g]] = [simd.mul_f64s(r, q), simd.mul_f64s(y, q)];
            }
        }
        [real, imaginary]
    }
}

/// Columns of a pair of [`Point`]s: their bases, then their offsets.
pub const PLACES: usize = 8;

vectorised! {
    /// `sum 1 / (s - a) + 1 / (s - b)` over pairs of [`PLACES`] columns.
    pub fn inverse_distances(pairs: &'a Pairs, from: Point) -> C as InverseDistances, simd {
        let width = LANES / S::F64_LANES;
        let mut lanes = Lanes::default();
        let (base, offset) = (splat(simd, from.base), splat(simd, from.offset));
        for g in 0..width {
            let mut sum = splat(simd, C::default());
            for group in S::as_simd_f64s(&pairs.numbers).0.chunks_exact(PLACES * width) {
                let away = minus(simd, offset, point::<S>(group, 4, g));
                let a = plus(simd, minus(simd, base, point::<S>(group, 0, g)), away);
                let away = minus(simd, offset, point::<S>(group, 6, g));
                let b = plus(simd, minus(simd, base, point::<S>(group, 2, g)), away);
                let both = times(simd, plus(simd, a, b), inverse(simd, times(simd, a, b)));
                sum = plus(simd, sum, both);
            }
            keep::<S>(&mut lanes, g, sum);
        }
        complex(&lanes)
    }
}
