//! A window of air: its length and its polynomials.
//!
//! The force on the steel is a projection of the force's series on Legendre polynomials of lower degree over
//! the window. The part left out has zero mean and zero first moments over the window.

use super::course::{self, Course};
use super::fit::{PRESSURE, Swept, scale, write};
use super::series::{self, Problem, Series, instant};
use super::{Air, Window, volumes};
use crate::numerics::bernstein::{first_rise, rise_between};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, Powers, value};
use std::array::from_fn;

/// Number of halvings of an interval in the search for a negative value of a function that begins at zero.
const SOON: usize = 20;
/// Largest error that the projection may cause in a force at one instant, over the error allowed of the force's mean;
/// and the share of it that is allowed when a projection of fewer powers is tried.
const LEFT_OUT: f64 = 10.0;
const FEWER: f64 = 0.05;
/// Shortest window, s.
const SHORTEST: f64 = 1e-12;

/// A window. The error names a flow path and the bound of its formula that the flow passes immediately; it is `None` if
/// no window exists.
pub(crate) type Solved = Result<Box<Window>, Option<(usize, usize)>>;

impl Air {
    /// The window that begins at the epoch. `series` and `storage` are reused.
    pub(crate) fn window(
        &self,
        problem: &Problem,
        series: &mut Series,
        storage: &mut Option<Box<Window>>,
    ) -> Solved {
        series::expand(series, self, problem);
        let longest = series.length(self, problem);
        let length = match problem.steel.pair {
            Some(_) => series.whole(longest),
            None => series.projected(problem, longest),
        };
        let length = length.ok_or(None)?;
        let passage = series.passage(self, problem, length);
        if let Some((0.0, path, bound)) = passage {
            return Err(Some((path, bound)));
        }
        let mut window = storage.take().unwrap_or_default();
        window.length = length;
        let drive = &problem.parameters.drive;
        let swept = Swept {
            areas: [drive.area_drive, -drive.area_return],
            dead: volumes(problem.parameters, [0.0; 2]),
            apart: problem.apart,
        };
        let works = problem.steel.pair.map(|_| &series.works);
        write(&mut window, &series.fit, &series.sums, works, swept);
        let flows =
            [2, 3].map(|side| series.streams.iter().any(|stream| stream.sides.contains(&side)));
        window.flows = flows;
        (window.place, window.reach, window.then) = (problem.places, length, None);
        if let Some((tau, path, bound)) = passage {
            window.reach = tau * length;
            window.then = Some((path, self.regimes[path].next(bound)));
        }
        Ok(window)
    }
}

impl Series {
    /// The motion of two rigid bodies in a window of this length.
    pub(crate) fn follow(&self, problem: &Problem, length: f64, course: &mut Course) {
        if let Some(pair) = &problem.steel.pair {
            course::adopt(course, pair, &self.bodies, &self.rows, length);
        }
    }

    /// Scales the series to the longest window.
    fn whole(&mut self, longest: f64) -> Option<f64> {
        scale(&self.rows, longest, None, &mut self.fit);
        Some(longest).filter(|length| *length > SHORTEST)
    }

    /// The forces on piston and bit in a window of this length.
    pub(crate) fn forces(&self, length: f64) -> [Poly; 2] {
        [0, 1].map(|i| Poly::of_part(&self.fit.parts.map(|part| part[i]), length))
    }

    /// Finds a length of at most `longest`, and the series over it with their projections. The part of a force that the
    /// projection leaves out is at most the share `allowed` of the pressures' force at either end. Both ends count,
    /// because a window may be cut short.
    fn projected(&mut self, problem: &Problem, longest: f64) -> Option<f64> {
        let (allowed, drive) = (LEFT_OUT * problem.parameters.air.error, &problem.parameters.drive);
        let [_, _, p, q, ..] = self.rows[0];
        let [push, back] = [p * drive.area_drive, q * drive.area_return];
        let scales = [push + back, back].map(|scale| scale.max(f64::MIN_POSITIVE));
        let small = [scales[0], scales[1], p, q].map(|scale| FEWER * allowed * scale);
        let mut length = longest;
        while length > SHORTEST {
            scale(&self.rows, length, Some(small), &mut self.fit);
            let ends = |i: usize| self.fit.left_out[i] / scales[i];
            let most = ends(0).max(ends(1));
            if most <= allowed {
                return Some(length);
            }
            length *= math::rough_root(0.5 * allowed / most, LOW as u64);
        }
        None
    }

    /// The first time in a window at which a flow passes a bound of its formula by more than the pressures' error, with
    /// the path and the bound.
    fn passage(&self, air: &Air, problem: &Problem, length: f64) -> Option<(f64, usize, usize)> {
        let margin = instant(problem.parameters.air.error);
        let mut first: Option<(f64, usize, usize)> = None;
        let ranges = from_fn::<_, 4, _>(|side| self.range(problem, length, side));
        for stream in &self.streams {
            let regime = air.regimes[stream.path];
            let [high, low] = stream.sides;
            let [high_range, low_range] = [ranges[high], ranges[low]];
            for (bound, level) in regime.bounds().into_iter().enumerate() {
                let sign = if bound == 0 { -1.0 } else { 1.0 };
                // The lower pressure is beyond the regime's bound, a share of the higher one, by at most `most`.
                let level_beyond = level + sign * margin;
                let most = if bound == 0 {
                    level_beyond * high_range[1] - low_range[0]
                } else {
                    low_range[1] - level_beyond * high_range[0]
                };
                if most <= 0.0 {
                    continue;
                }
                let [highs, lows] = [high, low].map(|side| self.powers(problem, length, side));
                let beyond =
                    |level: f64| -> Powers { from_fn(|k| sign * (lows[k] - level * highs[k])) };
                let Some(until) = first_rise(&beyond(level_beyond), 0.0) else { continue };
                let root = last_rise(&beyond(level), until);
                if first.is_none_or(|(earliest, ..)| root < earliest) {
                    first = Some((root, stream.path, bound));
                }
            }
        }
        first
    }

