//! The air's windows on the steel in motion.

use super::Motion;
use crate::air::Air;
use crate::air::problem::{Problem, Solved, Steel};
use crate::air::solve::polynomial;
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::modal::graph::{Channel, Graph};
use crate::modal::system::CHANNELS;
use crate::numerics::collocation::{Rule, STAGES};
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;

/// Trials of a window, each shorter or with another formula of a flow.
const TRIALS: usize = 64;
/// Replacements of the force that is guessed.
const PASSES: usize = 12;
/// Part of the error allowed by which steel and air may disagree.
const AGREED: f64 = 0.1;
/// A window whose error is so far above that allowed is not worth an agreement.
const HOPELESS: f64 = 4.0;
/// Part of the length that the error would allow, and how a window may grow and shrink.
const CAUTION: f64 = 0.8;
const GROWTH: f64 = 2.0;
const SHRINKAGE: f64 = 0.1;
/// Shortest window, s.
const SHORTEST: f64 = 1e-12;

/// That the air cannot be followed beyond a time, at which the piston is at `vr`.
pub(super) fn beyond(parameters: &Parameters, time: f64, vr: f64) -> Error {
    let (air, drive) = (&parameters.air, &parameters.drive);
    let top = -air.cylinder - air.drive.dead_volume / drive.area_drive;
    let bottom = air.returning.dead_volume / drive.area_return;
    Error::Air { time, place: vr, range: [top, bottom] }
}

/// Pressures of supply and exhaust.
pub(super) fn outside(inputs: &Inputs) -> [Poly; 2] {
    [Input::SupplyPressure, Input::ExhaustPressure].map(|input| *inputs.of(input))
}

