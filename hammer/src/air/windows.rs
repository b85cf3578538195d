//! A window of air: its length and its polynomials.
//!
//! The force on the steel is a projection of the force's series on Legendre polynomials of lower degree over
//! the window. The part left out has zero mean and zero first moments over the window.

use super::series::{Problem, Series, instant};
use super::{Air, ENDS, Window};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::numerics::series::{LOW, ORDER, Powers, projections};
use std::array::from_fn;

/// Samples of a window at which the bounds of a flow's formula are checked.
const LOOKS: usize = 8;
/// Halvings of an interval in search of a negative value of a function that begins at zero.
const SOON: usize = 20;
/// Halvings of an eighth of a window that holds a zero, down to rounding.
const HALVINGS: usize = 50;
/// Largest error of a force at one instant by the projection, over the error asked of its mean; and the share
/// of it that is allowed where a projection of fewer powers is tried.
const LEFT_OUT: f64 = 10.0;
const FEWER: f64 = 0.05;
/// Shortest window, s.
const SHORTEST: f64 = 1e-12;

/// A window, and the forces on piston and bit. The error is a path whose flow passes a bound of its formula at
/// once, with that bound; or none where no window exists.
pub(crate) type Solved = Result<(Window, [Poly; 2]), Option<(usize, usize)>>;

impl Air {
    /// The window that begins at the epoch; `series` is storage.
    pub(crate) fn window(&self, problem: &Problem, series: &mut Series) -> Solved {
        series.solve(self, problem);
        let allowed = LEFT_OUT * problem.parameters.air.error;
        let longest = series.length(self, problem);
        let (length, forces) = series.projected(longest, allowed).ok_or(None)?;
        let powers = |series: &Powers| scaled(series, length);
        let content = series.content.each_ref().map(powers);
        let mut push = [[0.0; ORDER + 1]; 2];
        // `int P' x`: the slopes of the forces times the positions.
        let mut moment = [0.0; ORDER + 1];
        for (i, place) in series.places.iter().map(powers).enumerate() {
            push[i][..LOW].copy_from_slice(&forces[2 + i]);
            for (k, force) in forces[2 + i].iter().enumerate().skip(1) {
                let slope = k as f64 * force;
                moment[k..].iter_mut().zip(place).for_each(|(sum, place)| *sum += slope * place);
            }
        }
        moment.iter_mut().enumerate().skip(1).for_each(|(k, sum)| *sum /= k as f64);
        let sums = [powers(&series.sums[0]), powers(&series.sums[1]), moment];
        let place = problem.places;
        let mut window = Window { length, content, sums, push, place, reach: length, then: None };
        let margin = instant(problem.parameters.air.error);
        if let Some((tau, path, bound)) = series.passage(self, &window, margin) {
            if tau == 0.0 {
                return Err(Some((path, bound)));
            }
            window.reach = tau * length;
            window.then = Some((path, self.regimes[path].next(bound)));
        }
        Ok((window, [0, 1].map(|i| Poly::of_part(&forces[i], length))))
    }
}

impl Series {
    /// A length, `longest` at most, and the projected forces over it. At either end the part left out is at
    /// most the share `allowed` of the pressures' force; both ends count, since a window may be cut short.
    fn projected(&self, longest: f64, allowed: f64) -> Option<(f64, [[f64; LOW]; 4])> {
        let [drag, _, push, back] = self.forces.each_ref().map(|force| force[0].abs());
        let scales = [drag + push + back, back].map(|scale| scale.max(f64::MIN_POSITIVE));
        let small = [scales[0], scales[1], push, back].map(|scale| FEWER * allowed * scale);
        let mut length = longest;
        while length > SHORTEST {
            let whole = side_by_side(&self.forces, length);
            let parts = projections(whole, small);
            let sum = |rows: &[[f64; 4]], i: usize| rows.iter().map(|row| row[i]).sum::<f64>();
            let left = |i: usize| {
                let ends = [whole[0][i] - parts[0][i], sum(&whole, i) - sum(&parts, i)];
                ends[0].abs().max(ends[1].abs()) / scales[i]
            };
            let most = left(0).max(left(1));
            if most <= allowed {
                return Some((length, from_fn(|i| from_fn(|k| parts[k][i]))));
            }
            length *= math::pow(0.5 * allowed / most, 1.0 / LOW as f64);
        }
        None
    }

    /// The first time in a window at which a flow passes a bound of its formula, with the path and the bound.
    fn passage(&self, air: &Air, window: &Window, margin: f64) -> Option<(f64, usize, usize)> {
        let rows = side_by_side(&self.pressures, window.length);
        let at = |tau: f64| {
            let each = rows.iter().rev();
            each.fold([0.0; 4], |sum, row| from_fn(|i| sum[i] * tau + row[i]))
        };
        let sampled: [[f64; 4]; LOOKS + 1] = from_fn(|i| at(i as f64 / LOOKS as f64));
        let mut first: Option<(f64, usize, usize)> = None;
        for stream in &self.streams {
            let [one, other] = ENDS[stream.path];
            let beyond = |p: &[f64; 4]| air.regimes[stream.path].beyond([p[one], p[other]]);
            let values = sampled.each_ref().map(beyond);
            for bound in 0..2 {
                let passed = |tau: f64| beyond(&at(tau))[bound];
                let values = values.map(|both| both[bound]);
                let Some([before, after]) = risen(&values, margin, passed) else { continue };
                let root = root(before, after, passed);
                if first.is_none_or(|(earliest, ..)| root < earliest) {
                    first = Some((root, stream.path, bound));
                }
            }
        }
        first
    }
}

