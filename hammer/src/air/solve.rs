//! The air of one window, by Gauss's collocation together with the piston's mean motion.
//!
//! The steel's motion is given at the nodes, as it is under forces that are guessed. Where the air's
//! forces differ from the guess, the bodies move as free ones do; the guess is then replaced, and the
//! steel moved anew, until both agree ([`Problem::misfit`]), or where what the forces were off cannot
//! matter ([`Problem::is_trifle`]). The rates of the content at the nodes follow by Newton's method, from
//! those that the window before goes on to, with a matrix of each chamber, in which the entropy does not
//! depend on the mass: that leaves one small system for each.
//!
//! Error: what the last Legendre term adds. Of the content all of it counts. What a projection leaves out
//! of the force has no mean, so that it moves the piston by a part `(h/T)^2` of what the force itself
//! does in the time `T` of a stroke.

use super::newton::{Factors, Newton, Triangles};
use super::problem::{Problem, Solved, Steel};
use super::{Air, Content, PATHS, Past, Places, Sides, Window, flows, gains, volumes};
use crate::laws::air::{GAS, KAPPA, Regime};
use crate::numerics::collocation::{Nodal, Powers, Rule, STAGES, dot, slope, value};
use crate::numerics::poly::Poly;
use crate::quantities::parameters::Parameters;
use std::array::from_fn;

/// Iterations of Newton's method, and of the piston's motion.
const MOST: usize = 24;
/// The node in the middle.
const MIDDLE: usize = STAGES / 2;
/// They end where a step is below this part of the error allowed.
const SMALL: f64 = 1e-2;
/// Step of the differences in the matrix, relative.
const STEP: f64 = 1e-6;
/// The pressures' part beyond a bound of a formula that still counts as within.
pub(super) const WITHIN: f64 = 1e-12;
/// A flow keeps its formula up to so far beyond its bounds.
const KEPT: f64 = 1e-9;
/// Heat of air at constant pressure, J/(kg K).
const HEAT: f64 = KAPPA * GAS / (KAPPA - 1.0);

/// What the air at one node gives.
struct Instant {
    rates: [f64; 4],
    forces: [f64; 2],
    sums: [f64; 4],
}

impl Air {
    /// Puts every flow on the formula of the present pressures; one beside a bound keeps what it has.
    pub(crate) fn classify(&mut self, parameters: &Parameters, places: Places, outside: [f64; 2]) {
        let volumes = volumes(parameters, places);
        let sides = Sides::new(&parameters.air, outside, &self.content, volumes);
        for path in 0..PATHS {
            let pressures = sides.pressures(path);
            let regime = &mut self.regimes[path];
            if regime.beyond(pressures).iter().any(|beyond| *beyond > KEPT) {
                *regime = Regime::of(pressures);
            }
        }
    }

    fn instant(
        &self,
        problem: &Problem,
        content: &Content,
        outside: [f64; 2],
        [places, speeds]: [Places; 2],
    ) -> Option<Instant> {
        let parameters = problem.parameters;
        let (law, drive) = (&parameters.air, &parameters.drive);
        let volumes = volumes(parameters, places);
        if !volumes.iter().chain(content).all(|x| *x > 0.0) {
            return None;
        }
        let sides = Sides::new(law, outside, content, volumes);
        let flows = flows(&self.regimes, &law.areas(&self.openings, places[0]), &sides);
        let [heats, gained] = gains(&flows);
        let rates = from_fn(|k| {
            let own = self.content[k];
            match k % 2 {
                0 => gained[k / 2] / own,
                _ => KAPPA * GAS * sides.heated[k / 2] * heats[k / 2] / own,
            }
        });
        let [driving, returning] = sides.chambers.map(|side| side[0]);
        let beyond = returning - outside[1];
        let force = (driving - outside[1]) * drive.area_drive
            - beyond * drive.area_return
            - law.drag * speeds[0];
        let taken = flows[0][0] + flows[2][0];
        let carried = |path: usize| flows[path][0] * flows[path][1];
        let enthalpy = HEAT * (carried(0) + carried(2) - carried(1) - carried(3));
        let push = [driving * drive.area_drive, -returning * drive.area_return];
        Some(Instant {
            rates,
            forces: [force, beyond * drive.area_return],
            sums: [taken, enthalpy, push[0], push[1]],
        })
    }

    /// The forces at the epoch, N.
    pub(crate) fn forces(&self, problem: &Problem, motion: [Places; 2]) -> Option<[f64; 2]> {
        let outside = problem.outside.each_ref().map(|poly| poly.0[0]);
        Some(self.instant(problem, &self.content, outside, motion)?.forces)
    }

