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
//!
//! Every series but those of `a`, of `a W` and of a difference of pressures is divided by its first coefficient, which
//! is then 1 and needs no multiplication. What they are divided by is part of the area.

use super::lanes::{Half, Lanes};
use super::{ENDS, PATHS};
use crate::laws::air::{CHOKED_FLOW, Flow, NOZZLE, Regime, STRAIGHT_SLOPE};
use crate::numerics::math;

/// The path between the chambers.
const LEAK: usize = PATHS - 1;
/// The exponent of `Q`.
const POWER: f64 = 2.0 / 7.0;

/// The formulas of a flow as parameters of the code, which then contains no test of them.
const SUBSONIC: u8 = Flow::Subsonic as u8;
const CHOKED: u8 = Flow::Choked as u8;
const STRAIGHT: u8 = Flow::Straight as u8;

/// Coefficients of the air on the sides of the flow paths: of the pressures, and of `R T`. Those after the first are
/// divided by it.
pub(super) type Air = [[f64; 4]; 2];

/// A power: its number, the same as a float, and the reciprocal.
pub(super) type Order = (usize, f64, f64);

/// Coefficients of what all streams together bring.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gains {
    /// The flows into both chambers, then those out of them, kg/s.
    pub(super) flows: Half,
    /// The flow from the supply, kg/s.
    pub(super) fed: f64,
    /// What the flow out of each chamber carries away beyond its own temperature at the start, over that temperature.
    /// Air from the other chamber counts as if it came from outside; the difference is subtracted.
    pub(super) carried: [f64; 2],
}

/// The formulas of a flow as they are expanded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Kind {
    /// Nothing but the area varies.
    #[default]
    Steady,
    Subsonic,
    Choked,
    Straight,
    SubsonicLeak,
    ChokedLeak,
    StraightLeak,
}

/// A path through which air flows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stream {
    pub(super) path: usize,
    /// Upstream and downstream side.
    pub(super) sides: [usize; 2],
    flow: Flow,
    kind: Kind,
    /// The opening's area at the start, m2, and its slope over `x`; after [`Self::begin`], times what makes it the flow
    /// over the scaled series.
    area: [f64; 2],
    /// What a flow of 1 kg/s adds to the gains: flows, and the flow from the supply.
    shares: Half,
    fed: f64,
    /// The half of [`Lanes`] of every formula; that of the subsonic one follows.
    half: usize,
    /// Contributions of `Q Q` and of `Q` to the scaled `s`.
    shape: [f64; 2],
    /// Pressures upstream and downstream at the start, and their difference.
    pressures: [f64; 2],
    pressed: f64,
    /// The flow at the start.
    start: f64,
    /// The leak's `R T` at the start over that downstream, and by how much it exceeds that from outside.
    warmth: [f64; 2],
}

impl Stream {
    pub(super) fn new(path: usize, regime: Regime, area: [f64; 2]) -> Self {
        let Regime { reversed, flow } = regime;
        let [one, other] = ENDS[path];
        let sides = if reversed { [other, one] } else { [one, other] };
        Self { path, sides, flow, area, ..Self::default() }
    }

    /// True if the air comes from a chamber.
    pub(super) fn leaves_chamber(&self) -> bool {
        self.sides[0] >= 2
    }

    /// Sets the first coefficients, and adds those of the flow to the gains. `is_still` means that the pressures of
    /// supply and exhaust are constant.
    pub(super) fn begin(
        &mut self,
        lanes: &mut Lanes,
        air: &Air,
        is_still: bool,
        gains: &mut Gains,
    ) {
        let [high, low] = self.sides.map(|side| air[0][side]);
        let heat = air[1][self.sides[0]];
        let (s, scale) = match self.flow {
            Flow::Subsonic => {
                let power = math::two_sevenths(high / low);
                let over = 1.0 / (power - 1.0);
                self.shape = [power * over, (2.0 * power - 1.0) * over];
                (power * (power - 1.0), NOZZLE * low)
            }
            Flow::Choked => (1.0, (NOZZLE * CHOKED_FLOW) * high),
            Flow::Straight => (1.0, NOZZLE * STRAIGHT_SLOPE),
        };
        let speed = scale * (s / heat).sqrt();
        self.area = self.area.map(|area| area * speed);
        self.pressures = [high, low];
        self.pressed = if self.flow == Flow::Straight { high - low } else { 1.0 };
        self.start = self.area[0] * self.pressed;
        self.share(&air[1]);
        self.kind = self.kind(is_still);
        self.add(self.start, gains);
        if self.path == LEAK {
            gains.carried[(self.sides[1] - 2) % 2] -= self.warmth[1] * self.start;
        }
        if self.kind == Kind::Steady {
            return;
        }
        // The leak's area is constant, so its lane serves the heat.
        let [a, b] = if self.path == LEAK { [1.0, self.start] } else { [self.area[0], 1.0] };
        self.half = lanes.begin([1.0, 1.0, a, self.area[0]], [1.0, 1.0, b, self.pressed]);
        if self.flow == Flow::Subsonic {
            lanes.begin([1.0, 0.0, 1.0, 1.0], [1.0; 4]);
        }
    }

