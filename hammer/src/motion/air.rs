//! The air's windows on the steel in motion.

use super::Motion;
use crate::air::problem::{Problem, Solved, Steel};
use crate::air::solve::polynomial;
use crate::air::{Air, Places};
use crate::error::Error;
use crate::laws::event::Displacement;
use crate::numerics::collocation::{Rule, STAGES};
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::Parameters;
use crate::scene::graph::CHANNELS;
use crate::scene::graph::{Channel, Graph};

/// How far ahead pressures that vary are looked at, s.
const LONGEST: f64 = 0.02;
/// Steps of the search for the instant at which one of them is zero, and how near they come to it, s.
const MARCH: usize = 64;
const INSTANT: f64 = 1e-9;
/// Trials of a window, each shorter or with another formula of a flow.
pub(super) const TRIALS: usize = 64;
/// Replacements of the force that is guessed.
pub(super) const PASSES: usize = 12;
/// Part of the error allowed by which steel and air may disagree.
const AGREED: f64 = 0.1;
/// A window whose error is so far above that allowed is not worth an agreement.
const HOPELESS: f64 = 4.0;
/// Part of the length that the error would allow, and how a window may grow and shrink.
pub(super) const SAFETY_FACTOR: f64 = 0.8;
pub(super) const GROWTH: f64 = 2.0;
pub(super) const SHRINKAGE: f64 = 0.1;
/// Shortest window, s.
const SHORTEST: f64 = 1e-12;

