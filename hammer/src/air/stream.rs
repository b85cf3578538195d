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

/// Coefficients of the air on the sides of the flow paths: of the pressures, and of `R T`.
pub(super) type Air = [[f64; 4]; 2];

/// A power: its number, the same as a float, and the reciprocal.
pub(super) type Order = (usize, f64, f64);

/// Coefficients of what all streams together bring, kg/s and W.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gains {
    /// What the masses of both chambers gain, then the total flow out of each.
    pub(super) flows: Half,
    /// What `sum flow R T` of both chambers gains, and the mass from the supply. The product is left out for flows out
    /// of a chamber, whose sum is multiplied once.
    pub(super) heats: Half,
}

impl Gains {
    #[inline(always)]
    fn add(&mut self, flow: f64, shares: &Gains) {
        let add = |sums: &mut Half, shares: &Half| {
            sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += flow * share);
        };
        add(&mut self.flows, &shares.flows);
        add(&mut self.heats, &shares.heats);
    }
}

/// A path through which air flows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stream {
    pub(super) path: usize,
    /// Upstream and downstream side.
    pub(super) sides: [usize; 2],
    flow: Flow,
    /// The opening's area at the start, m2, and its slope over `x`.
    area: [f64; 2],
    /// The flow per metre of the position, if nothing but the area varies.
    steady: Option<f64>,
    /// What a flow of 1 kg/s adds to the gains.
    shares: Gains,
    /// The halves of [`Lanes`] in use: that of every formula, then that of the subsonic one.
    halves: [usize; 2],
    /// First coefficients of `q`, `Q`, `Z`, `W`, `a W`, `sqrt(2 kappa / (kappa - 1)) P`.
    first: [f64; 6],
    /// `R T` upstream at the start, and the flow.
    from: [f64; 2],
    /// Half the reciprocal of the first coefficient of `W`, then the reciprocals of those of `h`, `p_l` and `q`.
    reciprocals: [f64; 4],
}