    /// The rates that the window before goes on to; zero if it says nothing that can be.
    pub(crate) fn guess(&self, span: f64) -> Newton {
        Newton { rates: self.rates_beyond(span), factors: None, iterations: 0 }
    }

    fn rates_beyond(&self, span: f64) -> [Nodal; 4] {
        let Some(past) = &self.past else { return Default::default() };
        let at = |node: f64| (past.since + span * node) / past.length;
        let nodes = Rule::get().nodes.map(at);
        let possible = |content: &_| nodes.iter().all(|tau| value(content, *tau) > 0.0);
        if !past.content.iter().all(|content| possible(content)) {
            return Default::default();
        }
        from_fn(|k| nodes.map(|tau| slope(&past.content[k], tau) / (past.length * self.content[k])))
    }

    /// The content of a solution, as that of a window before it.
    pub(crate) fn past(&self, problem: &Problem, solved: &Solved) -> Past {
        let content = self.powers(problem.span, &solved.rates);
        Past { since: 0.0, length: problem.span, content }
    }

    fn powers(&self, span: f64, rates: &[Nodal; 4]) -> [Powers; 4] {
        from_fn(|k| Rule::get().integral(self.content[k], span * self.content[k], &rates[k]))
    }

    /// The window's air with the piston moving like this; none if the iteration does not converge.
    pub(crate) fn solve(
        &self,
        problem: &Problem,
        steel: &Steel,
        newton: &mut Newton,
    ) -> Option<Solved> {
        let (rule, span, law) = (Rule::get(), problem.span, &problem.parameters.air);
        let outside: [[f64; 2]; STAGES] = from_fn(|i| {
            let t = span * rule.nodes[i];
            problem.outside.each_ref().map(|poly| poly.at(t))
        });
        let small = SMALL * law.error;
        let mut solved = Solved {
            rates: newton.rates,
            place: steel.place,
            speed: steel.speed,
            forces: steel.forces,
            sums: [[0.0; STAGES]; 4],
            error: 0.0,
        };
        for _ in 0..MOST {
            newton.iterations += 1;
            let pushed = problem.pushed(&solved, steel);
            let (mut misfit, mut change) = ([[0.0; STAGES]; 4], 0.0f64);
            for i in 0..STAGES {
                let places: Places =
                    from_fn(|k| steel.place[k][i] + span * span * dot(&rule.twice[i], &pushed[k]));
                let speeds = from_fn(|k| steel.speed[k][i] + span * dot(&rule.once[i], &pushed[k]));
                let by = from_fn(|k| places[k] - solved.place[k][i]);
                change = change.max(problem.stir(places, by));
                for k in 0..2 {
                    (solved.place[k][i], solved.speed[k][i]) = (places[k], speeds[k]);
                }
                let motion = [places, speeds];
                let content = self.content_of(&solved, span, i);
                let now = self.instant(problem, &content, outside[i], motion)?;
                for ((off, rate), now) in misfit.iter_mut().zip(&solved.rates).zip(now.rates) {
                    off[i] = now - rate[i];
                    change = change.max(span * off[i].abs());
                }
                (solved.forces[0][i], solved.forces[1][i]) = (now.forces[0], now.forces[1]);
                (0..4).for_each(|k| solved.sums[k][i] = now.sums[k]);
            }
            // What the newest forces would still move the piston by.
            let again = problem.pushed(&solved, steel);
            for i in 0..STAGES {
                let off = |k: usize| -> Nodal { from_fn(|j| again[k][j] - pushed[k][j]) };
                let by = from_fn(|k| span * span * dot(&rule.twice[i], &off(k)));
                change = change.max(problem.stir(from_fn(|k| solved.place[k][i]), by));
            }
            if change <= small {
                newton.rates = solved.rates;
                solved.error = problem.error(&solved);
                return solved.error.is_finite().then_some(solved);
            }
            if !change.is_finite() {
                return None;
            }
            let factors = match &mut newton.factors {
                Some(factors) => factors,
                none => {
                    let content = self.content_of(&solved, span, MIDDLE);
                    let motion =
                        [&solved.place, &solved.speed].map(|way| way.map(|nodes| nodes[MIDDLE]));
                    none.insert(self.factors(problem, &content, outside[MIDDLE], motion)?)
                }
            };
            for (chamber, factors) in factors.iter().enumerate() {
                let rows = 2 * chamber;
                let [first, second] = [misfit[rows], misfit[rows + 1]];
                let step = match factors {
                    Some(factors) => factors.solve(&first, &second),
                    None => [first, second],
                };
                for (rates, step) in solved.rates[rows..].iter_mut().zip(&step) {
                    rates.iter_mut().zip(step).for_each(|(rate, step)| *rate += step);
                }
            }
        }
        None
    }

