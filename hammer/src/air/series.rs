//! Power series in time of the air of one window, and of the steel that it pushes.
//!
//! Gas and steel are expanded together, coefficient by coefficient. Coefficient `k` of the steel's coordinates
//! gives that of the volumes; volumes and contents give the pressures; pressures give forces and flows; and
//! these give coefficient `k + 1` of coordinates and contents. Nothing is iterated or rejected: the last
//! coefficients say how far the series holds ([`Series::length`]).
//!
//! Coefficient `k` of a product of two series, and of every other operation, is a sum over pairs of coefficients. All
//! operations on one chamber or one flow are lanes of the same rows ([`Lanes`]), whose sums are made together.

use super::{Air, ENDS, PATHS, Places};
use crate::laws::air::{CHOKED_FLOW, Flow, GAS, KAPPA, Opening, Regime, STRAIGHT_SLOPE, heated};
use crate::numerics::kernel::{Row, convolve};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, ORDER, Powers};
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

/// The factors of as many products of series as a row has numbers.
#[derive(Clone, Debug, Default)]
struct Lanes {
    left: [Row; ORDER + 1],
    right: [Row; ORDER + 1],
    /// Of each product, coefficient `k` without the terms of a first coefficient.
    sum: Row,
}

/// A path through which air flows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stream {
    pub(super) path: usize,
    /// Upstream and downstream side, and the sign of the flow along the path.
    sides: [usize; 2],
    sign: f64,
    flow: Flow,
    /// The opening's area at the start, m2, and its slope over `x`.
    area: [f64; 2],
}

/// Coefficients of the air on one side of a flow path.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    pressure: f64,
    /// `R T`.
    heat: f64,
    /// The pressure over `sqrt(R T)`.
    sonic: f64,
}

