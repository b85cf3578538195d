//! Power series in time of the air of one window, and of the steel that it pushes.
//!
//! Gas and steel are expanded together, coefficient by coefficient. Coefficient `k` of the steel's coordinates
//! gives that of the volumes; volumes and contents give the pressures; pressures give forces and flows; and
//! these give coefficient `k + 1` of coordinates and contents. Nothing is iterated or rejected: the last
//! coefficients say how far the series holds ([`Series::length`]).

use super::{Air, ENDS, PATHS, Places};
use crate::laws::air::{CHOKED_FLOW, Flow, GAS, KAPPA, Opening, Regime, STRAIGHT_SLOPE, heated};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, ORDER, Powers, power, product, quotient};
use crate::quantities::parameters::Parameters;
use std::array::from_fn;

/// Longest window, s, where the series would hold longer.
pub(crate) const LONGEST: f64 = 0.02;
/// Largest error of a pressure at one instant, unless the error asked of its mean is larger.
const INSTANT: f64 = 1e-4;
/// A flow changes its formula where pressures pass the formula's bounds by so many times their error.
const BEYOND: f64 = 2.0;
/// Step of a numerical derivative by a pressure, over that pressure.
const STEP: f64 = 1e-6;
/// Heat of air at constant pressure over its gas constant.
const HEAT: f64 = KAPPA / (KAPPA - 1.0);

/// Two coordinates of the steel, `z' = B z + b f`, and their share of the piston's positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub start: [f64; 2],
    /// `B`, row by row.
    pub matrix: [f64; 4],
    /// `b` of the force `F_A` on the piston, and of the return chamber's force on the bit.
    pub pushed: [[f64; 2]; 2],
    /// What the other loads contribute to `b f`: a power series in time.
    pub others: [[f64; LOW]; 2],
    /// Shares of the coordinates in `x` and in `y`.
    pub parts: [[f64; 2]; 2],
}

/// Coordinates of the steel that are not expanded, since they follow the forces at once (quasi-static). A
/// force's displacement is divided among all coordinates so that the shares of its speed cancel: the expanded
/// coordinates take what the others do not.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Left {
    /// The piston's positions without the expanded coordinates and without the forces, m: a power series in
    /// time.
    pub still: [[f64; LOW]; 2],
    /// Compliance: displacement of each position by each of the forces, m/N.
    pub gives: [[f64; 2]; 2],
    /// Their share of the speed of `x` that each force gives at once, m/(N s), and of that by the other loads,
    /// m/s: a power series in time.
    pub speeds: [f64; 2],
    pub others: [f64; LOW],
    /// How long they may be quasi-static, s.
    pub longest: f64,
}

/// What a window is solved from.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    pub parameters: &'a Parameters,
    /// The expanded coordinates, and the quasi-static ones.
    pub blocks: Vec<Block>,
    pub left: Left,
    /// The piston's positions at the epoch.
    pub places: Places,
    /// Pressures of supply and exhaust after the epoch.
    pub outside: [Poly; 2],
}

/// Air on one side of a flow path: pressure, `R T`, and `1 / sqrt(R T)`.
#[derive(Clone, Copy, Default)]
pub(super) struct Side {
    pub(super) pressure: Powers,
    heat: Powers,
    root: Powers,
}

/// A chamber.
#[derive(Clone, Copy, Default)]
pub(super) struct Gas {
    volume: Powers,
    /// `V^(kappa - 1)`.
    heated: Powers,
    /// `p V`.
    product: Powers,
    pub(super) mass: Powers,
    pub(super) entropy: Powers,
    /// `R` times the net heat flow into it.
    warmth: Powers,
}

/// A path through which air flows.
#[derive(Clone, Copy, Default)]
pub(super) struct Stream {
    pub(super) path: usize,
    /// Upstream and downstream side, and the sign of the flow along the path.
    pub(super) sides: [usize; 2],
    pub(super) sign: f64,
    flow: Flow,
    /// The opening's area at the start, m2, and its slope over `x`.
    area: [f64; 2],
    open: Powers,
    ratio: Powers,
    bent: Powers,
    rest: Powers,
    square: Powers,
    shape: Powers,
    jet: Powers,
    blown: Powers,
    rate: Powers,
}

/// The power series of a window.
#[derive(Default)]
pub(crate) struct Series {
    pub(super) sides: [Side; 4],
    pub(super) gas: [Gas; 2],
    pub(super) streams: Vec<Stream>,
    /// The piston's positions.
    pub(super) places: [Powers; 2],
    /// `F_A`, the return chamber's force on the bit, and the two forces of the pressures alone, N.
    pub(super) forces: [Powers; 4],
    /// Mass from the supply, enthalpy that comes in.
    pub(super) sums: [Powers; 2],
}

