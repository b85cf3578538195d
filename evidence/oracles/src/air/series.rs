//! Power series of the air about one instant.

use super::{Air, Content, Flow, Formula, GAS, KAPPA, STRAIGHT, Side, Width, choked, jet, side};
use crate::crossing::{Outcome, Zero, scan};
use crate::linear::Real;
use crate::powers::{power, quotient, raised};
use crate::taylor::product;

/// A pressure ratio must be beyond a formula's bound by this much before the next formula is used: nothing depends on
/// less, since both agree there.
const BEYOND: f64 = 1e-24;

/// Series of a flow's factors. Factors that its formula lacks stay empty.
#[derive(Clone, Debug, Default)]
struct Path<T> {
    share: Vec<T>,
    ratio: Vec<T>,
    root: Vec<T>,
    square: Vec<T>,
    jet: Vec<T>,
    shape: Vec<T>,
    slow: Vec<T>,
    wide: Vec<T>,
    flow: Vec<T>,
}

/// The air's series about one instant.
#[derive(Clone, Debug)]
pub struct AirSeries<T> {
    air: Air<T>,
    anvil: f64,
    place: Vec<T>,
    /// Rates of `x` and `y`.
    speeds: [Vec<T>; 2],
    volumes: [Vec<T>; 2],
    pressures: [Vec<T>; 2],
    temperatures: [Vec<T>; 2],
    paths: [Path<T>; 5],
    /// Masses, internal energies, and the mass taken from the supply.
    pub content: [Vec<T>; 5],
}

impl<T: Real> AirSeries<T> {
    /// The series about a content of the chambers.
    pub fn new(air: Air<T>, anvil: f64, content: &Content<T>) -> Self {
        Self {
            air,
            anvil,
            place: Vec::new(),
            speeds: Default::default(),
            volumes: Default::default(),
            pressures: Default::default(),
            temperatures: Default::default(),
            paths: Default::default(),
            content: content.map(|x| vec![x]),
        }
    }

    /// Adds coefficient `k` of the positions `x` and `y` and of their rates, and the next one of the content; `step`
    /// is the unit of time over `k + 1`. Returns the coefficients of the drive's forces on piston and struck body.
    pub fn grow(&mut self, places: [T; 2], speeds: [T; 2], step: T) -> [T; 2] {
        let k = self.place.len();
        self.place.push(places[0]);
        self.speeds.iter_mut().zip(speeds).for_each(|(row, speed)| row.push(speed));
        if self.air.is_open() {
            self.content.iter_mut().for_each(|row| row.push(T::default()));
            return [T::default(); 2];
        }
        let factor = T::from(KAPPA) - T::from(1.0);
        let law = self.air.law;
        let volumes = match k {
            0 => self.air.volumes(places),
            _ => [T::from(law.areas[0]) * places[0], -(T::from(law.areas[1]) * places[1])],
        };
        for (i, volume) in volumes.into_iter().enumerate() {
            self.volumes[i].push(volume);
            let work = factor * self.content[2 * i + 1][k];
            let pressure = quotient(work, &self.volumes[i], &self.pressures[i], k);
            self.pressures[i].push(pressure);
            let heat = work / T::from(GAS);
            let temperature = quotient(heat, &self.content[2 * i], &self.temperatures[i], k);
            self.temperatures[i].push(temperature);
        }
        let mut gains = [T::default(); 5];
        for path in 0..5 {
            let Some([flow, heat]) = self.flow(path, k) else { continue };
            let energy = T::from(KAPPA) * T::from(GAS) / factor * heat;
            let [one, other] = self.air.sides(path);
            for (side, sign) in [(one, -1.0), (other, 1.0)] {
                let sign = T::from(sign);
                match side {
                    Side::Chamber(i) => {
                        gains[2 * i] = gains[2 * i] + sign * flow;
                        gains[2 * i + 1] = gains[2 * i + 1] + sign * energy;
                    }
                    Side::Outside(0) => gains[4] = gains[4] + flow,
                    Side::Outside(_) => {}
                }
            }
        }
        for (i, area) in [law.areas[0], -law.areas[1]].into_iter().enumerate() {
            let work = T::from(area) * product(&self.pressures[i], &self.speeds[i], k);
            gains[2 * i + 1] = gains[2 * i + 1] - work;
        }
        for (row, gain) in self.content.iter_mut().zip(gains) {
            row.push(gain * step);
        }
        let pressures = [0, 1].map(|i| T::from(1.0 + law.off[i]) * self.pressures[i][k]);
        self.air.forces(self.anvil, pressures, speeds[0], self.outside(1, k))
    }

    /// Coefficient `k` of the pressure of supply or exhaust.
    fn outside(&self, which: usize, k: usize) -> T {
        self.air.outside[which].get(k).copied().unwrap_or_default()
    }

