//! The air's windows on the steel in motion.

use super::Motion;
use crate::air::Air;
use crate::air::solve::{Problem, Solved, Steel, polynomial};
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::modal::graph::Channel;
use crate::modal::system::CHANNELS;
use crate::numerics::collocation::{Nodal, Rule, STAGES};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use std::array::from_fn;

/// Trials of a window, each shorter or with another formula of a flow.
const TRIALS: usize = 64;
/// Replacements of the force that is guessed.
const PASSES: usize = 12;
/// Part of the error allowed by which steel and air may disagree.
const AGREED: f64 = 0.1;
/// A window whose error is so far above that allowed is not worth an agreement.
const HOPELESS: f64 = 1e3;
/// Part of the length that the error would allow, and how a window may grow and shrink.
const CAUTION: f64 = 0.8;
const GROWTH: f64 = 4.0;
const SHRINKAGE: f64 = 0.1;
/// Shortest window, s.
const SHORTEST: f64 = 1e-12;

/// Pressures of supply and exhaust.
pub(super) fn outside(inputs: &Inputs) -> [Poly; 2] {
    [Input::SupplyPressure, Input::ExhaustPressure].map(|input| *inputs.of(input))
}

impl Motion {
    /// The air in the chambers, if air drives the piston.
    pub(crate) fn air(&self) -> Option<&Air> {
        self.state.air.as_deref()
    }

    /// Pressures of supply and exhaust at `t` after the epoch, Pa.
    pub(crate) fn outside(&self, t: f64) -> [f64; 2] {
        outside(&self.state.inputs).map(|poly| poly.at(t))
    }

    /// Position and velocity of the piston that the chambers see, at `t` after the epoch, where `tracks`
    /// stand.
    pub(crate) fn in_cylinder(&self, tracks: &[super::Track], t: f64) -> [f64; 2] {
        let point = self.point(tracks, Displacement::Relative, t);
        [point.displacement + self.ahead(Displacement::Relative), point.velocity]
    }

    /// Solves the air of the window that begins at the epoch, unless the drive is vented; returns the
    /// number of rotations.
    ///
    /// # Errors
    /// [`Error::Air`].
    pub(crate) fn renew_air(&mut self) -> Result<u64, Error> {
        let Some(mut air) = self.state.air.take_if(|_| !self.state.mode.vented) else {
            return Ok(0);
        };
        let parameters = self.model.parameters;
        let motion = self.in_cylinder(&self.tracks, 0.0);
        air.classify(&parameters, motion[0], self.outside(0.0));
        let mut problem = Problem {
            parameters: &parameters,
            mass: self.graph().bodies[0].mass,
            outside: outside(&self.state.inputs),
            span: air.ahead,
        };
        let mut work = 0;
        for _ in 0..TRIALS {
            let shorter = match self.attempt(&air, &problem, motion, &mut work) {
                None => SHRINKAGE,
                Some(solved) => {
                    let change = CAUTION / math::pow(solved.error, 1.0 / STAGES as f64);
                    if solved.error <= 1.0 {
                        match air.window(&problem, &solved, motion[0]) {
                            Ok(window) => {
                                air.ahead = problem.span * change.clamp(CAUTION, GROWTH);
                                air.window = Some(window);
                                self.state.air = Some(air);
                                return Ok(work);
                            }
                            Err((path, bound)) => {
                                air.regimes[path] = air.regimes[path].next(bound);
                                continue;
                            }
                        }
                    }
                    change.clamp(SHRINKAGE, CAUTION)
                }
            };
            problem.span *= shorter;
            if problem.span.is_nan() || problem.span <= SHORTEST {
                break;
            }
        }
        self.state.air = Some(air);
        Err(Error::Air { time: self.state.epoch.value() })
    }

    /// The air of one window and the steel under its force, which agree; or the air alone, where its error
    /// is too large anyway.
    fn attempt(
        &mut self,
        air: &Air,
        problem: &Problem,
        motion: [f64; 2],
        work: &mut u64,
    ) -> Option<Solved> {
        let forces = air.forces(problem, motion)?;
        self.press(forces.map(Poly::constant));
        let (mut force, mut last): (Nodal, Option<Solved>) = ([forces[0]; STAGES], None);
        for _ in 0..PASSES {
            let steel = self.steel(problem.span, force, work);
            if let Some(solved) = last
                && (solved.error > HOPELESS
                    || problem.misfit(&solved, &steel) <= AGREED * problem.parameters.air.error)
            {
                return Some(solved);
            }
            let solved = air.solve(problem, &steel)?;
            self.press(solved.forces.each_ref().map(|values| polynomial(values, problem.span)));
            force = solved.forces[0];
            last = Some(solved);
        }
        None
    }

    /// Puts the air's forces on the piston and on the bit, from the epoch on.
    fn press(&mut self, [drive, anvil]: [Poly; 2]) {
        let mut loads: [Poly; CHANNELS] = self.state.loads;
        (loads[Channel::Drive as usize], loads[Channel::Anvil as usize]) = (drive, anvil);
        self.load(loads);
    }

    /// The steel's motion at the nodes of a window, under forces of which that on the piston is this.
    fn steel(&self, span: f64, force: Nodal, work: &mut u64) -> Steel {
        let mut tracks = self.tracks.clone();
        let motion: [[f64; 2]; STAGES] = from_fn(|i| {
            let t = span * Rule::get().nodes[i];
            for (index, track) in tracks.iter_mut().enumerate() {
                let share = self.share(index, Displacement::Relative);
                if share.is_some_and(|share| !track.system.functionals[share].still) {
                    *work += track.rotate_to(t);
                }
            }
            self.in_cylinder(&tracks, t)
        });
        Steel { place: motion.map(|m| m[0]), speed: motion.map(|m| m[1]), force }
    }
}