/// The power series of a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Coefficients of the expanded coordinates.
    blocks: Vec<Block>,
    /// Both chambers, then the flows.
    lanes: [Lanes; 2 + PATHS],
    pub(super) streams: Vec<Stream>,
    /// Pressures on the sides of the flow paths.
    pub(super) pressures: [Powers; 4],
    /// Contents of the chambers.
    pub(super) content: [Powers; 4],
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
    /// Expands the window that begins at the epoch.
    pub(super) fn solve(&mut self, air: &Air, problem: &Problem) {
        let parameters = problem.parameters;
        for (powers, poly) in self.pressures.iter_mut().zip(&problem.outside) {
            powers.copy_from_slice(&poly.0[..=ORDER]);
        }
        self.content.iter_mut().zip(air.content).for_each(|(powers, content)| powers[0] = content);
        self.sums = Default::default();
        self.streams.clear();
        let mut blocks = std::mem::take(&mut self.blocks);
        blocks.clone_from(&problem.blocks);
        for k in 0..=ORDER {
            for (i, place) in self.places.iter_mut().enumerate() {
                let still = problem.left.still[i].get(k).copied().unwrap_or_default();
                let part = |block: &Block| block.along(i, block.start);
                place[k] = still + blocks.iter().map(part).sum::<f64>();
            }
            for lanes in &mut self.lanes[..2 + self.streams.len()] {
                let inner = 1..k.max(1);
                convolve(&lanes.left[inner.clone()], &lanes.right[inner], &mut lanes.sum);
            }
            self.chambers(parameters, k);
            let speed: f64 = blocks.iter().map(|block| block.along(0, block.rates())).sum();
            let mut forces = self.forces_at(problem, speed, k);
            if problem.left.gives != [[0.0; 2]; 2] {
                // The displacement by the forces changes the forces in turn. One correction is enough: the next
                // is of higher order.
                let given = problem.left.gives.map(|by| by[0] * forces[0] + by[1] * forces[1]);
                self.places.iter_mut().zip(given).for_each(|(place, by)| place[k] += by);
                self.chambers(parameters, k);
                forces = self.forces_at(problem, speed, k);
            }
            if k == 0 {
                self.open(air, problem);
            }
            for (series, force) in self.forces.iter_mut().zip(&forces) {
                series[k] = *force;
            }
            if k < ORDER {
                self.flows(parameters, k);
                blocks.iter_mut().for_each(|block| block.go_on([forces[0], forces[1]], k));
            }
        }
        self.blocks = blocks;
    }

    /// Coefficient `k` of `F_A`, of the force on the bit, and of those of the pressures alone.
    fn forces_at(&self, problem: &Problem, speed: f64, k: usize) -> [f64; 4] {
        let (drive, drag) = (&problem.parameters.drive, problem.parameters.air.drag);
        let areas = [drive.area_drive, drive.area_return];
        let pressures = [2, 3].map(|i| self.pressures[i][k]);
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
            self.streams.push(Stream { path, sides, sign, flow, area });
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
        for (i, volume) in volumes.into_iter().enumerate() {
            let [mass, entropy] = [0, 1].map(|kind| self.content[2 * i + kind][k]);
            let pressure = self.lanes[i].chamber(k, volume, mass, entropy);
            self.pressures[2 + i][k] = pressure;
        }
    }

    /// Coefficient `k` of the air on a side of the flow paths.
    fn side(&self, parameters: &Parameters, side: usize, k: usize) -> Side {
        let pressure = self.pressures[side][k];
        if side < 2 {
            let heat = GAS * parameters.air.temperature;
            let sonic = pressure / heat.sqrt();
            return Side { pressure, heat: if k == 0 { heat } else { 0.0 }, sonic };
        }
        let [.., heat, _, sonic, _] = self.lanes[side - 2].left[k];
        Side { pressure, heat, sonic }
    }

    /// Coefficient `k` of all flows, and coefficient `k + 1` of the contents.
    fn flows(&mut self, parameters: &Parameters, k: usize) {
        let [mut masses, mut heats] = [[0.0; PATHS]; 2];
        for (i, stream) in self.streams.iter().enumerate() {
            let [high, low] = stream.sides.map(|side| self.side(parameters, side, k));
            let open = stream.area[1] * self.places[0][k];
            let open = if k == 0 { stream.area[0] } else { open };
            let [rate, heat] = self.lanes[2 + i].flow(k, stream.flow, [high, low], open);
            masses[stream.path] = stream.sign * rate;
            heats[stream.path] = stream.sign * heat;
        }
        let (gained, warmth) = (super::gains(&masses), super::gains(&heats));
        let next = 1.0 / (k + 1) as f64;
        for i in 0..2 {
            let lanes = &mut self.lanes[i];
            lanes.right[k][7] = warmth[i];
            self.content[2 * i][k + 1] = next * gained[i];
            self.content[2 * i + 1][k + 1] = next * KAPPA * lanes.product(k, 7);
        }
        self.sums[0][k + 1] = next * (masses[0] + masses[2]);
        self.sums[1][k + 1] = next * HEAT * (heats[0] + heats[2] - heats[1] - heats[3]);
    }

    /// How long the series holds, s: until one of its last two terms reaches the error allowed.
    pub(super) fn length(&self, air: &Air, problem: &Problem) -> f64 {
        let parameters = problem.parameters;
        // Of both terms, the largest over what is allowed of it, if the length is 1 s.
        let (mut most, mut sum) = ([0.0f64; 2], 0.0);
        let mut look = |series: &Powers, allowed: f64| {
            for (most, c) in most.iter_mut().zip(&series[ORDER - 1..]) {
                let part = (c / allowed).abs();
                (*most, sum) = (most.max(part), sum + part);
            }
        };
        let (error, instant) = (parameters.air.error, instant(parameters.air.error));
        self.content.iter().for_each(|content| look(content, content[0] * error));
        self.pressures[2..].iter().for_each(|pressure| look(pressure, pressure[0] * instant));
        if air.openings.as_flattened().contains(&Opening::Partial) {
            look(&self.places[0], parameters.air.port_height * instant);
        }
        let mut length = if sum.is_nan() { 0.0 } else { problem.left.longest };
        for (k, most) in (ORDER - 1..).zip(most) {
            if most * math::powi(length, k) > 1.0 {
                length = math::pow(1.0 / most, 1.0 / k as f64);
            }
        }
        let volumes = super::volumes(parameters, self.places.map(|place| place[0]));
        let positive = self.content.iter().all(|content| content[0] > 0.0);
        if positive && volumes.iter().all(|v| *v > 0.0) { length } else { 0.0 }
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

impl Lanes {
    /// Coefficient `k` of the product in a lane, whose factors' coefficients are known.
    fn product(&self, k: usize, lane: usize) -> f64 {
        let [[a0, b0], [a, b]] = [0, k].map(|k| [self.left[k][lane], self.right[k][lane]]);
        if k == 0 { a0 * b0 } else { self.sum[lane] + a0 * b + a * b0 }
    }

    /// Coefficient `k` of a chamber's pressure, and of what else its state gives, from that of volume and content.
    /// The last lane is that of the entropy's rate.
    fn chamber(&mut self, k: usize, volume: f64, mass: f64, entropy: f64) -> f64 {
        let (heated, product, pressure, heat, speed, sonic);
        let order = k as f64;
        if k == 0 {
            heated = self::heated(volume);
            (product, pressure) = (entropy / heated, entropy / heated / volume);
            heat = product / mass;
            speed = heat.sqrt();
            sonic = pressure / speed;
        } else {
            let [heated0, _, product0, pressure0, heat0, speed0, sonic0, _] = self.left[0];
            let (volume0, mass0, sum) = (self.right[0][1], self.right[0][4], &self.sum);
            let risen = (KAPPA - 1.0) * (sum[0] + order * heated0 * volume) - sum[1];
            heated = risen / (order * volume0);
            product = (entropy - sum[2] - product0 * heated) / heated0;
            pressure = (product - sum[3] - pressure0 * volume) / volume0;
            heat = (product - sum[4] - heat0 * mass) / mass0;
            speed = 0.5 * (heat - sum[5]) / speed0;
            sonic = (pressure - sum[6] - sonic0 * speed) / speed0;
        }
        self.left[k] = [heated, order * heated, product, pressure, heat, speed, sonic, heated];
        self.right[k] = [order * volume, volume, heated, volume, mass, speed, speed, 0.0];
        pressure
    }

    /// Coefficient `k` of a flow from one side to the other, kg/s, and of its product with `R T`, from that of the
    /// opening.
    fn flow(&mut self, k: usize, flow: Flow, [high, low]: [Side; 2], open: f64) -> [f64; 2] {
        let (order, start) = (k as f64, k == 0);
        let ([ratio0, bent0, _, _, jet0, ..], high0, sum) =
            (self.left[0], self.right[0][0], &self.sum);
        let [mut ratio, mut bent, mut rest] = [0.0; 3];
        if flow != Flow::Choked {
            let known = low.pressure - sum[0] - ratio0 * high.pressure;
            ratio = if start { low.pressure / high.pressure } else { known / high0 };
        }
        if flow == Flow::Subsonic {
            let risen = (sum[1] + order * bent0 * ratio) / KAPPA - sum[2];
            bent = if start { math::five_sevenths(ratio) } else { risen / (order * ratio0) };
            rest = bent - ratio;
        }
        self.left[k] = [ratio, bent, order * bent, bent, 0.0, 0.0, open, 0.0];
        self.right[k] =
            [high.pressure, order * ratio, ratio, rest, 0.0, high.sonic, 0.0, high.heat];
        // The flow through 1 m2 is this times the higher pressure over `sqrt(R T)`.
        let unit = f64::from(u8::from(start));
        let square = self.product(k, 3);
        let jet = match flow {
            Flow::Straight => STRAIGHT_SLOPE * (unit - ratio),
            Flow::Choked => CHOKED_FLOW * unit,
            Flow::Subsonic if start => square.sqrt(),
            Flow::Subsonic => 0.5 * (square - self.sum[4]) / jet0,
        };
        (self.left[k][4], self.left[k][5], self.right[k][4]) = (jet, jet, jet);
        self.right[k][6] = self.product(k, 5);
        let rate = (2.0 * HEAT).sqrt() * self.product(k, 6);
        self.left[k][7] = rate;
        [rate, self.product(k, 7)]
    }
}