    /// Coefficient `k` of pressure and temperature on a side.
    fn side(&self, side: Side, k: usize) -> [T; 2] {
        let law = &self.air.law;
        match side {
            Side::Chamber(i) => [self.pressures[i][k], self.temperatures[i][k]],
            Side::Outside(i) if k == 0 => [self.outside(i, 0), T::from(law.temperature)],
            Side::Outside(i) => [self.outside(i, k), T::default()],
        }
    }

    /// Coefficient `k` of a flow from its first side to its second, and of its product with the upstream temperature;
    /// none if the path is shut.
    fn flow(&mut self, path: usize, k: usize) -> Option<[T; 2]> {
        let (area, width) = self.air.path(path);
        if area == 0.0 || width == Width::Shut {
            return None;
        }
        let Flow { formula, reversed } = self.air.flows[path];
        let [one, other] = self.air.sides(path);
        let (high, low, sign) = if reversed { (other, one, -1.0) } else { (one, other, 1.0) };
        let up: Vec<[T; 2]> = (0..=k).map(|i| self.side(high, i)).collect();
        let (pressure, hot): (Vec<T>, Vec<T>) = up.into_iter().map(|[p, t]| (p, t)).unzip();
        let [below, _] = self.side(low, k);
        let share = match width {
            Width::Part => {
                let (chamber, port) = (path / 2, path % 2);
                let edge = if k == 0 { self.air.law.edges[chamber][port] } else { 0.0 };
                T::from(side(chamber, port)) * (self.place[k] - T::from(edge))
                    / T::from(self.air.law.height)
            }
            _ if k == 0 => T::from(1.0),
            _ => T::default(),
        };
        let list = &mut self.paths[path];
        list.share.push(share);
        let straight = T::from(STRAIGHT);
        let shape = match formula {
            Formula::Straight => jet(straight) / (T::from(1.0) - straight) * (pressure[k] - below),
            Formula::Choked => jet(choked::<T>()) * pressure[k],
            Formula::Subsonic => {
                let ratio = quotient(below, &pressure, &list.ratio, k);
                list.ratio.push(ratio);
                let root = power(&list.ratio, &list.root, (5, 7), k);
                list.root.push(root);
                let square =
                    product(&list.root, &list.root, k) - product(&list.root, &list.ratio, k);
                list.square.push(square);
                let jet = power(&list.square, &list.jet, (1, 2), k);
                list.jet.push(jet);
                product(&pressure, &list.jet, k)
            }
        };
        list.shape.push(shape);
        let slow = power(&hot, &list.slow, (-1, 2), k);
        list.slow.push(slow);
        let wide = product(&list.share, &list.shape, k);
        list.wide.push(wide);
        let kappa = T::from(KAPPA);
        let square = T::from(2.0) * kappa / ((kappa - T::from(1.0)) * T::from(GAS));
        let factor = T::from(sign * area) * raised(square, (1, 2));
        let flow = factor * product(&list.wide, &list.slow, k);
        list.flow.push(flow);
        Some([flow, product(&list.flow, &hot, k)])
    }

    /// When a flow first changes its formula, in units of time up to `end`, with the flow and the new formula.
    pub fn change(&self, end: f64) -> Option<(T, (usize, Flow))> {
        let mut first: Option<(T, (usize, Flow))> = None;
        for path in 0..5 {
            let (area, width) = self.air.path(path);
            if area == 0.0 || width == Width::Shut || self.air.is_open() {
                continue;
            }
            for (c, next) in self.bounds(path) {
                let height = BEYOND * self.air.law.outside[0].max(self.air.law.outside[1]);
                if let Outcome::Crossed(Zero::At(x)) = scan(&c, end, height, false)
                    && first.as_ref().is_none_or(|(least, _)| x < *least)
                {
                    first = Some((x, (path, next)));
                }
            }
        }
        first
    }

    /// Functions that are negative while a flow keeps its formula, each with the formula beyond it.
    fn bounds(&self, path: usize) -> Vec<(Vec<T>, Flow)> {
        let flow = self.air.flows[path];
        let [one, other] = self.air.sides(path);
        let (high, low) = if flow.reversed { (other, one) } else { (one, other) };
        let (straight, choked) = (T::from(STRAIGHT), choked::<T>());
        let bound = |[of_high, of_low]: [T; 2], formula, turns: bool| {
            let terms = (0..self.place.len())
                .map(|k| of_high * self.side(high, k)[0] + of_low * self.side(low, k)[0]);
            (terms.collect(), Flow { formula, reversed: flow.reversed ^ turns })
        };
        let one = T::from(1.0);
        match flow.formula {
            Formula::Straight => vec![
                bound([straight, -one], Formula::Subsonic, false),
                bound([-one, one], Formula::Straight, true),
            ],
            Formula::Subsonic => vec![
                bound([choked, -one], Formula::Choked, false),
                bound([-straight, one], Formula::Straight, false),
            ],
            Formula::Choked => vec![bound([-choked, one], Formula::Subsonic, false)],
        }
    }
}