    fn kind(&self, is_still: bool) -> Kind {
        match (self.flow, self.path == LEAK) {
            (Flow::Choked, false) if is_still && !self.leaves_chamber() => Kind::Steady,
            (Flow::Subsonic, false) => Kind::Subsonic,
            (Flow::Choked, false) => Kind::Choked,
            (Flow::Straight, false) => Kind::Straight,
            (Flow::Subsonic, true) => Kind::SubsonicLeak,
            (Flow::Choked, true) => Kind::ChokedLeak,
            (Flow::Straight, true) => Kind::StraightLeak,
        }
    }

    /// Finds what the flow adds to the gains, where `R T` of all sides is this at the start.
    fn share(&mut self, heats: &[f64; 4]) {
        let [from, to] = self.sides;
        (self.shares, self.fed) = ([0.0; 4], 0.0);
        if from >= 2 {
            self.shares[from] = 1.0;
        }
        if to >= 2 {
            self.shares[to - 2] = 1.0;
        }
        if from.min(to) == 0 {
            self.fed = if from == 0 { 1.0 } else { -1.0 };
        }
        let [heat, outside] = [heats[from], heats[0]];
        self.warmth = [heat, heat - outside].map(|warmth| warmth / heats[to]);
    }

    /// Adds a flow to the gains.
    #[inline(always)]
    fn add(&self, flow: f64, gains: &mut Gains) {
        gains.flows.iter_mut().zip(&self.shares).for_each(|(sum, share)| *sum += flow * share);
        gains.fed += flow * self.fed;
    }

    /// Adds coefficient `k` of the flow to the gains, by what [`Lanes::add_up`] found. `x` is coefficient `k` of the
    /// position.
    #[inline(always)]
    pub(super) fn go_on(
        &self,
        lanes: &mut Lanes,
        order: Order,
        (air, x): (&Air, f64),
        gains: &mut Gains,
    ) {
        let side = (air, x);
        let flow = match self.kind {
            Kind::Steady => self.area[1] * x,
            Kind::Subsonic => self.flow_on::<SUBSONIC, false>(lanes, order, side, gains),
            Kind::Choked => self.flow_on::<CHOKED, false>(lanes, order, side, gains),
            Kind::Straight => self.flow_on::<STRAIGHT, false>(lanes, order, side, gains),
            Kind::SubsonicLeak => self.flow_on::<SUBSONIC, true>(lanes, order, side, gains),
            Kind::ChokedLeak => self.flow_on::<CHOKED, true>(lanes, order, side, gains),
            Kind::StraightLeak => self.flow_on::<STRAIGHT, true>(lanes, order, side, gains),
        };
        self.add(flow, gains);
    }