/// Error allowed of a pressure or an opening at the end of a window, for the error asked of means over the
/// window: the mean of the last power `t^k` is `k + 1` times less than its value at the end.
pub(super) fn instant(error: f64) -> f64 {
    error.max(INSTANT.min(0.25 * ORDER as f64 * error))
}

impl Air {
    /// Gives every flow the formula of the present pressures. A flow near a bound keeps its formula.
    pub(crate) fn classify(&mut self, parameters: &Parameters, places: Places, outside: [f64; 2]) {
        let sides = self.sides(parameters, places, outside, 0.0);
        // The time of a change of formula is known only as well as the pressures are.
        let margin = BEYOND * instant(parameters.air.error);
        for (regime, ends) in self.regimes.iter_mut().zip(ENDS) {
            let pressures = ends.map(|i| sides[i][0]);
            if regime.beyond(pressures).iter().any(|beyond| *beyond > margin) {
                *regime = Regime::of(pressures);
            }
        }
    }

    /// Largest relative rate of a chamber's content, 1/s, per relative change of a pressure, and per metre of
    /// the piston's position, where ports are partly open.
    pub(crate) fn haste(
        &self,
        parameters: &Parameters,
        places: Places,
        outside: [f64; 2],
    ) -> [f64; 2] {
        let law = &parameters.air;
        let sides = self.sides(parameters, places, outside, 0.0);
        let areas = law.areas(&self.openings, places[0]);
        let wider = law.areas(&self.openings, places[0] + 1.0);
        let of = |path: usize| {
            let ([one, other], regime) = (ENDS[path].map(|i| sides[i]), self.regimes[path]);
            let flow =
                |[a, b]: [f64; 2]| regime.flow([a * one[0], one[1]], [b * other[0], other[1]]);
            let change = |parts: [f64; 2]| ((flow(parts)[0] - flow([1.0; 2])[0]) / STEP).abs();
            let most = change([1.0 + STEP, 1.0]).max(change([1.0, 1.0 + STEP]));
            [areas[path] * most, (wider[path] - areas[path]).abs() * most]
        };
        let leak = of(4);
        let of = |i: usize, k: usize| {
            KAPPA * (of(2 * i)[k] + of(2 * i + 1)[k] + leak[k]) / self.content[2 * i]
        };
        [0, 1].map(|k| of(0, k).max(of(1, k)))
    }

    /// `F_A` and the return chamber's force on the bit at these positions and rates of the piston, N.
    pub(crate) fn forces(
        &self,
        parameters: &Parameters,
        [places, speeds]: [Places; 2],
        exhaust: f64,
    ) -> Option<[f64; 2]> {
        let volumes = super::volumes(parameters, places);
        let pressures = super::pressures(&self.content, volumes);
        let forces = pushes(parameters, pressures, speeds[0], exhaust);
        volumes.iter().all(|v| *v > 0.0).then_some(forces)
    }
}

/// `F_A` and the force on the bit of chambers at these pressures, the piston at this speed, N.
pub(super) fn pushes(
    parameters: &Parameters,
    [driving, returning]: [f64; 2],
    speed: f64,
    exhaust: f64,
) -> [f64; 2] {
    let drive = &parameters.drive;
    let back = (returning - exhaust) * drive.area_return;
    [(driving - exhaust) * drive.area_drive - back - parameters.air.drag * speed, back]
}

impl Series {
    pub(super) fn new(air: &Air, problem: &Problem) -> Self {
        let parameters = problem.parameters;
        let law = &parameters.air;
        let mut series = Self::default();
        for (side, poly) in series.sides.iter_mut().zip(&problem.outside) {
            side.pressure.copy_from_slice(&poly.0[..=ORDER]);
            side.heat[0] = GAS * law.temperature;
            side.root[0] = 1.0 / side.heat[0].sqrt();
        }
        for (i, gas) in series.gas.iter_mut().enumerate() {
            (gas.mass[0], gas.entropy[0]) = (air.content[2 * i], air.content[2 * i + 1]);
        }
        series.streams.reserve_exact(PATHS);
        let mut blocks = problem.blocks.clone();
        for k in 0..=ORDER {
            for (i, place) in series.places.iter_mut().enumerate() {
                let still = problem.left.still[i].get(k).copied().unwrap_or_default();
                let part = |block: &Block| block.along(i, block.start);
                place[k] = still + blocks.iter().map(part).sum::<f64>();
            }
            series.chambers(parameters, k);
            let speed: f64 = blocks.iter().map(|block| block.along(0, block.rates())).sum();
            let mut forces = series.forces_at(problem, speed, k);
            if problem.left.gives != [[0.0; 2]; 2] {
                // The displacement by the forces changes the forces in turn. One correction is enough: the next
                // is of higher order.
                let given = problem.left.gives.map(|by| by[0] * forces[0] + by[1] * forces[1]);
                series.places.iter_mut().zip(given).for_each(|(place, by)| place[k] += by);
                if k == 0 {
                    series.chambers(parameters, 0);
                } else {
                    series.swell(parameters, given, k);
                }
                forces = series.forces_at(problem, speed, k);
            }
            if k == 0 {
                series.open(air, problem);
            }
            for (series, force) in series.forces.iter_mut().zip(&forces) {
                series[k] = *force;
            }
            if k < ORDER {
                series.flows(k);
                blocks.iter_mut().for_each(|block| block.go_on([forces[0], forces[1]], k));
            }
        }
        series
    }