    /// The range of the pressure on a side in a window of this length.
    fn range(&self, problem: &Problem, length: f64, side: usize) -> [f64; 2] {
        if let Some(i) = side.checked_sub(2) {
            return [self.fit.least[PRESSURE + i], self.fit.most[PRESSURE + i]];
        }
        let start = problem.outside[side].0[0];
        if self.is_still {
            return [start; 2];
        }
        let rest = &self.powers(problem, length, side)[1..];
        rest.iter().fold([start; 2], |[least, most], c| [least + c.min(0.0), most + c.max(0.0)])
    }

    /// The series of the pressure on a side, scaled to a window of this length.
    fn powers(&self, problem: &Problem, length: f64, side: usize) -> Powers {
        let Some(i) = side.checked_sub(2) else {
            let mut power = 1.0;
            return from_fn(|k| {
                let scaled = power * problem.outside[side].0[k];
                power *= length;
                scaled
            });
        };
        from_fn(|k| self.fit.rows[k][PRESSURE + i])
    }
}

/// The last point before `until` at which a function that is positive at `until` rises through zero. It is 0 if the
/// function begins at zero and is not negative shortly afterwards.
fn last_rise(q: &Powers, until: f64) -> f64 {
    if q[0] < 0.0 {
        return rise_between(q, [0.0, until], until);
    }
    // A function that begins at zero may fall before it rises.
    let mut nearer = until;
    for _ in 0..SOON {
        nearer *= 0.5;
        if value(q, nearer) < 0.0 {
            return rise_between(q, [nearer, until], until);
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::air::series::{LONGEST, Left};
    use crate::air::steel::Steel;
    use crate::laws::air::{GAS, KAPPA};
    use crate::numerics::series::ORDER;
    use crate::quantities::air::ATMOSPHERE;
    use crate::quantities::parameters::{Parameters, Source};

    /// Largest relative error of mass and entropy in a window, and the window's length, for this `air.error`. A chamber
    /// at 20 bar empties through a choked opening while the piston rests. In closed form mass and entropy fall as
    /// `cooled^-5` and `cooled^-7`, with `cooled = 1 + (kappa - 1) K t / 2`.
    fn emptied(error: f64) -> [f64; 2] {
        let mut parameters = Parameters::default();
        parameters.drive.source = Source::Air;
        // The drive's supply port is open but has no area, so that the chamber starts at the supply's pressure. All
        // other ports are closed.
        let (air, back) = (&mut parameters.air.drive, &mut parameters.air.returning);
        (air.supply, air.exhaust, back.supply, back.exhaust) = (1.0, -1.0, 1.0, -1.0);
        (parameters.air.supply_area, parameters.air.error) = (0.0, error);
        let (law, places) = (parameters.air, [-0.01; 2]);
        let pressures = [2e6, ATMOSPHERE];
        let (mut gas, _) = Air::start(&parameters, places, pressures, 0.0);
        let sides = gas.sides(&parameters, places, pressures, 0.0);
        gas.classify(&parameters, &sides);
        let outside = pressures.map(Poly::constant);
        let problem = Problem {
            parameters: &parameters,
            steel: &Steel::default(),
            apart: false,
            left: Left {
                still: places.map(|x| from_fn(|k| if k == 0 { x } else { 0.0 })),
                longest: LONGEST,
                ..Left::default()
            },
            places,
            outside: outside.each_ref(),
        };
        let window = gas.window(&problem, &mut Series::default(), &mut None).expect("a window");
        let choked = (KAPPA / GAS).sqrt() * (2.0 / (KAPPA + 1.0)).powi(3);
        let [volume, _] = crate::air::volumes(&parameters, places);
        let rate =
            law.discharge * law.exhaust_area * choked * GAS * law.temperature.sqrt() / volume;
        let off = |tau: f64| {
            let cooled = 1.0 + 0.5 * (KAPPA - 1.0) * rate * tau * window.length;
            let content = window.content_at(tau, gas.content);
            let of = |k: usize, power: i32| {
                (content[k] / (gas.content[k] * cooled.powi(-power)) - 1.0).abs()
            };
            of(0, 5).max(of(1, 7))
        };
        [window.length, (1..=20).fold(0.0, |most: f64, i| most.max(off(f64::from(i) / 20.0)))]
    }

    /// If the allowed error grows a thousandfold, the window grows by the `k`th root of a thousand, where `k` is the
    /// order of one of the last two terms. The actual error stays below the allowed one.
    #[test]
    fn a_window_s_length_goes_with_a_root_of_its_error() {
        let [[coarse, off], [fine, fine_off]] = [1e-4, 1e-7].map(emptied);
        let [least, most] = [ORDER, ORDER - 1].map(|k| 1e3f64.powf(1.0 / k as f64));
        let ratio = coarse / fine;
        assert!((0.99 * least..1.01 * most).contains(&ratio), "{ratio} for {least} to {most}");
        assert!(off < 1e-4 && fine_off < 1e-7 && fine_off > 1e-10, "{off:e} {fine_off:e}");
    }
}
