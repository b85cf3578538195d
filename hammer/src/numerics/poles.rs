//! Sums over pairs of points of the complex plane, by vector instructions (see [`crate::numerics::kernel`]).

use crate::numerics::kernel::{LANES, across, groups_mut, vectorised};
use crate::numerics::vectors::dispatch;
use num_complex::Complex64 as C;
use pulp::{Simd, WithSimd};

/// Position of the points of unused pairs. Their contribution to a sum is below rounding, and the square of this number
/// does not overflow.
const FAR: f64 = 1e60;

/// Pairs of points with associated numbers, stored in groups of [`LANES`] pairs. A group has one column for each
/// number of a pair.
#[derive(Clone, Debug)]
pub struct Pairs {
    columns: usize,
    numbers: Vec<f64>,
}

impl Pairs {
    /// `count` pairs, all at the unused position.
    pub fn new(count: usize, columns: usize) -> Self {
        let numbers = vec![0.0; count.next_multiple_of(LANES) * columns];
        let mut pairs = Self { columns, numbers };
        (0..count.next_multiple_of(LANES)).for_each(|i| pairs.banish(i));
        pairs
    }

    /// Moves pair `i` to the unused position, where it contributes nothing.
    pub fn banish(&mut self, i: usize) {
        self.set(i, 0, [FAR, 0.0, FAR, 0.0]);
    }

    /// Writes the columns of pair `i` from column `first` on.
    pub fn set<const COUNT: usize>(&mut self, i: usize, first: usize, values: [f64; COUNT]) {
        let start = (i / LANES * self.columns + first) * LANES + i % LANES;
        let slots = self.numbers[start..].iter_mut().step_by(LANES);
        slots.zip(values).for_each(|(slot, value)| *slot = value);
    }
}

/// A point given as an offset from another point, so that differences do not cancel.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The other point.
    pub base: C,
    /// The point minus the other point.
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

#[inline(always)]
fn scaled<S: Simd>(simd: S, w: S::f64s, z: Z<S>) -> Z<S> {
    [simd.mul_f64s(w, z[0]), simd.mul_f64s(w, z[1])]
}

/// Vector `g` of the columns `k` and `k + 1` of a group, which are a point's real and imaginary part.
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

/// A complex sum whose lanes are not yet added up.
type Lanes = [[f64; LANES]; 2];

/// Stores vector `g` of a sum.
#[inline(always)]
fn keep<S: Simd>(lanes: &mut Lanes, g: usize, z: Z<S>) {
    S::as_mut_simd_f64s(&mut lanes[0]).0[g] = z[0];
    S::as_mut_simd_f64s(&mut lanes[1]).0[g] = z[1];
}

/// The sum over the lanes.
fn complex(lanes: &Lanes) -> C {
    C::new(across(&lanes[0]), across(&lanes[1]))
}

/// Result of [`weighed`].
#[derive(Clone, Copy, Debug)]
pub struct Weighed<const WEIGHTS: usize> {
    /// `sum 1 / (s - a) + 1 / (s - b)`.
    pub poles: C,
    /// For each weight `w`, `sum w / ((s - a) (s - b))` and its derivative.
    pub sums: [[C; 2]; WEIGHTS],
}

impl<const WEIGHTS: usize> Weighed<WEIGHTS> {
    /// The result as a list, whose length is the number of weights.
    pub fn list(self) -> (C, Vec<[C; 2]>) {
        (self.poles, self.sums.to_vec())
    }
}

/// Number of columns of a pair before its weights: the real and imaginary parts of `a` and `b`.
pub const ENDS: usize = 4;

