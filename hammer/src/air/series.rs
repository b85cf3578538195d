//! Power series in time of the air of one window, and of the steel that it pushes.
//!
//! Gas and steel are expanded together, coefficient by coefficient. Coefficient `k` of the steel's coordinates
//! gives that of the volumes. With the heat that has flowed, a volume gives the pressure,
//! `V p' = kappa (sum flow R T - p V')`; pressures give forces and flows; and these give coefficient `k + 1` of
//! coordinates and masses. Nothing is iterated or rejected: the last coefficients say how far the series holds
//! ([`Series::length`]).
//!
//! Coefficient `k` of a product of two series, and of every other operation, is a sum over pairs of coefficients. All
//! operations on the chambers and on the flows ([`Stream`]) share rows ([`Lanes`]), so that their sums are computed
//! together.

use super::chambers::{Chambers, Last, Moved};
use super::fit::{Fit, MASS, PLACE};
use super::lanes::Lanes;
use super::steel::{Bodies, Expansion, Modes, Steel};
use super::stream::{self, Gains, Order, Stream};
use super::{Air, ENDS, PATHS, Places};
use crate::laws::air::{GAS, KAPPA, Opening, Regime, Side};
use crate::numerics::kernel::{Row, vectorised};
use crate::numerics::math;
use crate::numerics::poly::{OVER, Poly};
use crate::numerics::series::{HIGH, LOW, ORDER, Powers};
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
/// The chambers' halves of [`Lanes`]: products of the volumes and of their rates with the pressures; and, if air leaves
/// a chamber, of `R T` with the masses and with the total outflows. All factors but the outflows are divided by their
/// first coefficients.
const SWELLING: usize = 0;
const WARMTH: usize = 1;

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
    /// The expanded steel, and the quasi-static coordinates.
    pub steel: &'a Steel,
    pub left: Left,
    /// True if the piston's two positions differ.
    pub apart: bool,
    /// The piston's positions at the epoch.
    pub places: Places,
    /// Pressures of supply and exhaust after the epoch.
    pub outside: [&'a Poly; 2],
}

/// The power series of a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// The expanded coordinates of modes.
    modes: Modes,
    chambers: Chambers,
    /// Products of both chambers, then of each flow.
    lanes: Lanes,
    /// The last coefficients of the air on the sides of the flow paths.
    sides: stream::Air,
    pub(super) streams: Vec<Stream>,
    /// True if air leaves a chamber.
    is_leaving: bool,
    /// True if the pressures of supply and exhaust are constant.
    pub(super) is_still: bool,
    /// True if the forces displace the piston at once.
    is_soft: bool,
    /// `F_A`, the return chamber's force on the bit, pressures and masses of the chambers, the piston's positions.
    pub(super) rows: [Row; ORDER + 1],
    /// Series of the work of both chambers, `int p V'`.
    pub(super) works: Powers,
    /// Displacements of a rigid piston and a rigid bit; zero for other steel.
    pub(super) bodies: [[f64; 2]; HIGH + 1],
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
        match &problem.steel.pair {
            Some(pair) => {
                let mut bodies = Bodies::begin(pair);
                series.run(simd, air, problem, &mut bodies);
                series.go_further(&mut bodies);
            }
            None => {
                let mut modes = std::mem::take(&mut series.modes);
                modes.begin(&problem.steel.blocks);
                series.run(simd, air, problem, &mut modes);
                series.modes = modes;
            }
        }
    }
}

impl Problem<'_> {
    /// Coefficient `k` of the piston's positions, without the immediate effect of the forces' own coefficient `k`, where
    /// the expanded coordinates contribute `moved`.
    #[inline(always)]
    fn unforced<E: Expansion>(&self, moved: Places, k: usize) -> Places {
        let still = &self.left.still;
        let is_moved = !E::WHOLE && k < LOW;
        let [x, y] = from_fn(|i| if is_moved { still[i][k] + moved[i] } else { moved[i] });
        [x, if self.apart { y } else { x }]
    }

    /// Coefficient `k` of `F_A` and of the force on the bit, where drive and return area are pushed with these forces.
    #[inline(always)]
    fn forces<E: Expansion>(&self, [push, back]: [f64; 2], steel: &E, k: usize) -> [f64; 2] {
        let drag = self.parameters.air.drag;
        if E::WHOLE {
            return [push - back - drag * steel.speed(), back];
        }
        if drag == 0.0 {
            return [push - back, back];
        }
        let Left { speeds: [own, other], others, .. } = &self.left;
        let speed = steel.speed() - other * back - if k < LOW { others[k] } else { 0.0 };
        [(push - back - drag * speed) / (1.0 - drag * own), back]
    }

    /// The immediate displacement by these forces.
    #[inline(always)]
    fn given(&self, forces: [f64; 2]) -> Places {
        self.left.gives.map(|by| by[0] * forces[0] + by[1] * forces[1])
    }
}