    fn content_of(&self, solved: &Solved, span: f64, node: usize) -> Content {
        let share = &Rule::get().once[node];
        from_fn(|k| self.content[k] * (1.0 + span * dot(share, &solved.rates[k])))
    }

    /// The matrices of Newton's method where the content is this, factorised; none for a chamber whose
    /// openings are shut. (Through open ones nothing may flow either, between equal pressures.)
    fn factors(
        &self,
        problem: &Problem,
        content: &Content,
        outside: [f64; 2],
        motion: [Places; 2],
    ) -> Option<[Option<Factors>; 2]> {
        let base = self.instant(problem, content, outside, motion)?.rates;
        // By the masses, then by the entropies of both chambers; a leak couples them little.
        let mut slopes = [[0.0; 4]; 2];
        for (column, slopes) in slopes.iter_mut().enumerate() {
            let mut moved = *content;
            [column, column + 2].iter().for_each(|k| moved[*k] *= 1.0 + STEP);
            let rates = self.instant(problem, &moved, outside, motion)?.rates;
            *slopes = from_fn(|k| {
                let by = STEP * content[k / 2 * 2 + column] / self.content[k / 2 * 2 + column];
                (rates[k] - base[k]) / by
            });
        }
        let mut factors = [None, None];
        for (chamber, factors) in factors.iter_mut().enumerate() {
            let rows = 2 * chamber;
            let [by_mass, by_entropy] = slopes;
            let all = by_mass[rows..rows + 2].iter().chain(&by_entropy[rows..rows + 2]);
            if all.into_iter().all(|slope| *slope == 0.0) {
                continue;
            }
            *factors = Some(Factors {
                mass: Triangles::new(problem.span * by_mass[rows])?,
                entropy: Triangles::new(problem.span * by_entropy[rows + 1])?,
                cross: problem.span * by_entropy[rows],
            });
        }
        Some(factors)
    }

    /// The window that these nodes are of, and the first place where a flow passes to another formula: the
    /// path and the formula beyond. An error is one that does so at once.
    pub(crate) fn window(
        &self,
        problem: &Problem,
        solved: &Solved,
        place: Places,
    ) -> Result<Window, (usize, usize)> {
        let (rule, span) = (Rule::get(), problem.span);
        let content = self.powers(span, &solved.rates);
        let [taken, enthalpy, pushes @ ..] = &solved.sums;
        let push: [Powers; 2] = from_fn(|i| {
            let projection = rule.projection(&pushes[i]);
            from_fn(|k| projection.get(k).copied().unwrap_or_default())
        });
        let moment = from_fn(|i| {
            let part = |k: usize| slope(&push[k], rule.nodes[i]) * solved.place[k][i];
            part(0) + part(1)
        });
        let sums = [(span, taken), (span, enthalpy), (1.0, &moment)]
            .map(|(factor, values)| rule.integral(0.0, factor, values));
        let (length, reach, then) = (span, span, None);
        let mut window = Window { length, content, sums, push, place, reach, then };
        let places: [Powers; 2] = from_fn(|k| rule.integral(place[k], span, &solved.speed[k]));
        let at = |tau: f64| {
            let now: Content = from_fn(|k| value(&window.content[k], tau));
            let outside = problem.outside.each_ref().map(|poly| poly.at(tau * span));
            let volumes = volumes(problem.parameters, from_fn(|k| value(&places[k], tau)));
            Sides::new(&problem.parameters.air, outside, &now, volumes)
        };
        let areas = problem.parameters.air.areas(&self.openings, solved.place[0][MIDDLE]);
        let mut first: Option<(f64, usize, usize)> = None;
        let sampled: [(f64, Sides); STAGES + 1] = from_fn(|i| {
            let tau = rule.nodes.get(i).copied().unwrap_or(1.0);
            (tau, at(tau))
        });
        for path in (0..PATHS).filter(|path| areas[*path] != 0.0) {
            let beyond = |sides: &Sides| self.regimes[path].beyond(sides.pressures(path));
            for bound in 0..2 {
                let mut before = 0.0;
                for (tau, sides) in &sampled {
                    if beyond(sides)[bound] > WITHIN {
                        let root = root(before, *tau, |tau| beyond(&at(tau))[bound]);
                        if root == 0.0 {
                            return Err((path, bound));
                        }
                        if first.is_none_or(|(earliest, ..)| root < earliest) {
                            first = Some((root, path, bound));
                        }
                        break;
                    }
                    before = *tau;
                }
            }
        }
        if let Some((tau, path, bound)) = first {
            window.reach = tau * span;
            window.then = Some((path, self.regimes[path].next(bound)));
        }
        Ok(window)
    }
}