#[inline(always)]
fn weighed_with<S: Simd, const WEIGHTS: usize>(
    simd: S,
    pairs: &Pairs,
    at: Point,
) -> Weighed<WEIGHTS> {
    let width = LANES / S::F64_LANES;
    let (mut poles, mut sums) = (Lanes::default(), [[Lanes::default(); 2]; WEIGHTS]);
    let (base, offset) = (splat(simd, at.base), splat(simd, at.offset));
    let numbers = S::as_simd_f64s(&pairs.numbers).0;
    // This loop takes one vector of each group at a time, because the sums of a whole group do not fit into the
    // registers.
    for g in 0..width {
        let zero = splat(simd, C::default());
        let (mut pole_sum, mut parts) = (zero, [[zero; 2]; WEIGHTS]);
        for group in numbers.chunks_exact((ENDS + WEIGHTS) * width) {
            let a = plus(simd, minus(simd, base, point::<S>(group, 0, g)), offset);
            let b = plus(simd, minus(simd, base, point::<S>(group, 2, g)), offset);
            let compliance = inverse(simd, times(simd, a, b));
            let pole_term = times(simd, plus(simd, a, b), compliance);
            let derivative = times(simd, pole_term, compliance);
            pole_sum = plus(simd, pole_sum, pole_term);
            for (k, [sum, slope]) in parts.iter_mut().enumerate() {
                let w = group[(ENDS + k) * width + g];
                *sum = plus(simd, *sum, scaled(simd, w, compliance));
                *slope = minus(simd, *slope, scaled(simd, w, derivative));
            }
        }
        keep::<S>(&mut poles, g, pole_sum);
        for (lanes, part) in sums.iter_mut().flatten().zip(parts.iter().flatten()) {
            keep::<S>(lanes, g, *part);
        }
    }
    let jet = |[sum, slope]: [Lanes; 2]| [complex(&sum), complex(&slope)];
    Weighed { poles: complex(&poles), sums: sums.map(jet) }
}

struct WeighedBy<'a, const WEIGHTS: usize>(&'a Pairs, Point);

impl<const WEIGHTS: usize> WithSimd for WeighedBy<'_, WEIGHTS> {
    type Output = Weighed<WEIGHTS>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Weighed<WEIGHTS> {
        weighed_with(simd, self.0, self.1)
    }
}

/// The sums of [`Weighed`] at a point, over pairs of points with `WEIGHTS` weights each.
#[inline]
pub fn weighed<const WEIGHTS: usize>(pairs: &Pairs, at: Point) -> Weighed<WEIGHTS> {
    dispatch(WeighedBy(pairs, at))
}

vectorised! {
    /// The real and imaginary parts of `1 / ((s - a) (s - b))` for every pair, including the unused ones.
    pub fn inverse_products(pairs: &'a Pairs, at: Point) -> [Vec<f64>; 2] as InverseProducts, simd {
        let width = LANES / S::F64_LANES;
        let (base, offset) = (splat(simd, at.base), splat(simd, at.offset));
        let length = pairs.numbers.len() / pairs.columns;
        let (mut real, mut imaginary) = (vec![0.0; length], vec![0.0; length]);
        let to = groups_mut::<S>(&mut real).zip(groups_mut::<S>(&mut imaginary));
        let from = S::as_simd_f64s(&pairs.numbers).0.chunks_exact(pairs.columns * width);
        for (group, (real, imaginary)) in from.zip(to) {
            for g in 0..width {
                let a = plus(simd, minus(simd, base, point::<S>(group, 0, g)), offset);
                let b = plus(simd, minus(simd, base, point::<S>(group, 2, g)), offset);
                [real[g], imaginary[g]] = inverse(simd, times(simd, a, b));
            }
        }
        [real, imaginary]
    }
}

vectorised! {
    /// Square of the distance from a point to the nearest point of all pairs.
    pub fn nearest(pairs: &'a Pairs, at: Point) -> f64 as Nearest, simd {
        let width = LANES / S::F64_LANES;
        let (base, offset) = (splat(simd, at.base), splat(simd, at.offset));
        let mut least = simd.splat_f64s(f64::INFINITY);
        for group in S::as_simd_f64s(&pairs.numbers).0.chunks_exact(pairs.columns * width) {
            for g in 0..width {
                let a = plus(simd, minus(simd, base, point::<S>(group, 0, g)), offset);
                let b = plus(simd, minus(simd, base, point::<S>(group, 2, g)), offset);
                least = simd.min_f64s(least, simd.min_f64s(square(simd, a), square(simd, b)));
            }
        }
        // The minimum over all lanes does not depend on their number or order.
        let mut lanes = [f64::INFINITY; LANES];
        S::as_mut_simd_f64s(&mut lanes).0[0] = least;
        lanes.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Number of columns of a pair of [`Point`]s: their bases, then their offsets.
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
                let offset_a = minus(simd, offset, point::<S>(group, 4, g));
                let a = plus(simd, minus(simd, base, point::<S>(group, 0, g)), offset_a);
                let offset_b = minus(simd, offset, point::<S>(group, 6, g));
                let b = plus(simd, minus(simd, base, point::<S>(group, 2, g)), offset_b);
                let term = times(simd, plus(simd, a, b), inverse(simd, times(simd, a, b)));
                sum = plus(simd, sum, term);
            }
            keep::<S>(&mut lanes, g, sum);
        }
        complex(&lanes)
    }
}
