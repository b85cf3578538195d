//! The power series of one flow.
//!
//! With the ratio `q` of the higher to the lower pressure, `Q = q^(2/7)`, and `h = R T` upstream, the flow from `p_h`
//! to `p_l` through the area `a` ([`crate::laws::air`]) is
//!
//! ```text
//! flow = sqrt(2 kappa / (kappa - 1)) a W P,      W^2 = Z,      Z h = s
//!
//!            s             P
//! subsonic   Q (Q - 1)     p_l
//! choked     1             p_h CHOKED_FLOW
//! straight   1             (p_h - p_l) STRAIGHT_SLOPE
//! ```

use super::{ENDS, PATHS};
use crate::laws::air::{CHOKED_FLOW, Flow, NOZZLE, Regime, STRAIGHT_SLOPE};
use crate::numerics::kernel::{LANES, MOST, Row, Sums};
use crate::numerics::math;
use crate::numerics::series::ORDER;
use pulp::Simd;

/// The path between the chambers.
const LEAK: usize = PATHS - 1;
/// The exponent of `Q`.
const POWER: f64 = 2.0 / 7.0;
/// All formulas need the products from this lane on; only a subsonic flow needs those before it.
const COMMON: usize = LANES / 2;

/// The factors of the products of series, one product a lane. The right factors are stored from the highest power down,
/// so that the coefficients of a product stand in the order in which they are multiplied.
#[derive(Clone, Debug, Default)]
pub(super) struct Lanes {
    /// Zero from the power on that is set next.
    left: [Row; ORDER + 1],
    /// Zero after the first coefficient.
    right: [Row; ORDER + GROUP - 1],
}

/// Powers whose products are summed together.
const GROUP: usize = 4;
const _: () = assert!(ORDER.is_multiple_of(GROUP));

impl Lanes {
    /// Coefficient `k` of each product from lane `FROM` on, without the terms that contain a first coefficient.
    #[inline(always)]
    pub(super) fn inner<S: Simd, const FROM: usize>(&self, simd: S, k: usize) -> Row {
        let mut sums: Sums<S> = [simd.splat_f64s(0.0); MOST];
        let mut add = |x: &Row, y: &Row| {
            let (x, y) = (S::as_simd_f64s(x).0, S::as_simd_f64s(y).0);
            for g in FROM / S::F64_LANES..LANES / S::F64_LANES {
                sums[g] = simd.add_f64s(sums[g], simd.mul_f64s(x[g], y[g]));
            }
        };
        // In the last group the factors beyond power `k - 1` are zero.
        let (left, right) = (&self.left[1..], &self.right[ORDER + 1 - k..]);
        for (x, y) in left.as_chunks::<GROUP>().0.iter().zip(right.as_chunks::<GROUP>().0) {
            (0..GROUP).for_each(|i| add(&x[i], &y[i]));
        }
        let mut row = [0.0; LANES];
        S::as_mut_simd_f64s(&mut row).0.copy_from_slice(&sums[..LANES / S::F64_LANES]);
        row
    }
}

impl Lanes {
    /// Sets the first coefficients, and all others to zero.
    pub(super) fn begin(&mut self, left: Row, right: Row) {
        (self.left[0], self.right[ORDER]) = (left, right);
        self.left[1..].fill([0.0; LANES]);
    }

    /// Sets coefficient `k` of the factors in half a row.
    #[inline(always)]
    pub(super) fn put(&mut self, k: usize, half: usize, left: [f64; 4], right: [f64; 4]) {
        self.left[k].as_chunks_mut().0[half] = left;
        self.right[ORDER - k].as_chunks_mut().0[half] = right;
    }
}

/// Coefficients of the air on one side of a flow path: of its pressure and of `R T`.
pub(super) type Air = [f64; 2];

/// A path through which air flows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stream {
    pub(super) path: usize,
    /// Upstream and downstream side.
    pub(super) sides: [usize; 2],
    flow: Flow,
    /// The opening's area at the start, m2, and its slope over `x`.
    area: [f64; 2],
    /// False if the area is constant, so that the flow is proportional to it.
    varies: bool,
    /// First coefficients of `q`, `Q`, `Z`, `W`, `a W`, `P`.
    first: [f64; 6],
    /// Half the reciprocal of the first coefficient of `W`, then the reciprocals of those of `h`, `p_l` and `q`.
    reciprocals: [f64; 4],
}