/// `sqrt(2 kappa / (kappa - 1)) P` by the formula `FLOW`.
#[inline(always)]
fn pressed<const FLOW: u8>(high: f64, low: f64) -> f64 {
    match FLOW {
        SUBSONIC => NOZZLE * low,
        CHOKED => (NOZZLE * CHOKED_FLOW) * high,
        _ => (NOZZLE * STRAIGHT_SLOPE) * (high - low),
    }
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
        let (mut ratio, mut power, mut s, mut reciprocals) = (0.0, 0.0, 1.0, [0.0; 4]);
        if self.flow == Flow::Subsonic {
            ratio = high / low;
            power = math::two_sevenths(ratio);
            s = power * (power - 1.0);
            (reciprocals[2], reciprocals[3]) = (1.0 / low, 1.0 / ratio);
        }
        let z = s / heat;
        let w = z.sqrt();
        let pressed = match self.flow {
            Flow::Subsonic => pressed::<SUBSONIC>(high, low),
            Flow::Choked => pressed::<CHOKED>(high, low),
            Flow::Straight => pressed::<STRAIGHT>(high, low),
        };
        let jet = self.area[0] * w;
        (reciprocals[0], reciprocals[1]) = (0.5 / w, 1.0 / heat);
        self.reciprocals = reciprocals;
        self.first = [ratio, power, z, w, jet, pressed];
        let flow = jet * pressed;
        self.from = [heat, flow];
        self.share(heat);
        gains.add(flow, &self.shares);
        let is_steady = is_still && !self.leaves_chamber() && self.flow == Flow::Choked;
        self.steady = is_steady.then_some(self.area[1] * w * pressed);
        if is_steady {
            return;
        }
        // The leak's area is constant, so its lane serves the heat.
        let [a, b] = if self.path == LEAK { [heat, flow] } else { [self.area[0], w] };
        self.halves[0] = lanes.begin([z, w, a, jet], [heat, w, b, pressed]);
        if self.flow == Flow::Subsonic {
            let left = [ratio, 0.0, ratio, power];
            self.halves[1] = lanes.begin(left, [low, power, power, power]);
        }
    }

    /// Finds [`Self::shares`], where the air upstream has this `R T` at the start.
    fn share(&mut self, heat: f64) {
        let [from, to] = self.sides;
        self.shares = Gains::default();
        let Gains { flows, heats } = &mut self.shares;
        match from.checked_sub(2) {
            Some(chamber) => (flows[chamber], flows[2 + chamber]) = (-1.0, 1.0),
            None if from == 0 => heats[2] = 1.0,
            None => {}
        }
        match to.checked_sub(2) {
            Some(chamber) => (flows[chamber], heats[chamber]) = (1.0, heat),
            None if to == 0 => heats[2] = -1.0,
            None => {}
        }
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
        if let Some(steady) = self.steady {
            return gains.add(steady * x, &self.shares);
        }
        match (self.flow, self.path == LEAK) {
            (Flow::Subsonic, false) => {
                self.flow_on::<SUBSONIC, false>(lanes, order, (air, x), gains)
            }
            (Flow::Choked, false) => self.flow_on::<CHOKED, false>(lanes, order, (air, x), gains),
            (Flow::Straight, false) => {
                self.flow_on::<STRAIGHT, false>(lanes, order, (air, x), gains)
            }
            (Flow::Subsonic, true) => self.flow_on::<SUBSONIC, true>(lanes, order, (air, x), gains),
            (Flow::Choked, true) => self.flow_on::<CHOKED, true>(lanes, order, (air, x), gains),
            (Flow::Straight, true) => self.flow_on::<STRAIGHT, true>(lanes, order, (air, x), gains),
        }
    }

    /// [`Self::go_on`] for one formula, of the leak or of another path.
    #[inline(always)]
    fn flow_on<const FLOW: u8, const LEAKS: bool>(
        &self,
        lanes: &mut Lanes,
        (k, order, over): Order,
        (air, x): (&Air, f64),
        gains: &mut Gains,
    ) {
        // There are four sides.
        let [high, low] = self.sides.map(|side| air[0][side % 4]);
        let heat = air[1][self.sides[0] % 4];
        let [ratio0, power0, z0, w0, jet0, pressed0] = self.first;
        let [over_w, over_heat, over_low, over_ratio] = self.reciprocals;
        let mut s = 0.0;
        if FLOW == SUBSONIC {
            let sum = lanes.sums(self.halves[1]);
            let ratio = (high - sum[0] - ratio0 * low) * over_low;
            let mixed = sum[1] * over;
            let power = (POWER * (ratio * power0 + mixed) + (mixed - sum[2])) * over_ratio;
            s = sum[3] + (2.0 * power0 - 1.0) * power;
            let left = [ratio, order * ratio, ratio, power];
            lanes.put(k, self.halves[1], left, [low, power, power, power]);
        }
        let sum = lanes.sums(self.halves[0]);
        let z = (s - sum[0] - z0 * heat) * over_heat;
        let w = (z - sum[1]) * over_w;
        let (opened, pressed) = (self.area[1] * x, pressed::<FLOW>(high, low));
        let widened = if LEAKS { 0.0 } else { sum[2] + opened * w0 };
        let jet = widened + self.area[0] * w;
        let flow = sum[3] + jet0 * pressed + jet * pressed0;
        gains.add(flow, &self.shares);
        if LEAKS {
            gains.heats[(self.sides[1] - 2) % 2] += sum[2] + self.from[1] * heat;
        }
        let [a, b] = if LEAKS { [heat, flow] } else { [opened, w] };
        lanes.put(k, self.halves[0], [z, w, a, jet], [heat, w, b, pressed]);
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
            for k in 1..=ORDER {
                let x = if k == 1 { 1.0 } else { 0.0 };
                lanes.add_up(simd, k);
                let order = (k, k as f64, 1.0 / k as f64);
                stream.go_on(&mut lanes, order, (&air[k], x), &mut series[k]);
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
                    let mut start = [[1.0; 4]; 2];
                    let [from, to] = stream.sides;
                    [start[0][from], start[1][from]] = [9e5, 8.6e4];
                    [start[0][to], start[1][to]] = [low * 9e5, 8.1e4];
                    let scale = if flow_law == Flow::Straight { 0.02 } else { 1.0 };
                    let pressures = [2e3, 1e3, 3e4, -2e4].map(|rate| scale * rate);
                    let rates = [pressures, [0.0, 0.0, 800.0, -700.0]];
                    let air: [Air; ORDER + 1] = from_fn(|k| match k {
                        0 => start,
                        1 => rates,
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
                        let heats = to.checked_sub(2).map(|to| sum(&|gains| gains.heats[to]));
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