    /// Coefficient `k` of `F_A`, of the force on the bit, and of those of the pressures alone.
    fn forces_at(&self, problem: &Problem, speed: f64, k: usize) -> [f64; 4] {
        let (drive, drag) = (&problem.parameters.drive, problem.parameters.air.drag);
        let areas = [drive.area_drive, drive.area_return];
        let pressures = [2, 3].map(|i| self.sides[i].pressure[k]);
        let [push, back] = [0, 1].map(|i| (pressures[i] - problem.outside[1].0[k]) * areas[i]);
        let Left { speeds: [own, other], others, .. } = &problem.left;
        let speed = speed - other * back - others.get(k).copied().unwrap_or_default();
        let force = (push - back - drag * speed) / (1.0 - drag * own);
        [force, back, pressures[0] * areas[0], -pressures[1] * areas[1]]
    }

    /// Adds a stream for every path through which air can flow.
    fn open(&mut self, air: &Air, problem: &Problem) {
        let law = &problem.parameters.air;
        let [now, beyond] = [0.0, 1.0].map(|by| law.areas(&air.openings, self.places[0][0] + by));
        for path in 0..PATHS {
            let Regime { reversed, flow } = air.regimes[path];
            let sides = ENDS[path];
            let partial = path < 4 && air.openings[path / 2][path % 2] == Opening::Partial;
            let area = [now[path], if partial { beyond[path] - now[path] } else { 0.0 }];
            if area == [0.0; 2] {
                continue;
            }
            let (sides, sign) = if reversed { ([sides[1], sides[0]], -1.0) } else { (sides, 1.0) };
            self.streams.push(Stream { path, sides, sign, flow, area, ..Stream::default() });
        }
    }

    /// Coefficient `k` of both chambers' volumes and of their states.
    fn chambers(&mut self, parameters: &Parameters, k: usize) {
        let drive = &parameters.drive;
        let [x, y] = [0, 1].map(|i| self.places[i][k]);
        let volumes = match k {
            0 => super::volumes(parameters, [x, y]),
            _ => [drive.area_drive * x, -drive.area_return * y],
        };
        for (i, gas) in self.gas.iter_mut().enumerate() {
            let side = &mut self.sides[2 + i];
            gas.volume[k] = volumes[i];
            gas.heated[k] = power(&gas.volume, KAPPA - 1.0, &gas.heated, k, heated);
            gas.product[k] = quotient(&gas.entropy, &gas.heated, &gas.product, k);
            side.pressure[k] = quotient(&gas.product, &gas.volume, &side.pressure, k);
            if k > 0 && !self.streams.iter().any(|stream| stream.sides[0] == 2 + i) {
                continue;
            }
            side.heat[k] = quotient(&gas.product, &gas.mass, &side.heat, k);
            side.root[k] = power(&side.heat, -0.5, &side.root, k, |heat| 1.0 / heat.sqrt());
        }
    }

    /// Adds to coefficient `k` of volumes and states what additional displacements change. For `k > 0` all are
    /// linear in it.
    fn swell(&mut self, parameters: &Parameters, [x, y]: Places, k: usize) {
        let drive = &parameters.drive;
        let more = [drive.area_drive * x, -drive.area_return * y];
        for ((gas, side), more) in self.gas.iter_mut().zip(&mut self.sides[2..]).zip(more) {
            let part = more / gas.volume[0];
            gas.volume[k] += more;
            gas.heated[k] += (KAPPA - 1.0) * part * gas.heated[0];
            gas.product[k] -= (KAPPA - 1.0) * part * gas.product[0];
            side.pressure[k] -= KAPPA * part * side.pressure[0];
            side.heat[k] -= (KAPPA - 1.0) * part * side.heat[0];
            side.root[k] += 0.5 * (KAPPA - 1.0) * part * side.root[0];
        }
    }