/// What a window of this length is solved from, while the piston flies alone or does not.
pub(super) fn problem<'a>(
    parameters: &'a Parameters,
    graph: &Graph,
    inputs: &Inputs,
    flies: bool,
    span: f64,
) -> Problem<'a> {
    let [piston, frame] = [0, graph.frame].map(|body| 1.0 / graph.bodies[body].mass);
    // The drive's reaction acts on a frame, and so does what presses on the bit.
    let reaction = if graph.is_framed() { frame } else { 0.0 };
    let gains = [piston + reaction, if graph.is_framed() { frame } else { -frame }];
    let tied = [if flies { reaction } else { piston + reaction }, frame];
    let give = |body: Body| match parameters.is_elastic(body) {
        true => parameters.sections(body).compliance(parameters.material.youngs_modulus),
        false => 0.0,
    };
    let [piston, frame] =
        [Some(Body::Piston), parameters.bodies().last()].map(|b| b.map_or(0.0, give));
    let give = [if graph.is_framed() { piston + frame } else { piston }, frame];
    let mass = graph.bodies[0].mass;
    Problem { parameters, mass, gains, tied, give, outside: outside(inputs), span }
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

    /// Changes the air at the epoch: with the parameters, the piston's place, and the pressures outside.
    pub(super) fn change_air(&mut self, change: impl FnOnce(&mut Air, &Parameters, f64, [f64; 2])) {
        let (outside, [vr, _]) = (self.outside(0.0), self.in_cylinder(&self.tracks, 0.0));
        if let Some(air) = &mut self.state.air {
            change(air, &self.model.parameters, vr, outside);
        }
        self.reload();
    }

    /// The air's forces on the piston and on the bit, as they stand.
    pub(super) fn air_forces(&self, air: Option<&Air>) -> [Poly; 2] {
        let acting = |channel: Channel| match air {
            Some(Air { vented: Some(_), .. }) => Poly::default(),
            _ => self.state.loads[channel as usize],
        };
        [Channel::Drive, Channel::Anvil].map(acting)
    }

    /// Solves the air of the window that begins at the epoch, unless the chambers are vented; returns the
    /// number of rotations and that of iterations.
    ///
    /// # Errors
    /// [`Error::Air`].
    pub(crate) fn renew_air(&mut self) -> Result<[u64; 2], Error> {
        let Some(mut air) = self.state.air.take_if(|air| air.vented.is_none()) else {
            return Ok([0; 2]);
        };
        let motion = self.in_cylinder(&self.tracks, 0.0);
        air.classify(self.parameters(), motion[0], self.outside(0.0));
        let parameters = self.model.parameters;
        let flies = self.flying().is_some();
        let inputs = &self.state.inputs;
        let mut problem = problem(&parameters, self.graph(), inputs, flies, air.ahead);
        let (mut work, mut rejected) = ([0; 2], false);
        for _ in 0..TRIALS {
            let shorter = match self.attempt(&air, &problem, motion, &mut work) {
                // A guess may be what leads astray.
                None if air.past.take().is_some() => continue,
                None => SHRINKAGE,
                Some(solved) => {
                    let change = CAUTION / math::pow(solved.error, 1.0 / STAGES as f64);
                    if solved.error <= 1.0 {
                        match air.window(&problem, &solved, motion[0]) {
                            Ok(window) => {
                                // What has just been too long would be so again.
                                let growth = if rejected { 1.0 } else { GROWTH };
                                air.ahead = problem.span * change.clamp(CAUTION, growth);
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
                    rejected = true;
                    air.past = Some(air.past(&problem, &solved));
                    change.clamp(SHRINKAGE, CAUTION)
                }
            };
            problem.span *= shorter;
            if problem.span.is_nan() || problem.span <= SHORTEST {
                break;
            }
        }
        self.state.air = Some(air);
        Err(beyond(self.parameters(), self.state.epoch.value(), motion[0]))
    }

    /// The air of one window and the steel under its force, which agree; or the air alone, where its error
    /// is too large anyway.
    fn attempt(
        &mut self,
        air: &Air,
        problem: &Problem,
        motion: [f64; 2],
        [rotations, iterations]: &mut [u64; 2],
    ) -> Option<Solved> {
        if air.past.is_none() {
            self.press(air.forces(problem, motion)?.map(Poly::constant));
        } // Otherwise the forces of the window before go on, as they stand.
        let mut steel = self.steel(problem.span, rotations);
        let mut newton = air.guess(problem.span);
        let agreed = AGREED * problem.parameters.air.error;
        for _ in 0..PASSES {
            let solved = air.solve(problem, &steel, &mut newton);
            *iterations += std::mem::take(&mut newton.iterations);
            let solved = solved?;
            if solved.error > HOPELESS {
                return Some(solved);
            }
            self.press(solved.forces.each_ref().map(|values| polynomial(values, problem.span)));
            if problem.is_trifle(&solved, &steel, agreed) {
                return Some(solved);
            }
            steel = self.steel(problem.span, rotations);
            if problem.misfit(&solved, &steel) <= agreed {
                return Some(solved);
            }
        }
        None
    }

    /// Puts the air's forces on the piston and on the bit, from the epoch on.
    fn press(&mut self, [drive, anvil]: [Poly; 2]) {
        let mut loads: [Poly; CHANNELS] = self.state.loads;
        (loads[Channel::Drive as usize], loads[Channel::Anvil as usize]) = (drive, anvil);
        self.load(loads);
    }

    /// The steel's motion at the nodes of a window, under the present loads.
    fn steel(&self, span: f64, work: &mut u64) -> Steel {
        let times = Rule::get().nodes.map(|node| span * node);
        let (mut place, mut speed) = ([self.ahead(Displacement::Relative); STAGES], [0.0; STAGES]);
        for (index, track) in self.tracks.iter().enumerate() {
            let Some(share) = self.share(index, Displacement::Relative) else { continue };
            let (poly, functional) = (self.poly(index, share), &track.system.functionals[share]);
            for (i, [x, v]) in poly.at_each(&times).into_iter().enumerate() {
                (place[i], speed[i]) = (place[i] + x, speed[i] + v);
            }
            if functional.still {
                continue;
            }
            let mut track = track.clone();
            for i in 0..STAGES {
                *work += track.rotate_to(times[i]);
                place[i] += kernel::dot(&functional.rows[0], &track.z);
                speed[i] += kernel::dot(&functional.rows[1], &track.z);
            }
        }
        let loads = [Channel::Drive, Channel::Anvil].map(|c| &self.state.loads[c as usize]);
        Steel { place, speed, forces: loads.map(|load| load.at_each(&times).map(|[x, _]| x)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::model::Model;
    use crate::quantities::parameters::{Fidelity, InputValues};
    use crate::quantities::sections::Segment;

    /// Two masses that a force pushes apart: the piston and the casing, from which the drive pushes and which the
    /// return chamber's force moves away from the piston; or the bit, which that force alone pushes away.
    #[test]
    fn the_force_s_effect_is_that_on_the_masses_it_pushes_apart() {
        let mut p = Parameters::default();
        p.piston.length = 0.17;
        let inputs = Inputs::constant(&InputValues::default());
        p.casing.segment[0] = Segment { length: 1.3, area: 4e-3 };
        let give = |body: Body| p.sections(body).compliance(p.material.youngs_modulus);
        let [piston, bit] = [Body::Piston, Body::Bit].map(give);
        // Without a casing, in a rigid one, in one of a section, and all bodies rigid.
        for (casing, segments, fidelity) in [
            (0.0, 0, Fidelity::Elastic),
            (30.0, 0, Fidelity::Elastic),
            (30.0, 1, Fidelity::Elastic),
            (30.0, 0, Fidelity::Rigid),
        ] {
            (p.casing.mass, p.casing.segments, p.fidelity) = (casing, segments, fidelity);
            let model = Model::new(&p).expect("a model");
            let shaft = segments as f64 * 1.3 / (4e-3 * p.material.youngs_modulus);
            let [one, frame] = [0, model.graph.frame].map(|i| 1.0 / model.graph.bodies[i].mass);
            let elastic = if fidelity == Fidelity::Elastic { 1.0 } else { 0.0 };
            for flies in [true, false] {
                let problem = problem(&p, &model.graph, &inputs, flies, 1e-4);
                let (gains, tied, give) = match casing > 0.0 {
                    true => (
                        [one + frame, frame],
                        [if flies { frame } else { one + frame }, frame],
                        [elastic * piston + shaft, shaft],
                    ),
                    false => ([one, -frame], [if flies { 0.0 } else { one }, frame], [piston, bit]),
                };
                for (is, must) in
                    [(problem.gains, gains), (problem.tied, tied), (problem.give, give)]
                {
                    for (is, must) in is.into_iter().zip(must) {
                        assert!(
                            (is - must).abs() <= 1e-12 * must.abs(),
                            "{casing} {flies}: {is} {must}"
                        );
                    }
                }
            }
        }
    }
}
