//! What a window of air is solved from, and what differences may be left.

use super::{Places, volumes};
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
    /// Acceleration of each of its positions by each of the forces, if all bodies are free, 1/kg.
    pub gains: [[f64; 2]; 2],
    /// What of it the ties of those that are not free may take back, 1/kg.
    pub tied: [[f64; 2]; 2],
    /// Pressures of supply and exhaust after the epoch.
    pub outside: [Poly; 2],
    /// Length, s.
    pub span: f64,
}

/// The piston's positions and their rates at the nodes, under these forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steel {
    pub place: [Nodal; 2],
    pub speed: [Nodal; 2],
    pub forces: [Nodal; 2],
}

/// The air of a window, at the nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solved {
    /// Rates of the content, relative to that at the epoch, 1/s.
    pub(super) rates: [Nodal; 4],
    pub place: [Nodal; 2],
    pub speed: [Nodal; 2],
    /// `F_A`, and of the return chamber on the bit, N.
    pub forces: [Nodal; 2],
    /// Flow from the supply, enthalpy that comes in, and the forces of the pressures alone.
    pub(super) sums: [Nodal; 4],
    /// The error over that allowed.
    pub error: f64,
}

impl Steel {
    /// The piston's positions at a node.
    fn places(&self, node: usize) -> Places {
        from_fn(|k| self.place[k][node])
    }
}

impl Problem<'_> {
    /// Relative change of a pressure if the piston's places there were off by so much.
    pub(crate) fn stir(&self, places: Places, by: Places) -> f64 {
        let (volumes, drive) = (volumes(self.parameters, places), &self.parameters.drive);
        let of = |i: usize, area: f64| (by[i] * area / volumes[i]).abs();
        KAPPA * of(0, drive.area_drive).max(of(1, drive.area_return))
    }

    /// True if what the forces of a solution differ from those under which the steel moved cannot matter,
    /// beyond what free bodies do, which the solution has: by ties. (Forces that are distributed like the mass
    /// strain no free body.)
    pub(crate) fn is_trifle(&self, solved: &Solved, steel: &Steel, allowed: f64) -> bool {
        let off: [Nodal; 2] = from_fn(|k| from_fn(|i| solved.forces[k][i] - steel.forces[k][i]));
        let twice = &Rule::get().twice;
        (0..STAGES).all(|i| {
            let moved = |of: usize, k: usize| self.tied[of][k] * dot(&twice[i], &off[k]).abs();
            let by = |of: usize| self.span * self.span * (moved(of, 0) + moved(of, 1));
            self.stir(steel.places(i), [by(0), by(1)]) <= allowed
        })
    }

    /// Accelerations of the piston's positions, at the nodes, by what a solution's forces are more than those under
    /// which the steel moved, if all bodies are free.
    pub(super) fn pushed(&self, solved: &Solved, steel: &Steel) -> [Nodal; 2] {
        from_fn(|of| {
            from_fn(|i| {
                let off = |k: usize| self.gains[of][k] * (solved.forces[k][i] - steel.forces[k][i]);
                off(0) + off(1)
            })
        })
    }

    /// Largest relative change of a pressure if the steel moved like this instead.
    pub(crate) fn misfit(&self, solved: &Solved, steel: &Steel) -> f64 {
        (0..STAGES).fold(0.0, |most: f64, i| {
            let off = from_fn(|k| steel.place[k][i] - solved.place[k][i]);
            let off = self.stir(steel.places(i), off);
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