    /// Coefficient `k` of all flows, and coefficient `k + 1` of the contents.
    fn flows(&mut self, k: usize) {
        let [mut masses, mut heats] = [[0.0; PATHS]; 2];
        for stream in &mut self.streams {
            let [high, low] = stream.sides.map(|i| &self.sides[i]);
            stream.flow_at(high, low, self.places[0][k], k);
            masses[stream.path] = stream.sign * stream.rate[k];
            heats[stream.path] = stream.sign * product(&stream.rate, &high.heat, k);
        }
        let (gained, warmth) = (super::gains(&masses), super::gains(&heats));
        let next = 1.0 / (k + 1) as f64;
        for (i, gas) in self.gas.iter_mut().enumerate() {
            gas.mass[k + 1] = next * gained[i];
            gas.warmth[k] = warmth[i];
            gas.entropy[k + 1] = next * KAPPA * product(&gas.heated, &gas.warmth, k);
        }
        self.sums[0][k + 1] = next * (masses[0] + masses[2]);
        self.sums[1][k + 1] = next * HEAT * (heats[0] + heats[2] - heats[1] - heats[3]);
    }

    /// How long the series holds, s: until one of its last two terms reaches the error allowed.
    pub(super) fn length(&self, air: &Air, problem: &Problem) -> f64 {
        let parameters = problem.parameters;
        let mut length = problem.left.longest;
        let mut look = |series: &Powers, scale: f64, allowed: f64| {
            for k in [ORDER - 1, ORDER] {
                let part = (series[k] / scale).abs();
                if part.is_nan() {
                    length = 0.0;
                } else if part * math::powi(length, k) > allowed {
                    length = math::pow(allowed / part, 1.0 / k as f64);
                }
            }
        };
        let (error, instant) = (parameters.air.error, instant(parameters.air.error));
        for (i, gas) in self.gas.iter().enumerate() {
            look(&gas.mass, gas.mass[0], error);
            look(&gas.entropy, gas.entropy[0], error);
            look(&self.sides[2 + i].pressure, self.sides[2 + i].pressure[0], instant);
        }
        if air.openings.as_flattened().contains(&Opening::Partial) {
            look(&self.places[0], parameters.air.port_height, instant);
        }
        let positive = |gas: &Gas| gas.volume[0] > 0.0 && gas.mass[0] > 0.0 && gas.entropy[0] > 0.0;
        if self.gas.iter().all(positive) { length } else { 0.0 }
    }
}

impl Block {
    /// Contribution of the coordinates to a position.
    fn along(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        self.parts[place][0] * p + self.parts[place][1] * q
    }

    fn rates(&self) -> [f64; 2] {
        let ([p, q], b) = (self.start, &self.matrix);
        [b[0] * p + b[1] * q, b[2] * p + b[3] * q]
    }

    /// From coefficient `k` to `k + 1`, with coefficient `k` of the forces.
    fn go_on(&mut self, forces: [f64; 2], k: usize) {
        let rates = self.rates();
        self.start = from_fn(|c| {
            let other = self.others[c].get(k).copied().unwrap_or_default();
            let pushed = self.pushed[0][c] * forces[0] + self.pushed[1][c] * forces[1];
            (rates[c] + pushed + other) / (k + 1) as f64
        });
    }
}

impl Stream {
    /// Coefficient `k` of the flow from side `high` to side `low`, with coefficient `k` of the piston's
    /// position.
    fn flow_at(&mut self, high: &Side, low: &Side, place: f64, k: usize) {
        let factor = (2.0 * HEAT).sqrt();
        self.shape[k] = match self.flow {
            Flow::Straight => STRAIGHT_SLOPE * (high.pressure[k] - low.pressure[k]),
            Flow::Choked => CHOKED_FLOW * high.pressure[k],
            Flow::Subsonic => {
                self.ratio[k] = quotient(&low.pressure, &high.pressure, &self.ratio, k);
                self.bent[k] = power(&self.ratio, 1.0 / KAPPA, &self.bent, k, math::five_sevenths);
                self.rest[k] = self.bent[k] - self.ratio[k];
                // The subsonic flow is the square root of this, times the higher pressure over `sqrt(R T)`.
                self.square[k] = product(&self.bent, &self.rest, k);
                self.jet[k] = power(&self.square, 0.5, &self.jet, k, f64::sqrt);
                product(&high.pressure, &self.jet, k)
            }
        };
        self.open[k] = if k == 0 { self.area[0] } else { self.area[1] * place };
        self.blown[k] = product(&self.shape, &high.root, k);
        self.rate[k] = factor * product(&self.open, &self.blown, k);
    }
}
