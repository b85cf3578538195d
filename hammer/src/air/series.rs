//! Power series in time of the air of one window, and of the steel that it pushes.
//!
//! Gas and steel are expanded together, coefficient by coefficient. Coefficient `k` of the steel's coordinates
//! gives that of the volumes. With the heat that has flowed, a volume gives the pressure,
//! `V p' = kappa (sum flow R T - p V')`; pressures give forces and flows; and these give coefficient `k + 1` of
//! coordinates and masses. Nothing is iterated or rejected: the last coefficients say how far the series holds
//! ([`Series::length`]).
//!
//! Coefficient `k` of a product of two series, and of every other operation, is a sum over pairs of coefficients. All
//! operations on the chambers, and all on one flow ([`Stream`]), share rows ([`Lanes`]), so that their sums are
//! computed together.

use super::fit::Fit;
use super::stream::{self, Lanes, Stream};
use super::{Air, ENDS, PATHS, Places};
use crate::laws::air::{GAS, KAPPA, Opening, Regime, Side};
use crate::numerics::kernel::{LANES, Row, vectorised};
use crate::numerics::math;
use crate::numerics::poly::{OVER, Poly};
use crate::numerics::series::{LOW, ORDER};
use crate::numerics::vectors::dispatch;
use crate::quantities::air::AirLaw;
use crate::quantities::parameters::Parameters;
use pulp::{Simd, WithSimd};
use std::array::from_fn;

/// Longest window, s, even if the series would be valid for longer.
pub(crate) const LONGEST: f64 = 0.02;
/// Largest error of a pressure at one instant, unless a larger error of its mean is allowed.
const INSTANT: f64 = 1e-4;
/// A flow changes its formula once the pressures have passed the formula's bound by this many times their error.
const BEYOND: f64 = 2.0;
/// Heat capacity of air at constant pressure, over its gas constant.
const HEAT: f64 = KAPPA / (KAPPA - 1.0);
/// Lanes of [`Series::rows`] after the forces on the piston and on the bit: pressures and masses of the chambers, and
/// the piston's positions.
pub(super) const PRESSURE: usize = 2;
const MASS: usize = 4;
pub(super) const PLACE: usize = 6;
/// Lanes per chamber in the row of both chambers: products of the volume and of its rate with the pressure, of `R T`
/// with the mass, and of `R T` with the total outflow.
const CHAMBER: usize = LANES / 2;

/// Two coordinates of the steel, `z' = B z + b f`, and their share of the piston's positions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub start: [f64; 2],
    /// `B`, row by row.
    pub matrix: [f64; 4],
    /// `b` for the force `F_A` on the piston, and for the return chamber's force on the bit.
    pub pushed: [[f64; 2]; 2],
    /// What the other loads contribute to `b f`: a power series in time.
    pub others: [[f64; LOW]; 2],
    /// Shares of the coordinates in `x` and in `y`.
    pub parts: [[f64; 2]; 2],
}

/// Coordinates of the steel that are not expanded, because they follow the forces without delay (quasi-static). A
/// force's displacement is divided among all coordinates so that the shares of its speed cancel: the expanded
/// coordinates take what the others do not.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Left {
    /// The piston's positions without the expanded coordinates and without the forces, m: a power series in
    /// time.
    pub still: [[f64; LOW]; 2],
    /// Compliance: displacement of each position by each of the forces, m/N.
    pub gives: [[f64; 2]; 2],
    /// What each force contributes at once to the speed of `x` through these coordinates, m/(N s), and what the other
    /// loads contribute, m/s: a power series in time.
    pub speeds: [f64; 2],
    pub others: [f64; LOW],
    /// Longest time for which they may be taken as quasi-static, s.
    pub longest: f64,
}

/// The problem from which a window is solved.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    pub parameters: &'a Parameters,
    /// The expanded coordinates, and the quasi-static ones.
    pub blocks: Vec<Block>,
    pub left: Left,
    /// True if the piston's two positions differ.
    pub apart: bool,
    /// The piston's positions at the epoch.
    pub places: Places,
    /// Pressures of supply and exhaust after the epoch.
    pub outside: [Poly; 2],
}

