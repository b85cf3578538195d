//! What a window of air is solved from, and what differences may be left.

use super::volumes;
use crate::laws::air::KAPPA;
use crate::numerics::collocation::{Nodal, Rule, STAGES, dot};
use crate::numerics::poly::Poly;
use crate::quantities::parameters::Parameters;
use std::array::from_fn;

/// Part of the force's last term that may go over into its mean, where the motion rings.
const NOISE: f64 = 0.1;

/// What a window is solved from.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    pub parameters: &'a Parameters,
    /// Mass of the piston, kg.
    pub mass: f64,
    /// Acceleration of its relative position by each of the forces, if all bodies are free, 1/kg.
    pub gains: [f64; 2],
    /// What of it the ties of those that are not free may take back, 1/kg.
    pub tied: [f64; 2],
    /// How much each of the forces shortens what it acts on, at most, m/N.
    pub give: [f64; 2],
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
    pub forces: [Nodal; 2],
}

/// The air of a window, at the nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solved {
    /// Rates of the content, relative to that at the epoch, 1/s.
    pub(super) rates: [Nodal; 4],
    pub place: Nodal,
    pub speed: Nodal,
    /// `F_A`, and of the return chamber on the bit, N.
    pub forces: [Nodal; 2],
    /// Flow from the supply, enthalpy that comes in, and the force of the pressures alone.
    pub(super) sums: [Nodal; 3],
    /// The error over that allowed.
    pub error: f64,
}

impl Problem<'_> {
    /// Relative change of a pressure if the piston at `place` were off by `by`.
    pub(crate) fn stir(&self, place: f64, by: f64) -> f64 {
        let (volumes, drive) = (volumes(self.parameters, place), &self.parameters.drive);
        let [one, other] = [drive.area_drive / volumes[0], drive.area_return / volumes[1]];
        KAPPA * by.abs() * one.abs().max(other.abs())
    }

    /// True if what the forces of a solution differ from those under which the steel moved cannot matter,
    /// beyond what free rigid bodies do, which the solution has: by ties, and by what is elastic. (A force
    /// on one end of a free bar brings the other nearer to its mean by a sixth of what it would shorten
    /// the bar, and by at most twice that where it comes suddenly.)
    pub(crate) fn is_trifle(&self, solved: &Solved, steel: &Steel, allowed: f64) -> bool {
        let off: [Nodal; 2] = from_fn(|k| from_fn(|i| solved.forces[k][i] - steel.forces[k][i]));
        let twice = &Rule::get().twice;
        (0..STAGES).all(|i| {
            let moved =
                |k: usize| self.span * self.span * self.tied[k] * dot(&twice[i], &off[k]).abs();
            let by = |k: usize| moved(k) + self.give[k] * off[k][i].abs();
            self.stir(steel.place[i], by(0) + by(1)) <= allowed
        })
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
    pub(super) fn error(&self, solved: &Solved) -> f64 {
        let (rule, parameters) = (Rule::get(), self.parameters);
        let last = |values: &Nodal| rule.last(values).abs();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::air::ATMOSPHERE;

    /// A piston in flight that gives 1e-9 m for 3 N: the pressure of a chamber changes by
    /// `kappa A / V` of itself times that.
    #[test]
    fn a_force_that_shortens_the_piston_may_matter() {
        let parameters = Parameters::default();
        let outside = [2e6, ATMOSPHERE].map(Poly::constant);
        let (mass, gains, tied, place) = (10.0, [0.1; 2], [0.0; 2], -0.01);
        let steel =
            Steel { place: [place; STAGES], speed: [0.0; STAGES], forces: [[0.0; STAGES]; 2] };
        let forces = [[3.0; STAGES], [0.0; STAGES]];
        let (rates, sums) = ([[0.0; STAGES]; 4], [[0.0; STAGES]; 3]);
        let solved =
            Solved { rates, place: steel.place, speed: steel.speed, forces, sums, error: 0.0 };
        for give in [0.0, 1e-9 / 3.0] {
            let problem = Problem {
                parameters: &parameters,
                mass,
                gains,
                tied,
                give: [give, 0.0],
                outside,
                span: 1e-4,
            };
            let ([one, other], drive) = (volumes(&parameters, place), &parameters.drive);
            let most = (drive.area_drive / one).max(drive.area_return / other);
            let change = KAPPA * 1e-9 * most;
            assert!(problem.is_trifle(&solved, &steel, change * 1.01));
            assert_eq!(give == 0.0, problem.is_trifle(&solved, &steel, change * 0.99));
        }
    }
}
