//! The air of one window, by Gauss's collocation together with the piston's mean motion.
//!
//! The steel's motion is given at the nodes, as it is under forces that are guessed. Where the air's
//! forces differ from the guess, the piston moves as its mass does; the guess is then replaced, and the
//! steel moved anew, until both agree ([`Problem::misfit`]). The rates of the content at the nodes follow by
//! Newton's method with one matrix for each chamber.
//!
//! Error: what the last Legendre term adds. Of the content all of it counts. What a projection leaves out
//! of the force has no mean, so that it moves the piston by a part `(h/T)^2` of what the force itself
//! does in the time `T` of a stroke.

use super::{Air, Content, PATHS, Sides, Window, flows, gains, volumes};
use crate::laws::air::{GAS, KAPPA, Regime};
use crate::numerics::collocation::{Nodal, Rule, STAGES, dot, value};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::quantities::parameters::Parameters;
use std::array::from_fn;

/// Iterations of Newton's method, and of the piston's motion.
const MOST: usize = 24;
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
/// Rows of a chamber's matrix.
const ROWS: usize = 2 * STAGES;

/// What a window is solved from.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    pub parameters: &'a Parameters,
    /// The piston's mass, kg.
    pub mass: f64,
    /// Pressures of supply and exhaust after the epoch.
    pub outside: [Poly; 2],
    /// Length, s.
    pub span: f64,
}

/// The piston's relative position and velocity at the nodes, under these forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steel {
    pub place: Nodal,
    pub speed: Nodal,
    pub force: Nodal,
}

/// The air of a window, at the nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solved {
    /// Rates of the content, relative to that at the epoch, 1/s.
    rates: [Nodal; 4],
    pub place: Nodal,
    pub speed: Nodal,
    /// `F_A`, and of the return chamber on the bit, N.
    pub forces: [Nodal; 2],
    /// Flow from the supply, enthalpy that comes in, and the force of the pressures alone.
    sums: [Nodal; 3],
    /// The error over that allowed.
    pub error: f64,
}

/// What the air at one node gives.
struct Instant {
    rates: [f64; 4],
    forces: [f64; 2],
    sums: [f64; 3],
}

impl Air {
    /// Puts every flow on the formula of the present pressures; one beside a bound keeps what it has.
    pub(crate) fn classify(&mut self, parameters: &Parameters, vr: f64, outside: [f64; 2]) {
        let sides = Sides::new(&parameters.air, outside, &self.content, volumes(parameters, vr));
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
        [place, speed]: [f64; 2],
    ) -> Option<Instant> {
        let parameters = problem.parameters;
        let (law, drive) = (&parameters.air, &parameters.drive);
        let volumes = volumes(parameters, place);
        if !volumes.iter().chain(content).all(|x| *x > 0.0) {
            return None;
        }
        let sides = Sides::new(law, outside, content, volumes);
        let flows = flows(&self.regimes, &law.areas(&self.openings, place), &sides);
        let [heats, gained] = gains(&flows);
        let rates = from_fn(|k| {
            let own = self.content[k];
            match k % 2 {
                0 => gained[k / 2] / own,
                _ => KAPPA * GAS * math::pow(volumes[k / 2], KAPPA - 1.0) * heats[k / 2] / own,
            }
        });
        let [driving, returning] = sides.chambers.map(|side| side[0]);
        let beyond = returning - outside[1];
        let force = (driving - outside[1]) * drive.area_drive
            - beyond * drive.area_return
            - law.drag * speed;
        let taken = flows[0][0] + flows[2][0];
        let carried = |path: usize| flows[path][0] * flows[path][1];
        let enthalpy = HEAT * (carried(0) + carried(2) - carried(1) - carried(3));
        let push = driving * drive.area_drive - returning * drive.area_return;
        Some(Instant {
            rates,
            forces: [force, beyond * drive.area_return],
            sums: [taken, enthalpy, push],
        })
    }

    /// The forces at the epoch, N.
    pub(crate) fn forces(&self, problem: &Problem, motion: [f64; 2]) -> Option<[f64; 2]> {
        let outside = problem.outside.each_ref().map(|poly| poly.0[0]);
        Some(self.instant(problem, &self.content, outside, motion)?.forces)
    }