impl Stream {
    pub(super) fn new(path: usize, regime: Regime, area: [f64; 2]) -> Self {
        let Regime { reversed, flow } = regime;
        let [one, other] = ENDS[path];
        let sides = if reversed { [other, one] } else { [one, other] };
        Self { path, sides, flow, area, ..Self::default() }
    }

    /// `P`.
    #[inline(always)]
    fn pressed(&self, high: f64, low: f64) -> f64 {
        match self.flow {
            Flow::Subsonic => low,
            Flow::Choked => CHOKED_FLOW * high,
            Flow::Straight => STRAIGHT_SLOPE * (high - low),
        }
    }

    /// Sets the first coefficients. Returns the flow, kg/s, and its product with `h`. `is_still` means that the
    /// pressures of supply and exhaust are constant.
    pub(super) fn begin(&mut self, lanes: &mut Lanes, air: &[Air; 4], is_still: bool) -> [f64; 2] {
        let [[high, heat], [low, _]] = self.sides.map(|side| air[side]);
        let (mut ratio, mut power, mut s, mut reciprocals) = (0.0, 0.0, 1.0, [0.0; 4]);
        if self.flow == Flow::Subsonic {
            ratio = high / low;
            power = math::two_sevenths(ratio);
            s = power * (power - 1.0);
            (reciprocals[2], reciprocals[3]) = (1.0 / low, 1.0 / ratio);
        }
        let z = s / heat;
        let w = z.sqrt();
        let (jet, pressed) = (self.area[0] * w, self.pressed(high, low));
        (reciprocals[0], reciprocals[1]) = (0.5 / w, 1.0 / heat);
        self.reciprocals = reciprocals;
        self.first = [ratio, power, z, w, jet, pressed];
        self.varies = !(is_still && self.sides[0] < 2 && self.flow == Flow::Choked);
        let flow = NOZZLE * (jet * pressed);
        // The leak's area is constant, so its lane serves the heat.
        let [a, b] = if self.path == LEAK { [heat, flow] } else { [self.area[0], w] };
        let left = [ratio, 0.0, ratio, power, z, w, a, jet];
        lanes.begin(left, [low, power, power, power, heat, w, b, pressed]);
        [flow, flow * heat]
    }