/// The same series, in powers of time over the window's length.
fn scaled(series: &Powers, length: f64) -> Powers {
    let mut power = 1.0;
    series.map(|c| {
        let scaled = c * power;
        power *= length;
        scaled
    })
}

/// The same of several series, power by power.
fn side_by_side(series: &[Powers; 4], length: f64) -> [[f64; 4]; ORDER + 1] {
    let all = series.each_ref().map(|series| scaled(series, length));
    from_fn(|k| from_fn(|i| all[i][k]))
}

/// The first interval at whose end a sampled function exceeds `margin`. A peak between samples is estimated by
/// the parabola through three values.
fn risen(
    values: &[f64; LOOKS + 1],
    margin: f64,
    function: impl Fn(f64) -> f64,
) -> Option<[f64; 2]> {
    let place = |i: f64| i / LOOKS as f64;
    for i in 1..=LOOKS {
        let [before, here] = [i - 1, i].map(|i| place(i as f64));
        if values[i] > margin {
            return Some([before, here]);
        }
        let Some(&next) = values.get(i + 1) else { continue };
        let (rise, fall) = (values[i] - values[i - 1], values[i] - next);
        if rise >= 0.0 && fall >= 0.0 && rise + fall > 0.0 {
            let peak = place(i as f64 + 0.5 * (rise - fall) / (rise + fall));
            if function(peak) > margin {
                return Some([before, peak]);
            }
        }
    }
    None
}

/// Where a function crosses zero upward between two places; `first`, if it is nowhere negative close behind it.
fn root(first: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    // A function that begins at zero may fall before it rises.
    let nearer = (1..=SOON).map(|k| first + math::powi(0.5, k) * (high - first));
    let below = std::iter::once(first).chain(nearer).find(|&place| function(place) < 0.0);
    let Some(mut low) = below else { return first };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::air::series::{LONGEST, Left};
    use crate::laws::air::{GAS, KAPPA};
    use crate::numerics::series::value;
    use crate::quantities::air::ATMOSPHERE;
    use crate::quantities::parameters::{Parameters, Source};

    /// Largest relative error of mass and entropy in a window, and the window's length, for this `air.error`. A
    /// chamber at 20 bar empties through a choked opening while the piston rests. In closed form, with
    /// `cooled = 1 + (kappa - 1) K t / 2`, mass and entropy fall as its powers -5 and -7.
    fn emptied(error: f64) -> [f64; 2] {
        let mut parameters = Parameters::default();
        parameters.drive.source = Source::Air;
        // The drive's supply port is open without area, so that the chamber starts at the supply's pressure.
        // All else is closed.
        let (air, back) = (&mut parameters.air.drive, &mut parameters.air.returning);
        (air.supply, air.exhaust, back.supply, back.exhaust) = (1.0, -1.0, 1.0, -1.0);
        (parameters.air.supply_area, parameters.air.error) = (0.0, error);
        let (law, places) = (parameters.air, [-0.01; 2]);
        let pressures = [2e6, ATMOSPHERE];
        let (mut gas, _) = Air::start(&parameters, places, pressures, 0.0);
        gas.classify(&parameters, places, pressures);
        let outside = pressures.map(Poly::constant);
        let problem = Problem {
            parameters: &parameters,
            blocks: Vec::new(),
            left: Left {
                still: places.map(|x| from_fn(|k| if k == 0 { x } else { 0.0 })),
                longest: LONGEST,
                ..Left::default()
            },
            places,
            outside,
        };
        let (window, _) = gas.window(&problem, &mut Series::default()).expect("a window");
        let choked = (KAPPA / GAS).sqrt() * (2.0 / (KAPPA + 1.0)).powi(3);
        let [volume, _] = crate::air::volumes(&parameters, places);
        let rate =
            law.discharge * law.exhaust_area * choked * GAS * law.temperature.sqrt() / volume;
        let off = |tau: f64| {
            let cooled = 1.0 + 0.5 * (KAPPA - 1.0) * rate * tau * window.length;
            let of = |k: usize, power: i32| {
                (value(&window.content[k], tau) / (gas.content[k] * cooled.powi(-power)) - 1.0)
                    .abs()
            };
            of(0, 5).max(of(1, 7))
        };
        [window.length, (1..=20).fold(0.0, |most: f64, i| most.max(off(f64::from(i) / 20.0)))]
    }

    /// If the error allowed grows a thousandfold, the window grows by the `k`th root of a thousand, `k` being
    /// the order of one of the last two terms; and the error asked is not exceeded.
    #[test]
    fn a_window_s_length_goes_with_a_root_of_its_error() {
        let [[coarse, off], [fine, fine_off]] = [1e-4, 1e-7].map(emptied);
        let [least, most] = [ORDER, ORDER - 1].map(|k| 1e3f64.powf(1.0 / k as f64));
        let ratio = coarse / fine;
        assert!((0.99 * least..1.01 * most).contains(&ratio), "{ratio} for {least} to {most}");
        assert!(off < 1e-4 && fine_off < 1e-7 && fine_off > 1e-10, "{off:e} {fine_off:e}");
    }
}