/// That the air cannot be followed beyond a time, at which the piston is there.
pub(super) fn beyond(parameters: &Parameters, time: f64, [x, y]: Places) -> Error {
    let (air, drive) = (&parameters.air, &parameters.drive);
    let top = -air.cylinder - air.drive.dead_volume / drive.area_drive;
    let bottom = air.returning.dead_volume / drive.area_return;
    let place = if y >= bottom { y } else { x };
    Error::Air { time, place, range: [top, bottom] }
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
    let [piston, struck, frame] = [0, 1, graph.frame].map(|body| 1.0 / graph.bodies[body].mass);
    let bound = if flies { 0.0 } else { piston };
    let (over, held) = ([piston, -struck], [bound, struck]);
    // The drive's reaction acts on a frame, and so does that of what presses on the bit.
    let (gains, tied) = match graph.is_framed() {
        true => ([[piston + frame, frame], over], [[bound + frame, frame], held]),
        false => ([over; 2], [held; 2]),
    };
    let mass = graph.bodies[0].mass;
    Problem { parameters, mass, gains, tied, outside: outside(inputs), span }
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

    /// Positions of the piston that the chambers see, and their rates, at `t` after the epoch, where `tracks`
    /// stand.
    pub(crate) fn in_cylinder(&self, tracks: &[super::Track], t: f64) -> [Places; 2] {
        let of = |displacement| {
            let point = self.point(tracks, displacement, t);
            [point.displacement + self.ahead(displacement), point.velocity]
        };
        let x = of(Displacement::Relative);
        let y = if self.graph().is_framed() { of(Displacement::OverStruck) } else { x };
        [0, 1].map(|order| [x[order], y[order]])
    }

    /// Changes the air at the epoch: with the parameters, the piston's places, and the exhaust's pressure.
    pub(super) fn change_air(&mut self, change: impl FnOnce(&mut Air, &Parameters, Places, f64)) {
        let ([_, exhaust], [places, _]) = (self.outside(0.0), self.in_cylinder(&self.tracks, 0.0));
        if let Some(air) = &mut self.state.air {
            change(air, &self.model.parameters, places, exhaust);
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

    /// Solves the air of the window that begins at the epoch, unless the chambers are vented, or the answer of a
    /// line; returns the number of rotations and that of iterations.
    ///
    /// # Errors
    /// [`Error::Air`], [`Error::Vacuum`].
    pub(crate) fn renew_air(&mut self) -> Result<[u64; 2], Error> {
        let (breath, input) = self.breath();
        if breath < 2.0 * INSTANT {
            return Err(Error::Vacuum { time: self.state.epoch.value(), name: input.name() });
        }
        let Some(mut air) = self.state.air.take_if(|air| air.vented.is_none()) else {
            return Ok([self.renew_line()?, 0]);
        };
        let motion = self.in_cylinder(&self.tracks, 0.0);
        air.classify(self.parameters(), motion[0], self.outside(0.0));
        let parameters = self.model.parameters;
        let flies = self.flying().is_some();
        let inputs = &self.state.inputs;
        let mut problem = problem(&parameters, self.graph(), inputs, flies, air.ahead.min(breath));
        let (mut work, mut rejected) = ([0; 2], false);
        for _ in 0..TRIALS {
            let shorter = match self.attempt(&air, &problem, motion, &mut work) {
                // A guess may be what leads astray.
                None if air.past.take().is_some() => continue,
                None => SHRINKAGE,
                Some(solved) => {
                    let change = SAFETY_FACTOR / math::pow(solved.error, 1.0 / STAGES as f64);
                    if solved.error <= 1.0 {
                        match air.window(&problem, &solved, motion[0]) {
                            Ok(window) => {
                                // What has just been too long would be so again.
                                let growth = if rejected { 1.0 } else { GROWTH };
                                air.ahead = problem.span * change.clamp(SAFETY_FACTOR, growth);
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
                    change.clamp(SHRINKAGE, SAFETY_FACTOR)
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
        motion: [Places; 2],
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

    /// How long after the epoch the pressures of supply and exhaust are certainly above zero, s, and which then is not;
    /// of pressures that vary, no longer than [`LONGEST`].
    pub(super) fn breath(&self) -> (f64, Input) {
        let of = |input: Input| {
            let poly = self.state.inputs.of(input);
            if self.state.air.is_none() || poly.is_constant() {
                return (f64::INFINITY, input);
            }
            // No pressure falls faster than at its steepest.
            let slope = |k: usize| k as f64 * poly.0[k].abs() * math::powi(LONGEST, k - 1);
            let steepest: f64 = (1..=poly.degree()).map(slope).sum();
            let mut time = 0.0;
            for _ in 0..MARCH {
                let step = poly.at(time) / steepest;
                if step < INSTANT {
                    break;
                }
                time = LONGEST.min(time + step);
            }
            (time, input)
        };
        let (supply, exhaust) = (of(Input::SupplyPressure), of(Input::ExhaustPressure));
        if exhaust.0 < supply.0 { exhaust } else { supply }
    }

    /// Puts the air's forces on the piston and on the bit, from the epoch on.
    fn press(&mut self, [drive, anvil]: [Poly; 2]) {
        let mut loads: [Poly; CHANNELS] = self.state.loads;
        (loads[Channel::Drive as usize], loads[Channel::Anvil as usize]) = (drive, anvil);
        self.load(loads);
    }

    /// The steel's motion at the nodes of a window, under the present loads.
    pub(super) fn steel(&self, span: f64, work: &mut u64) -> Steel {
        let times = Rule::get().nodes.map(|node| span * node);
        let over = self.graph().over_struck();
        let positions = [Displacement::Relative, over];
        let mut place = positions.map(|displacement| [self.ahead(displacement); STAGES]);
        let mut speed = [[0.0; STAGES]; 2];
        let distinct = if self.graph().is_framed() { 2 } else { 1 };
        for (index, track) in self.tracks.iter().enumerate() {
            let shares = positions.map(|displacement| self.share(index, displacement));
            let shares = || (0..distinct).filter_map(|k| Some((k, shares[k]?)));
            let mut swings = false;
            for (k, share) in shares() {
                let values = self.poly(index, share).at_each(&times);
                for (i, [x, v]) in values.into_iter().enumerate() {
                    (place[k][i], speed[k][i]) = (place[k][i] + x, speed[k][i] + v);
                }
                swings |= !track.system.functionals[share].still;
            }
            if !swings {
                continue;
            }
            let mut track = track.clone();
            for i in 0..STAGES {
                *work += track.rotate_to(times[i]);
                for (k, share) in shares() {
                    let rows = &track.system.functionals[share].rows;
                    place[k][i] += kernel::dot(&rows[0], &track.z);
                    speed[k][i] += kernel::dot(&rows[1], &track.z);
                }
            }
        }
        if distinct == 1 {
            (place[1], speed[1]) = (place[0], speed[0]);
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

    /// Masses that forces push apart: the piston and the casing, from which the drive pushes and which the return
    /// chamber's reaction pushes on; the piston and the bit, which that chamber pushes away.
    #[test]
    fn the_forces_effect_is_that_on_the_masses_they_push_apart() {
        let mut p = Parameters::default();
        p.piston.length = 0.17;
        let inputs = Inputs::constant(&InputValues::default());
        p.casing.segment[0] = Segment { length: 1.3, area: 4e-3 };
        // Without a casing, in a rigid one, in one of a section, and all bodies rigid.
        for (casing, segments, fidelity) in [
            (0.0, 0, Fidelity::Elastic),
            (30.0, 0, Fidelity::Elastic),
            (30.0, 1, Fidelity::Elastic),
            (30.0, 0, Fidelity::Rigid),
        ] {
            (p.casing.mass, p.casing.segments, p.fidelity) = (casing, segments, fidelity);
            let model = Model::new(&p).expect("a model");
            let [one, bit] = [0, 1].map(|i| 1.0 / model.graph.bodies[i].mass);
            for flies in [true, false] {
                let problem = problem(&p, &model.graph, &inputs, flies, 1e-4);
                let held = if flies { 0.0 } else { one };
                let (gains, tied) = if casing > 0.0 {
                    let frame = 1.0 / model.graph.bodies[model.graph.frame].mass;
                    ([[one + frame, frame], [one, -bit]], [[held + frame, frame], [held, bit]])
                } else {
                    ([[one, -bit]; 2], [[held, bit]; 2])
                };
                for (is, must) in [(problem.gains, gains), (problem.tied, tied)] {
                    for (is, must) in is.iter().flatten().zip(must.iter().flatten()) {
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