impl Series {
    /// Finds all coefficients.
    #[inline(always)]
    fn run<S: Simd, E: Expansion>(&mut self, simd: S, air: &Air, problem: &Problem, steel: &mut E) {
        let mut last = self.begin(air, problem, steel);
        let mut order = 0.0;
        for k in 1..ORDER + 1 {
            order += 1.0;
            self.lanes.add_up(simd);
            let order = (k, order, OVER[k - 1]);
            let moved = self.go_on(problem, steel, order, &mut last);
            if k < ORDER {
                self.flow_on(problem, order, &moved, &mut last);
            }
        }
    }

    /// Sets the first coefficients.
    fn begin<E: Expansion>(&mut self, air: &Air, problem: &Problem, steel: &E) -> Last {
        let drive = &problem.parameters.drive;
        let (areas, exhaust) = ([drive.area_drive, drive.area_return], problem.outside[1].0[0]);
        let at = |places: Places| {
            let volumes = super::volumes(problem.parameters, places);
            let pressures = super::pressures(&air.content, volumes);
            let pushed = from_fn(|i| (pressures[i] - exhaust) * areas[i]);
            (volumes, pressures, problem.forces(pushed, steel, 0))
        };
        let mut places = problem.unforced::<E>(steel.places(), 0);
        let (mut volumes, mut pressures, mut forces) = at(places);
        self.is_soft = !E::WHOLE && problem.left.is_soft();
        if self.is_soft {
            let given = problem.given(forces);
            places = [places[0] + given[0], places[1] + given[1]];
            (volumes, pressures, forces) = at(places);
        }
        let masses = [air.content[0], air.content[2]];
        let warm = GAS * problem.parameters.air.temperature;
        self.chambers = Chambers::new(areas, warm, (masses, volumes, pressures));
        let heats = self.chambers.heat;
        self.open(air, problem, places[0]);
        self.lanes.clear();
        self.lanes.begin([1.0, 1.0, 0.0, 0.0], [1.0; 4]);
        self.is_leaving = self.streams.iter().any(Stream::leaves_chamber);
        if self.is_leaving {
            self.lanes.begin([1.0; 4], [0.0; 4]);
        }
        let start =
            [both(problem.outside.map(|poly| poly.0[0]), pressures), both([warm; 2], heats)];
        self.is_still = problem.outside.iter().all(|poly| poly.is_constant());
        self.sides = Default::default();
        let mut gains = Gains::default();
        for stream in &mut self.streams {
            stream.begin(&mut self.lanes, &start, self.is_still, &mut gains);
        }
        let [_, _, outflows @ ..] = gains.flows;
        self.chambers.outflow = outflows;
        if self.is_leaving {
            self.lanes.put(0, WARMTH, [1.0; 4], both([1.0; 2], outflows));
        }
        self.rows[0] = row(forces, pressures, masses, places);
        self.bodies[0] = steel.bodies();
        self.sums[0] = [0.0; 2];
        self.chambers.gained(&gains, forces)
    }

    /// Sets coefficient `k` from what coefficient `k - 1` left. Replaces the forces by their coefficient `k`.
    #[inline(always)]
    fn go_on<E: Expansion>(
        &mut self,
        problem: &Problem,
        steel: &mut E,
        (k, order, over): Order,
        last: &mut Last,
    ) -> Moved {
        let moved = steel.go_on(last.forces, (k - 1, over));
        let (chambers, [p, q, v, w]) = (&self.chambers, *self.lanes.sums(SWELLING));
        let (inner, swollen) = ([p, q], [v, w]);
        let mut places = problem.unforced::<E>(moved, k);
        let swelling = over * (KAPPA - 1.0);
        let mut volumes: [f64; 2] = from_fn(|i| chambers.grows[i] * places[i]);
        let mut pressures: [f64; 2] = from_fn(|i| {
            over * last.warmed[i] - (swelling * swollen[i] + (inner[i] + KAPPA * volumes[i]))
        });
        let mut forces = self.pushed(problem, steel, pressures, k);
        if !E::WHOLE && self.is_soft {
            // The displacement by the forces changes the forces in turn. One correction is enough, because the next one
            // is of higher order.
            for (i, given) in problem.given(forces).into_iter().enumerate() {
                places[i] += given;
                volumes[i] += chambers.grows[i] * given;
                pressures[i] -= KAPPA * (chambers.grows[i] * given);
            }
            forces = self.pushed(problem, steel, pressures, k);
        }
        let gained = last.flows.map(|flow| over * flow);
        let warmed = last.warmed[0] * chambers.energy[0] + last.warmed[1] * chambers.energy[1];
        let real = from_fn(|i| chambers.pressure[i] * pressures[i]);
        self.rows[k] = row(forces, real, gained, places);
        self.bodies[k] = steel.bodies();
        self.sums[k] = [over * last.fed, over * (HEAT / KAPPA) * warmed];
        let worked: [f64; 2] = from_fn(|i| chambers.energy[i] * (swollen[i] + order * volumes[i]));
        self.works[k] = over * (worked[0] + worked[1]);
        let [v, w] = volumes;
        self.lanes.put(k, SWELLING, [v, w, order * v, order * w], twice(pressures));
        last.forces = forces;
        let masses = from_fn(|i| chambers.over_mass[i] * gained[i]);
        Moved { place: places[0], volumes, pressures, masses }
    }