    /// Coefficient `k` of the flow, and of its product with `h`; the product is left out for a flow from a chamber to
    /// the exhaust or back to the supply. `x` is coefficient `k` of the position.
    #[inline(always)]
    pub(super) fn go_on<S: Simd>(
        &self,
        simd: S,
        lanes: &mut Lanes,
        (k, over): (usize, f64),
        (air, x): (&[Air; 4], f64),
    ) -> [f64; 2] {
        let [[high, heat], [low, _]] = self.sides.map(|side| air[side]);
        let [ratio0, power0, z0, w0, jet0, pressed0] = self.first;
        let [over_w, over_heat, over_low, over_ratio] = self.reciprocals;
        let order = k as f64;
        let (s, sum): (f64, Row);
        if self.flow == Flow::Subsonic {
            sum = lanes.inner::<S, 0>(simd, k);
            let ratio = (high - sum[0] - ratio0 * low) * over_low;
            let mut power = POWER * (ratio * power0 + sum[1] * over) + (sum[1] * over - sum[2]);
            power *= over_ratio;
            s = sum[3] + (2.0 * power0 - 1.0) * power;
            lanes.put(k, 0, [ratio, order * ratio, ratio, power], [low, power, power, power]);
        } else if self.varies {
            (s, sum) = (0.0, lanes.inner::<S, COMMON>(simd, k));
        } else {
            let flow = NOZZLE * (self.area[1] * x * w0 * pressed0);
            return [flow, lanes.right[ORDER][4] * flow];
        }
        let z = (s - sum[4] - z0 * heat) * over_heat;
        let w = (z - sum[5]) * over_w;
        let (opened, pressed) = (self.area[1] * x, self.pressed(high, low));
        let widened = if self.path == LEAK { 0.0 } else { sum[6] + opened * w0 };
        let jet = widened + self.area[0] * w;
        let flow = NOZZLE * (sum[7] + jet0 * pressed + jet * pressed0);
        let [a, b] = if self.path == LEAK { [heat, flow] } else { [opened, w] };
        lanes.put(k, 1, [z, w, a, jet], [heat, w, b, pressed]);
        let first = &lanes.right[ORDER];
        let heat0 = first[4];
        let rest = if self.path == LEAK { sum[6] + first[6] * heat } else { 0.0 };
        [flow, heat0 * flow + rest]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::kernel::vectorised;
    use crate::numerics::series::value;
    use crate::numerics::vectors::dispatch;
    use pulp::WithSimd;
    use std::array::from_fn;

    vectorised! {
        /// The series of the flow, and of its product with `h`.
        fn flow(stream: &'a mut Stream, air: &'a [[Air; 4]; ORDER + 1]) -> [[f64; ORDER + 1]; 2] as Flowing, simd {
            let mut lanes = Lanes::default();
            let mut series = [[0.0; ORDER + 1]; 2];
            [series[0][0], series[1][0]] = stream.begin(&mut lanes, &air[0], false);
            for k in 1..=ORDER {
                let x = if k == 1 { 1.0 } else { 0.0 };
                let each = stream.go_on(simd, &mut lanes, (k, 1.0 / k as f64), (&air[k], x));
                [series[0][k], series[1][k]] = each;
            }
            series
        }
    }

    /// At a later instant, the series of every formula, in either direction, equals the law of the flow. The pressures
    /// change by some 4 % and the temperature by 1 %, so that the series of 17 terms is exact to rounding.
    #[test]
    fn a_series_of_a_flow_is_the_law_at_later_times() {
        let ratios = [(Flow::Straight, 0.997), (Flow::Subsonic, 0.8), (Flow::Choked, 0.3)];
        for (flow_law, low) in ratios {
            for (path, ends) in ENDS.into_iter().enumerate() {
                for reversed in [false, true] {
                    let regime = Regime { reversed, flow: flow_law };
                    let slope = if path == LEAK { 0.0 } else { 3e-4 };
                    let mut stream = Stream::new(path, regime, [2e-4, slope]);
                    let mut start = [[1.0, 1.0]; 4];
                    start[stream.sides[0]] = [9e5, 8.6e4];
                    start[stream.sides[1]] = [low * 9e5, 8.1e4];
                    let rates = [[2e3, 0.0], [1e3, 0.0], [3e4, 800.0], [-2e4, -700.0]];
                    let scale = if flow_law == Flow::Straight { 0.02 } else { 1.0 };
                    let air: [[Air; 4]; ORDER + 1] = from_fn(|k| {
                        let rates = rates.map(|[p, h]| [scale * p, h]);
                        if k == 0 {
                            start
                        } else if k == 1 {
                            rates
                        } else {
                            [[0.0; 2]; 4]
                        }
                    });
                    let series = flow(&mut stream, &air);
                    for t in [0.0, 0.3, 0.7] {
                        let side = |i: usize| {
                            let [p, h] = [0, 1].map(|c| start[i][c] + t * air[1][i][c]);
                            [p, h / crate::laws::air::GAS]
                        };
                        let [one, other] = ends.map(side);
                        let (unit, hot) = (regime.flow(one, other)[0].abs(), stream.sides[0]);
                        let exact = (2e-4 + slope * t) * unit;
                        let warm = exact * (start[hot][1] + t * air[1][hot][1]);
                        let found = series.map(|series| value(&series, t));
                        // The heat of what flows out of a chamber is summed for all flows together.
                        let count = if hot < 2 || path == LEAK { 2 } else { 1 };
                        for (found, exact) in found.into_iter().zip([exact, warm]).take(count) {
                            // The straight law is a difference of a 300th of the pressures.
                            assert!(
                                (found / exact - 1.0).abs() < 2e-12,
                                "{regime:?} {path} {t}: {found} for {exact}"
                            );
                        }
                    }
                }
            }
        }
    }
}