/// A chamber's first coefficients.
#[derive(Clone, Copy, Debug, Default)]
struct Chamber {
    pressure: f64,
    /// `R T`.
    heat: f64,
    volume: f64,
    /// The sum of the flows out of the chamber.
    outflow: f64,
    /// Reciprocals of volume and mass.
    reciprocals: [f64; 2],
    /// Pressure lost per volume gained, `kappa p / V`, Pa/m3.
    stiffness: f64,
}

/// Coefficients of the masses and of `sum flow R T` that [`Air::sides`] gain, and of the total flow out of each. Those of
/// the chambers are [`Self::of_chambers`].
#[derive(Clone, Copy, Debug, Default)]
struct Gains {
    masses: [f64; 4],
    heats: [f64; 4],
    outflows: [f64; 4],
}

impl Gains {
    /// Adds a flow and its product with `R T`. The product is left out for flows out of a chamber, whose sum is
    /// multiplied once.
    #[inline(always)]
    fn add(&mut self, stream: &Stream, [flow, warmth]: [f64; 2]) {
        let [from, to] = stream.sides;
        self.masses[from] -= flow;
        self.outflows[from] += flow;
        self.masses[to] += flow;
        self.heats[to] += warmth;
    }

    /// What the chambers gain, and what the supply gives.
    #[inline(always)]
    fn of_chambers(&self) -> ([[f64; 2]; 3], f64) {
        let of = |all: [f64; 4]| [all[2], all[3]];
        ([self.masses, self.heats, self.outflows].map(of), -self.masses[0])
    }
}

/// The power series of a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Coefficients of the expanded coordinates.
    blocks: Vec<Block>,
    chambers: [Chamber; 2],
    /// Products of both chambers in the first row, then one row per flow.
    lanes: [Lanes; 1 + PATHS],
    pub(super) streams: Vec<Stream>,
    /// True if the pressures of supply and exhaust are constant.
    pub(super) is_still: bool,
    /// `F_A`, the return chamber's force on the bit, pressures and masses of the chambers, the piston's positions.
    pub(super) rows: [Row; ORDER + 1],
    /// Series of the mass taken from the supply, and of the enthalpy that enters the chambers.
    pub(super) sums: [[f64; 2]; ORDER + 1],
    /// The rows, scaled to the window's length and projected.
    pub(super) fit: Fit,
}

/// Error allowed at the end of a window for an opening, and for a pressure that passes a bound, if `error` is allowed
/// of means over the window. The mean of the last power `t^k` is `k + 1` times less than its value at the end.
pub(super) fn instant(error: f64) -> f64 {
    error.max(INSTANT.min(0.25 * ORDER as f64 * error))
}

impl Air {
    /// Gives every flow the formula of the present pressures on its sides. A flow near a bound keeps its formula.
    pub(crate) fn classify(&mut self, parameters: &Parameters, sides: &[Side; 4]) {
        // The time of a change of formula is known only as well as the pressures are.
        let margin = BEYOND * instant(parameters.air.error);
        for (regime, ends) in self.regimes.iter_mut().zip(ENDS) {
            let pressures = ends.map(|i| sides[i][0]);
            if regime.beyond(pressures).iter().any(|beyond| *beyond > margin) {
                *regime = Regime::of(pressures);
            }
        }
    }