/// Where a function passes zero upward between two places; the first, if it is not below zero there.
fn root(low: f64, high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ([low, function(low)], [high, function(high)]);
    if low[1] >= 0.0 {
        return low[0];
    }
    for step in 0..100 {
        // Regula falsi, halved where it keeps one end for long.
        let middle = if step % 3 == 2 {
            0.5 * (low[0] + high[0])
        } else {
            low[0] - low[1] * (high[0] - low[0]) / (high[1] - low[1])
        };
        if !(middle > low[0] && middle < high[0]) || high[0] - low[0] < 1e-14 {
            break;
        }
        let found = function(middle);
        if found < 0.0 {
            low = [middle, found]
        } else {
            high = [middle, found]
        }
        if found == 0.0 {
            break;
        }
    }
    high[0]
}

/// A polynomial of time from what is known at the nodes of a window.
pub(crate) fn polynomial(values: &Nodal, span: f64) -> Poly {
    let mut poly = Poly::default();
    let mut power = 1.0;
    for (c, p) in poly.0.iter_mut().zip(Rule::get().projection(values)) {
        *c = p / power;
        power *= span;
    }
    poly
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::air::ATMOSPHERE;
    use crate::quantities::parameters::Source;

    /// A chamber at 20 bar that empties for `span` through a choked opening, the piston at rest: the largest
    /// error of its mass and of its entropy inside the window, and that at its end. In closed form, with
    /// `cooled = 1 + (kappa - 1) K t / 2`, they fall as its powers -5 and -7.
    fn errors(span: f64) -> [f64; 2] {
        let mut parameters = Parameters::default();
        parameters.drive.source = Source::Air;
        // Its supply is open, with no area, so that it starts at the supply's pressure; nothing else is.
        let (air, back) = (&mut parameters.air.drive, &mut parameters.air.returning);
        (air.supply, air.exhaust, back.supply, back.exhaust) = (1.0, -1.0, 1.0, -1.0);
        (parameters.air.supply_area, back.exhaust) = (0.0, -1.0);
        parameters.air.error = 1e-11; // Newton's method goes on to 1e-13.
        let (law, place) = (parameters.air, -0.01);
        let pressures = [2e6, ATMOSPHERE];
        let mut gas = Air::start(&parameters, [place; 2], pressures);
        gas.classify(&parameters, [place; 2], pressures);
        let outside = pressures.map(Poly::constant);
        let (mass, none) = (1e12, [0.0; 2]);
        let (gains, tied) = ([none; 2], [none; 2]);
        let problem = Problem { parameters: &parameters, mass, gains, tied, outside, span };
        let still = [[0.0; STAGES]; 2];
        let steel = Steel { place: [[place; STAGES]; 2], speed: still, forces: still };
        let solved = gas.solve(&problem, &steel, &mut gas.guess(span)).expect("a solution");
        let content = gas.powers(span, &solved.rates);
        let choked = (KAPPA / GAS).sqrt() * (2.0 / (KAPPA + 1.0)).powi(3);
        let [volume, _] = volumes(&parameters, [place; 2]);
        let rate =
            law.discharge * law.exhaust_area * choked * GAS * law.temperature.sqrt() / volume;
        let off = |tau: f64| {
            let cooled = 1.0 + 0.5 * (KAPPA - 1.0) * rate * tau * span;
            let of = |k: usize, power: i32| {
                (value(&content[k], tau) / (gas.content[k] * cooled.powi(-power)) - 1.0).abs()
            };
            of(0, 5).max(of(1, 7))
        };
        [(1..20).fold(0.0, |most: f64, i| most.max(off(f64::from(i) / 20.0))), off(1.0)]
    }

    /// Rates that are a polynomial of degree 6 are off by the seventh power of the length, their integral by
    /// the eighth inside a window; at its end, where Gauss's nodes integrate two degrees for one, by the
    /// fifteenth.
    #[test]
    fn halving_a_window_divides_its_error_by_256_inside() {
        let [[coarse, end], [fine, fine_end]] = [6.4e-3, 3.2e-3].map(errors);
        let order = (coarse / fine).log2();
        assert!((7.3..8.3).contains(&order), "{coarse:e} {fine:e}: order {order}");
        assert!(end < 1e-2 * coarse && fine_end < 1e-4 * fine, "{end:e} {fine_end:e}");
    }
}