    /// [`Self::go_on`] for one formula, of the leak or of another path. Returns the flow.
    #[inline(always)]
    fn flow_on<const FLOW: u8, const LEAKS: bool>(
        &self,
        lanes: &mut Lanes,
        (k, order, over): Order,
        (air, x): (&Air, f64),
        gains: &mut Gains,
    ) -> f64 {
        // There are four sides.
        let [high, low] = self.sides.map(|side| air[0][side % 4]);
        let heat = air[1][self.sides[0] % 4];
        let sum = *lanes.sums(self.half);
        let mut z = -(sum[0] + heat);
        if FLOW == SUBSONIC {
            let &[falling, risen, mixed, square] = lanes.sums(self.half + 1);
            let ratio = high - (low + falling);
            let power = POWER * ratio + ((1.0 + POWER) * over * risen - mixed);
            z = self.shape[1] * power + (self.shape[0] * square + z);
            let left = [ratio, order * ratio, ratio, power];
            lanes.put(k, self.half + 1, left, [low, power, power, power]);
        }
        let w = 0.5 * (z - sum[1]);
        let opened = self.area[1] * x;
        let widened = if LEAKS { 0.0 } else { sum[2] + opened };
        let jet = widened + self.area[0] * w;
        let pressed = match FLOW {
            SUBSONIC => low,
            CHOKED => high,
            _ => self.pressures[0] * high - self.pressures[1] * low,
        };
        let driven = sum[3] + self.area[0] * pressed;
        let flow = driven + if FLOW == STRAIGHT { self.pressed * jet } else { jet };
        if LEAKS {
            let [whole, excess] = self.warmth;
            let carried = whole * (sum[2] + self.start * heat) + excess * flow;
            gains.carried[(self.sides[1] - 2) % 2] -= carried;
        }
        let [a, b] = if LEAKS { [heat, flow] } else { [opened, w] };
        lanes.put(k, self.half, [z, w, a, jet], [heat, w, b, pressed]);
        flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::kernel::vectorised;
    use crate::numerics::series::{ORDER, value};
    use crate::numerics::vectors::dispatch;
    use pulp::{Simd, WithSimd};
    use std::array::from_fn;

    vectorised! {
        /// The series of the flow, and of its product with `h`.
        fn flow(stream: &'a mut Stream, air: &'a [Air; ORDER + 1]) -> [Gains; ORDER + 1] as Flowing, simd {
            let mut lanes = Lanes::default();
            let mut series = [Gains::default(); ORDER + 1];
            stream.begin(&mut lanes, &air[0], false, &mut series[0]);
            for k in 1..ORDER {
                let x = if k == 1 { 1.0 } else { 0.0 };
                lanes.add_up(simd);
                let order = (k, k as f64, 1.0 / k as f64);
                stream.go_on(&mut lanes, order, (&air[k], x), &mut series[k]);
            }
            series
        }
    }

    /// At a later instant, the series of every formula, in either direction, equals the law of the flow. The pressures
    /// change by some 4 % and the temperature by 1 %, so that the series of 16 terms is exact to rounding.
    #[test]
    fn a_series_of_a_flow_is_the_law_at_later_times() {
        let ratios = [(Flow::Straight, 0.997), (Flow::Subsonic, 0.8), (Flow::Choked, 0.3)];
        for (flow_law, low) in ratios {
            for (path, ends) in ENDS.into_iter().enumerate() {
                for reversed in [false, true] {
                    let regime = Regime { reversed, flow: flow_law };
                    let slope = if path == LEAK { 0.0 } else { 3e-4 };
                    let mut stream = Stream::new(path, regime, [2e-4, slope]);
                    let mut start = [[1.0; 4]; 2];
                    let [from, to] = stream.sides;
                    [start[0][from], start[1][from]] = [9e5, 8.6e4];
                    [start[0][to], start[1][to]] = [low * 9e5, 8.1e4];
                    let scale = if flow_law == Flow::Straight { 0.02 } else { 1.0 };
                    let pressures = [2e3, 1e3, 3e4, -2e4].map(|rate| scale * rate);
                    let rates = [pressures, [0.0, 0.0, 800.0, -700.0]];
                    let scaled = [0, 1].map(|c| from_fn(|i| rates[c][i] / start[c][i]));
                    let air: [Air; ORDER + 1] = from_fn(|k| match k {
                        0 => start,
                        1 => scaled,
                        _ => Air::default(),
                    });
                    let series = flow(&mut stream, &air);
                    for t in [0.0, 0.3, 0.7] {
                        let side = |i: usize| {
                            let [p, h] = [0, 1].map(|c| start[c][i] + t * rates[c][i]);
                            [p, h / crate::laws::air::GAS]
                        };
                        let [one, other] = ends.map(side);
                        let unit = regime.flow(one, other)[0].abs();
                        let exact = (2e-4 + slope * t) * unit;
                        let warm = exact * (start[1][from] + t * rates[1][from]);
                        let sum = |of: &dyn Fn(&Gains) -> f64| value(&series.each_ref().map(of), t);
                        let out = |gains: &Gains| gains.flows[if from < 2 { to - 2 } else { from }];
                        // The heat of what flows out of a chamber is summed for all flows together.
                        let heats = to.checked_sub(2).map(|chamber| {
                            let carried = start[1][to] * sum(&|gains| gains.carried[chamber]);
                            start[1][from.min(1)] * sum(&out) - carried
                        });
                        let found = [Some(sum(&out)), heats].into_iter().flatten();
                        for (found, exact) in found.zip([exact, warm]) {
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