    /// The window's air with the piston moving like this; none if the iteration does not converge.
    pub(crate) fn solve(&self, problem: &Problem, steel: &Steel) -> Option<Solved> {
        let (rule, span, law) = (Rule::get(), problem.span, &problem.parameters.air);
        let outside: [[f64; 2]; STAGES] = from_fn(|i| {
            let t = span * rule.nodes[i];
            problem.outside.each_ref().map(|poly| poly.at(t))
        });
        let small = SMALL * law.error;
        let mut solved = Solved {
            rates: [[0.0; STAGES]; 4],
            place: steel.place,
            speed: steel.speed,
            forces: [steel.force, [0.0; STAGES]],
            sums: [[0.0; STAGES]; 3],
            error: 0.0,
        };
        let mut matrices: Option<[Option<Factors>; 2]> = None;
        for _ in 0..MOST {
            let pushed: Nodal = from_fn(|i| (solved.forces[0][i] - steel.force[i]) / problem.mass);
            let (mut misfit, mut change) = ([[0.0; STAGES]; 4], 0.0f64);
            for i in 0..STAGES {
                let place = steel.place[i] + span * span * dot(&rule.twice[i], &pushed);
                change = change.max(problem.stir(place, place - solved.place[i]));
                solved.place[i] = place;
                solved.speed[i] = steel.speed[i] + span * dot(&rule.once[i], &pushed);
                let motion = [place, solved.speed[i]];
                let content = self.content_of(&solved, span, i);
                let now = self.instant(problem, &content, outside[i], motion)?;
                for ((off, rate), now) in misfit.iter_mut().zip(&solved.rates).zip(now.rates) {
                    off[i] = now - rate[i];
                    change = change.max(span * off[i].abs());
                }
                (solved.forces[0][i], solved.forces[1][i]) = (now.forces[0], now.forces[1]);
                (0..3).for_each(|k| solved.sums[k][i] = now.sums[k]);
            }
            if change <= small {
                solved.error = problem.error(&solved);
                return solved.error.is_finite().then_some(solved);
            }
            if !change.is_finite() {
                return None;
            }
            if matrices.is_none() {
                let middle = STAGES / 2;
                let motion = [solved.place[middle], solved.speed[middle]];
                matrices = Some(self.matrices(problem, outside[middle], motion)?);
            }
            for (chamber, factors) in matrices.iter().flatten().enumerate() {
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

    /// The matrices of Newton's method, factorised; none for a chamber through which nothing flows.
    fn matrices(
        &self,
        problem: &Problem,
        outside: [f64; 2],
        motion: [f64; 2],
    ) -> Option<[Option<Factors>; 2]> {
        let base = self.instant(problem, &self.content, outside, motion)?.rates;
        let mut factors = [None, None];
        for (chamber, factors) in factors.iter_mut().enumerate() {
            let rows = 2 * chamber;
            if base[rows] == 0.0 && base[rows + 1] == 0.0 {
                continue;
            }
            let mut slopes = [[0.0; 2]; 2];
            for column in 0..2 {
                let mut moved = self.content;
                moved[rows + column] *= 1.0 + STEP;
                let rates = self.instant(problem, &moved, outside, motion)?.rates;
                (0..2).for_each(|row| {
                    slopes[row][column] = (rates[rows + row] - base[rows + row]) / STEP;
                });
            }
            *factors = Some(Factors::new(problem.span, &slopes)?);
        }
        Some(factors)
    }

    /// The window that these nodes are of, and the first place where a flow passes to another formula: the
    /// path and the formula beyond. An error is one that does so at once.
    pub(crate) fn window(
        &self,
        problem: &Problem,
        solved: &Solved,
        place: f64,
    ) -> Result<Window, (usize, usize)> {
        let (rule, span) = (Rule::get(), problem.span);
        let content =
            from_fn(|k| rule.integral(self.content[k], span * self.content[k], &solved.rates[k]));
        let [taken, enthalpy, force] = &solved.sums;
        let projection = rule.projection(force);
        let push = from_fn(|k| projection.get(k).copied().unwrap_or_default());
        let slope: Nodal = from_fn(|k| (k + 1) as f64 * push[k + 1]);
        let moment = from_fn(|i| value(&slope, rule.nodes[i]) * solved.place[i]);
        let sums = [(span, taken), (span, enthalpy), (1.0, &moment)]
            .map(|(factor, values)| rule.integral(0.0, factor, values));
        let (length, reach, then) = (span, span, None);
        let mut window = Window { length, content, sums, push, place, reach, then };
        let place = rule.integral(place, span, &solved.speed);
        let at = |tau: f64| {
            let now: Content = from_fn(|k| value(&window.content[k], tau));
            let outside = problem.outside.each_ref().map(|poly| poly.at(tau * span));
            let volumes = volumes(problem.parameters, value(&place, tau));
            Sides::new(&problem.parameters.air, outside, &now, volumes)
        };
        let areas = problem.parameters.air.areas(&self.openings, solved.place[STAGES / 2]);
        let mut first: Option<(f64, usize, usize)> = None;
        let marks = rule.nodes.iter().copied().chain([1.0]);
        let sampled: Vec<(f64, Sides)> = marks.map(|tau| (tau, at(tau))).collect();
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

impl Problem<'_> {
    /// Relative change of a pressure if the piston at `place` were off by `by`.
    pub(crate) fn stir(&self, place: f64, by: f64) -> f64 {
        let (volumes, drive) = (volumes(self.parameters, place), &self.parameters.drive);
        let [one, other] = [drive.area_drive / volumes[0], drive.area_return / volumes[1]];
        KAPPA * by.abs() * one.abs().max(other.abs())
    }

    /// Largest relative change of a pressure if the steel moved like this instead.
    pub(crate) fn misfit(&self, solved: &Solved, steel: &Steel) -> f64 {
        (0..STAGES).fold(0.0, |most: f64, i| {
            let off = self.stir(steel.place[i], steel.place[i] - solved.place[i]);
            // Not a number counts as the most.
            if off <= most { most } else { off }
        })
    }

    /// The error of a window over that allowed.
    fn error(&self, solved: &Solved) -> f64 {
        let (rule, parameters) = (Rule::get(), self.parameters);
        let last = |values: &Nodal| rule.coefficients(values)[STAGES - 1].abs();
        let content = solved.rates.iter().map(last).fold(0.0, f64::max);
        let content = self.span * content / (4 * STAGES - 2) as f64;
        let supply = self.outside[0].0[0].max(self.outside[1].0[0]);
        let scale = supply * (parameters.drive.area_drive + parameters.drive.area_return);
        let stroke = (self.mass * parameters.air.cylinder / scale).sqrt();
        let part = self.span / stroke;
        let force = part * (part + NOISE) * last(&solved.forces[0]) / scale;
        content.max(force) / parameters.air.error
    }
}

/// Part of the force's last term that may go over into its mean, where the motion rings.
const NOISE: f64 = 0.1;

/// The factorised matrix of a chamber, `1 - h A (x) J`.
#[derive(Debug)]
struct Factors {
    rows: Box<[[f64; ROWS]; ROWS]>,
    order: [usize; ROWS],
}

impl Factors {
    /// Of the slopes `J` over a window of this length; none if it is singular.
    fn new(span: f64, slopes: &[[f64; 2]; 2]) -> Option<Self> {
        let rule = Rule::get();
        let mut rows = Box::new([[0.0; ROWS]; ROWS]);
        for (r, row) in rows.iter_mut().enumerate() {
            for (c, x) in row.iter_mut().enumerate() {
                let unit = if r == c { 1.0 } else { 0.0 };
                let slope = slopes[r / STAGES][c / STAGES];
                *x = unit - span * slope * rule.once[r % STAGES][c % STAGES];
            }
        }
        let mut order: [usize; ROWS] = from_fn(|r| r);
        for c in 0..ROWS {
            let size = |r: &usize| rows[*r][c].abs();
            let pivot = (c..ROWS).max_by(|a, b| size(a).total_cmp(&size(b)))?;
            rows.swap(c, pivot);
            order.swap(c, pivot);
            let head = rows[c];
            if head[c].is_nan() || head[c].abs() <= f64::MIN_POSITIVE {
                return None;
            }
            for row in rows.iter_mut().skip(c + 1) {
                let factor = row[c] / head[c];
                row[c] = factor;
                (c + 1..ROWS).for_each(|k| row[k] -= factor * head[k]);
            }
        }
        Some(Self { rows, order })
    }

    fn solve(&self, first: &Nodal, second: &Nodal) -> [Nodal; 2] {
        let given = |r: usize| if r < STAGES { first[r] } else { second[r - STAGES] };
        let mut x: [f64; ROWS] = from_fn(|r| given(self.order[r]));
        for r in 1..ROWS {
            x[r] -= (0..r).map(|c| self.rows[r][c] * x[c]).sum::<f64>();
        }
        for r in (0..ROWS).rev() {
            let known: f64 = (r + 1..ROWS).map(|c| self.rows[r][c] * x[c]).sum();
            x[r] = (x[r] - known) / self.rows[r][r];
        }
        [from_fn(|i| x[i]), from_fn(|i| x[STAGES + i])]
    }
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