    /// Largest relative rates of a chamber's content, 1/s: per relative change of a pressure, and per metre of the
    /// piston's position where ports are partly open.
    pub(crate) fn haste(&self, parameters: &Parameters, x: f64, sides: &[Side; 4]) -> [f64; 2] {
        let [areas, wider] = [x, x + 1.0].map(|x| parameters.air.areas(&self.openings, x));
        let all: [[f64; 2]; PATHS] = from_fn(|path| {
            let (area, opens) = (areas[path], (wider[path] - areas[path]).abs());
            if area == 0.0 && opens == 0.0 {
                return [0.0; 2];
            }
            let [one, other] = ENDS[path].map(|i| sides[i]);
            let most = self.regimes[path].steepness(one, other);
            [area * most, opens * most]
        });
        let of = |i: usize, k: usize| {
            KAPPA * (all[2 * i][k] + all[2 * i + 1][k] + all[4][k]) / self.content[2 * i]
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

/// `F_A` and the force on the bit for chambers at these pressures and a piston at this speed, N.
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

vectorised! {
    /// Expands the window that begins at the epoch.
    pub(super) fn expand(series: &'a mut Series, air: &'a Air, problem: &'a Problem<'a>) -> () as Expand, simd {
        let mut blocks = std::mem::take(&mut series.blocks);
        blocks.clone_from(&problem.blocks);
        let mut gains = series.begin(air, problem, &blocks);
        for k in 1..=ORDER {
            gains = series.go_on(simd, problem, &mut blocks, (k, gains));
        }
        series.blocks = blocks;
    }
}

impl Problem<'_> {
    /// Coefficient `k` of the piston's positions, without the immediate effect of the forces' own coefficient `k`.
    #[inline(always)]
    fn unforced(&self, blocks: &[Block], k: usize) -> Places {
        let still = &self.left.still;
        let mut places = [0, 1].map(|i| if k < LOW { still[i][k] } else { 0.0 });
        for block in blocks {
            places[0] += block.along(0, block.start);
            if self.apart {
                places[1] += block.along(1, block.start);
            }
        }
        if self.apart { places } else { [places[0]; 2] }
    }

    /// Coefficient `k` of `F_A` and of the force on the bit.
    #[inline(always)]
    fn forces(&self, pressures: [f64; 2], blocks: &[Block], k: usize) -> [f64; 2] {
        let (drive, drag) = (&self.parameters.drive, self.parameters.air.drag);
        let exhaust = self.outside[1].0[k];
        let push = (pressures[0] - exhaust) * drive.area_drive;
        let back = (pressures[1] - exhaust) * drive.area_return;
        if drag == 0.0 {
            return [push - back, back];
        }
        let Left { speeds: [own, other], others, .. } = &self.left;
        let speed: f64 = blocks.iter().map(|block| block.along(0, block.rates())).sum();
        let speed = speed - other * back - if k < LOW { others[k] } else { 0.0 };
        [(push - back - drag * speed) / (1.0 - drag * own), back]
    }

    /// The immediate displacement by these forces.
    #[inline(always)]
    fn given(&self, forces: [f64; 2]) -> Places {
        self.left.gives.map(|by| by[0] * forces[0] + by[1] * forces[1])
    }

    /// Coefficient `k` of the air on the sides of the flow paths.
    #[inline(always)]
    fn sides(&self, pressures: [f64; 2], heats: [f64; 2], k: usize) -> [stream::Air; 4] {
        let heat = if k == 0 { GAS * self.parameters.air.temperature } else { 0.0 };
        let [supply, exhaust] = [0, 1].map(|i| [self.outside[i].0[k], heat]);
        [supply, exhaust, [pressures[0], heats[0]], [pressures[1], heats[1]]]
    }
}

impl Series {
    /// Sets the first coefficients.
    fn begin(&mut self, air: &Air, problem: &Problem, blocks: &[Block]) -> Gains {
        let at = |places: Places| {
            let volumes = super::volumes(problem.parameters, places);
            (volumes, super::pressures(&air.content, volumes))
        };
        let mut places = problem.unforced(blocks, 0);
        let (mut volumes, mut pressures) = at(places);
        let mut forces = problem.forces(pressures, blocks, 0);
        if problem.left.is_soft() {
            let given = problem.given(forces);
            places = [places[0] + given[0], places[1] + given[1]];
            (volumes, pressures) = at(places);
            forces = problem.forces(pressures, blocks, 0);
        }
        let masses = [air.content[0], air.content[2]];
        self.chambers = from_fn(|i| {
            let (volume, mass, pressure) = (volumes[i], masses[i], pressures[i]);
            let reciprocals = [1.0 / volume, 1.0 / mass];
            let heat = pressure * volume * reciprocals[1];
            let stiffness = KAPPA * pressure * reciprocals[0];
            Chamber { pressure, heat, volume, outflow: 0.0, reciprocals, stiffness }
        });
        self.open(air, problem, places[0]);
        let (heats, mut gains) = (self.chambers.map(|chamber| chamber.heat), Gains::default());
        let sides = problem.sides(pressures, heats, 0);
        self.is_still = problem.outside.iter().all(Poly::is_constant);
        let is_still = self.is_still;
        for (stream, lanes) in self.streams.iter_mut().zip(&mut self.lanes[1..]) {
            let flow = stream.begin(lanes, &sides, is_still);
            gains.add(stream, flow);
        }
        let ([_, _, outflows], _) = gains.of_chambers();
        for (chamber, outflow) in self.chambers.iter_mut().zip(outflows) {
            chamber.outflow = outflow;
        }
        self.rows[0] = row(forces, pressures, masses, places);
        self.sums[0] = [0.0; 2];
        for i in 0..2 {
            gains.heats[2 + i] -= heats[i] * outflows[i];
        }
        let [(v, w), (p, q)] = [(volumes[0], volumes[1]), (pressures[0], pressures[1])];
        let ([h, g], [m, n], [out, off]) = (heats, masses, outflows);
        self.lanes[0].begin([v, 0.0, h, h, w, 0.0, g, g], [p, p, m, out, q, q, n, off]);
        gains
    }

    /// Sets coefficient `k` from what the chambers gained by coefficient `k - 1`. Returns what they gain by coefficient
    /// `k`.
    #[inline(always)]
    fn go_on<S: Simd>(
        &mut self,
        simd: S,
        problem: &Problem,
        blocks: &mut [Block],
        (k, gained): (usize, Gains),
    ) -> Gains {
        let (order, over) = (k as f64, OVER[k - 1]);
        let ([gained_masses, gained_heats, _], supplied) = gained.of_chambers();
        let before = [self.rows[k - 1][0], self.rows[k - 1][1]];
        blocks.iter_mut().for_each(|block| block.go_on(before, k - 1, over));
        let drive = &problem.parameters.drive;
        let (swept, chambers) = ([drive.area_drive, -drive.area_return], &self.chambers);
        let sum = self.lanes[0].inner::<S, 0>(simd, k);
        let lane = |i: usize, product: usize| sum[CHAMBER * i + product];
        let mut places = problem.unforced(blocks, k);
        let mut pressures = from_fn(|i| {
            let warmed = KAPPA * gained_heats[i] - (KAPPA - 1.0) * lane(i, 1);
            let grown = chambers[i].stiffness * swept[i] * places[i];
            chambers[i].reciprocals[0] * (over * warmed - lane(i, 0)) - grown
        });
        let mut forces = problem.forces(pressures, blocks, k);
        if problem.left.is_soft() {
            // The displacement by the forces changes the forces in turn. One correction is enough, because the next one
            // is of higher order.
            for (i, given) in problem.given(forces).into_iter().enumerate() {
                places[i] += given;
                pressures[i] -= chambers[i].stiffness * swept[i] * given;
            }
            forces = problem.forces(pressures, blocks, k);
        }
        let masses = gained_masses.map(|gain| over * gain);
        self.rows[k] = row(forces, pressures, masses, places);
        self.sums[k] = [over * supplied, over * HEAT * (gained_heats[0] + gained_heats[1])];
        if k == ORDER {
            return gained;
        }
        let volumes: [f64; 2] = from_fn(|i| swept[i] * places[i]);
        let heats = from_fn(|i| {
            let chamber = &chambers[i];
            let grown = volumes[i] * chamber.pressure + chamber.volume * pressures[i];
            let left = lane(i, 0) + grown - lane(i, 2) - chamber.heat * masses[i];
            chamber.reciprocals[1] * left
        });
        let (sides, mut gains) = (problem.sides(pressures, heats, k), Gains::default());
        for (stream, lanes) in self.streams.iter().zip(&mut self.lanes[1..]) {
            let flow = stream.go_on(simd, lanes, (k, over), (&sides, places[0]));
            gains.add(stream, flow);
        }
        let ([_, _, outflows], _) = gains.of_chambers();
        for i in 0..2 {
            let Chamber { heat, outflow, .. } = chambers[i];
            gains.heats[2 + i] -= lane(i, 3) + heat * outflows[i] + heats[i] * outflow;
            let left = [volumes[i], order * volumes[i], heats[i], heats[i]];
            let right = [pressures[i], pressures[i], masses[i], outflows[i]];
            self.lanes[0].put(k, i, left, right);
        }
        gains
    }

    /// Adds a stream for every path through which air can flow.
    fn open(&mut self, air: &Air, problem: &Problem, x: f64) {
        let law = &problem.parameters.air;
        let [now, beyond] = [x, x + 1.0].map(|x| law.areas(&air.openings, x));
        self.streams.clear();
        for path in 0..PATHS {
            let partial = path < 4 && air.openings[path / 2][path % 2] == Opening::Partial;
            let area = [now[path], if partial { beyond[path] - now[path] } else { 0.0 }];
            if area != [0.0; 2] {
                self.streams.push(Stream::new(path, air.regimes[path], area));
            }
        }
    }
}

/// A row of [`Series::rows`].
#[inline(always)]
fn row([f, b]: [f64; 2], [p, q]: [f64; 2], [m, n]: [f64; 2], [x, y]: Places) -> Row {
    [f, b, p, q, m, n, x, y]
}

impl Series {
    /// How long the series is valid, s: until one of its last two terms reaches the allowed error.
    pub(super) fn length(&self, air: &Air, problem: &Problem) -> f64 {
        let AirLaw { error, port_height, .. } = problem.parameters.air;
        let first = &self.rows[0];
        let mut weights = [0.0; LANES];
        for lane in PRESSURE..PLACE {
            weights[lane] = 1.0 / (first[lane] * error);
        }
        if air.openings.as_flattened().contains(&Opening::Partial) {
            weights[PLACE] = 1.0 / (port_height * instant(error));
        }
        let mut length = problem.left.longest;
        for (k, row) in self.rows.iter().enumerate().skip(ORDER - 1) {
            // The largest ratio of a term to its allowed error if the length is 1 s; infinite for NaN.
            let part = row.iter().zip(&weights).map(|(c, weight)| (c * weight).abs());
            let most = part.fold(0.0, |most: f64, part| if part <= most { most } else { part });
            if most.is_nan() {
                return 0.0;
            }
            if most * math::powi(length, k) > 1.0 {
                length = 1.0 / math::rough_root(most, k as u64);
            }
        }
        let volumes = self.chambers.map(|chamber| chamber.volume);
        let positive = volumes.iter().chain(&first[MASS..PLACE]).all(|x| *x > 0.0);
        if positive && length.is_finite() { length } else { 0.0 }
    }
}

impl Left {
    fn is_soft(&self) -> bool {
        self.gives != [[0.0; 2]; 2]
    }
}

impl Block {
    /// Contribution of the coordinates to a position.
    #[inline(always)]
    fn along(&self, place: usize, [p, q]: [f64; 2]) -> f64 {
        self.parts[place][0] * p + self.parts[place][1] * q
    }

    #[inline(always)]
    fn rates(&self) -> [f64; 2] {
        let ([p, q], b) = (self.start, &self.matrix);
        [b[0] * p + b[1] * q, b[2] * p + b[3] * q]
    }

    /// Steps from coefficient `k` to `k + 1`, given coefficient `k` of the forces.
    #[inline(always)]
    fn go_on(&mut self, forces: [f64; 2], k: usize, over: f64) {
        let rates = self.rates();
        self.start = from_fn(|c| {
            let pushed = self.pushed[0][c] * forces[0] + self.pushed[1][c] * forces[1];
            let other = if k < LOW { self.others[c][k] } else { 0.0 };
            (rates[c] + pushed + other) * over
        });
    }
}