    /// Adds the highest powers of the motion of rigid bodies, to which the air contributes as far as its series goes.
    #[inline(always)]
    fn go_further(&mut self, bodies: &mut Bodies) {
        for k in ORDER + 1..=HIGH {
            let forces = self.rows.get(k - 1).map_or([0.0; 2], |row| [row[0], row[1]]);
            bodies.go_on(forces, (k - 1, OVER[k - 1]));
            self.bodies[k] = bodies.bodies();
        }
    }

    /// Coefficient `k` of `F_A` and of the force on the bit, for these pressures.
    #[inline(always)]
    fn pushed<E: Expansion>(
        &self,
        problem: &Problem,
        steel: &E,
        pressures: [f64; 2],
        k: usize,
    ) -> [f64; 2] {
        let chambers = &self.chambers;
        let mut pushed = from_fn(|i| chambers.thrust[i] * pressures[i]);
        if !self.is_still {
            let exhaust = problem.outside[1].0[k];
            pushed = from_fn(|i| pushed[i] - chambers.areas[i] * exhaust);
        }
        problem.forces(pushed, steel, k)
    }

    /// Finds coefficient `k` of what flows, after [`Self::go_on`].
    #[inline(always)]
    fn flow_on(&mut self, problem: &Problem, order: Order, moved: &Moved, last: &mut Last) {
        let (k, chambers) = (order.0, &self.chambers);
        let Moved { place, volumes, pressures, masses } = *moved;
        let (mut heats, mut gains) = ([0.0; 2], Gains::default());
        if self.is_leaving {
            let [p, q, ..] = *self.lanes.sums(SWELLING);
            let [m, n, v, w] = *self.lanes.sums(WARMTH);
            let (products, weighed, left) = ([p, q], [m, n], [v, w]);
            heats = from_fn(|i| volumes[i] + pressures[i] + products[i] - (weighed[i] + masses[i]));
            gains.carried = from_fn(|i| left[i] + heats[i] * chambers.outflow[i]);
        }
        let mut outside = [0.0; 2];
        if !self.is_still {
            outside = problem.outside.map(|poly| poly.0[k] / poly.0[0]);
        }
        self.sides = [both(outside, pressures), both([0.0; 2], heats)];
        for stream in &self.streams {
            stream.go_on(&mut self.lanes, order, (&self.sides, place), &mut gains);
        }
        if self.is_leaving {
            let [_, _, outflows @ ..] = gains.flows;
            self.lanes.put(k, WARMTH, twice(heats), both(masses, outflows));
        }
        *last = chambers.gained(&gains, last.forces);
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

/// The larger of two numbers. (The library's function also looks for NaN.)
#[inline(always)]
fn larger(one: f64, other: f64) -> f64 {
    if one > other { one } else { other }
}

#[inline(always)]
fn both([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 4] {
    [a, b, c, d]
}

#[inline(always)]
fn twice(pair: [f64; 2]) -> [f64; 4] {
    both(pair, pair)
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
        // Of the pressures and masses, and of the piston's position.
        let mut weights: Row = from_fn(|i| 1.0 / (first[i] * error));
        (weights[0], weights[1], weights[PLACE], weights[PLACE + 1]) = (0.0, 0.0, 0.0, 0.0);
        if air.openings.as_flattened().contains(&Opening::Partial) {
            weights[PLACE] = 1.0 / (port_height * instant(error));
        }
        let mut length = problem.left.longest;
        for k in [ORDER - 1, ORDER] {
            // The largest ratio of a term to its allowed error if the length is 1 s.
            let parts: Row = from_fn(|i| (self.rows[k][i] * weights[i]).abs());
            if parts.iter().sum::<f64>().is_nan() {
                return 0.0;
            }
            shorten(&mut length, parts.into_iter().fold(0.0, larger), k);
        }
        if let Some(pair) = &problem.steel.pair {
            // What the volumes do not feel at once, they feel later.
            for k in [HIGH - 1, HIGH] {
                let [p, q] = self.bodies[k].map(f64::abs);
                shorten(&mut length, larger(p, q) / (pair.unit * error), k);
            }
        }
        let positive = self.chambers.volume.iter().chain(&first[MASS..PLACE]).all(|x| *x > 0.0);
        if positive && length.is_finite() { length } else { 0.0 }
    }
}

/// Shortens a window so that the largest term, `most` times power `k` of its length, does not exceed what is allowed.
fn shorten(length: &mut f64, most: f64, k: usize) {
    if most * math::powi(*length, k) > 1.0 {
        *length = 1.0 / math::rough_root(most, k as u64);
    }
}

impl Left {
    fn is_soft(&self) -> bool {
        self.gives != [[0.0; 2]; 2]
    }
}
