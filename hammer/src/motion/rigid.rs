//! A rigid hammer under air: its bodies are expanded with the gas, and it needs no modes.
//!
//! While piston and bit are rigid and only the rock brakes them, their motion in a window of the air is a polynomial
//! ([`Course`]). There are no tracks and no anchors then. A body that rings for very many radians in a stroke would need
//! very many windows. Its motion is left to the modes, which rotate it at once.

use super::Motion;
use super::state::Anchor;
use crate::air::course::Course;
use crate::air::series::{LONGEST, Left};
use crate::air::steel::{Pair, Steel};
use crate::error::Error;
use crate::laws::mode::{Mode, Tie};
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::track::Track;
use crate::numerics::poly::Poly;
use crate::scene::graph::{CHANNELS, Channel, Group};
use std::array::from_fn;
use std::sync::Arc;

/// Bodies that ring for more radians than this in the time of a stroke are not expanded.
const RADIANS: f64 = 1000.0;

impl Motion {
    /// The motion of a rigid hammer that is expanded with the air.
    #[inline]
    pub(crate) fn course(&self) -> Option<&Course> {
        self.state.course.as_deref()
    }

    /// The largest force of the air on the piston, N.
    fn largest_force(&self) -> f64 {
        let drive = &self.parameters().drive;
        let [supply, exhaust] = self.outside(0.0);
        supply.max(exhaust) * (drive.area_drive + drive.area_return)
    }

    /// Stiffness of the contact (N/m; 0 while it is open), and spring and dashpot of the rock, in this mode.
    fn lines(&self, mode: &Mode) -> (f64, Coefficients) {
        let mut holding = self.graph().holding(mode.ties);
        let contact = holding.find(|(edge, _)| edge.tie == Tie::Contact);
        let rock = Spring::of(mode.rock).coefficients(&self.parameters().rock);
        (contact.map_or(0.0, |(_, line)| line.stiffness), rock)
    }

    /// True if the bodies are to be expanded with the air in this mode.
    pub(super) fn follows(&self, mode: &Mode) -> bool {
        #[cfg(test)]
        if tests::BY_MODES.get() {
            return false;
        }
        if !self.model.is_expanded() {
            return false;
        }
        let (contact, rock) = self.lines(mode);
        let [piston, bit] = self.masses();
        let stroke = (piston * self.parameters().air.cylinder / self.largest_force()).sqrt();
        let along = rock.stiffness / bit + contact * (1.0 / piston + 1.0 / bit);
        let rate = along.sqrt() + rock.viscosity / bit;
        rate * stroke <= RADIANS
    }

    /// What acts on the two bodies at the epoch, if they are to be expanded with the air.
    pub(super) fn pair(&self) -> Option<Pair> {
        let mode = &self.state.mode;
        if !self.follows(mode) {
            return None;
        }
        let ((contact, rock), masses, force) =
            (self.lines(mode), self.masses(), self.largest_force());
        let loads = &self.state.loads;
        let [feed, gravity] = [Channel::Feed, Channel::Gravity].map(|c| &loads[c as usize].0);
        let other = |body: usize| {
            let pulled = |k: usize| if body == 1 { feed[k] } else { 0.0 };
            from_fn(|k| masses[body] * gravity[k] + pulled(k))
        };
        // Twice the displacement by the air's force, of whatever is stiffest.
        let stiffest = rock.stiffness.max(contact).max(force / self.parameters().air.cylinder);
        Some(Pair {
            masses,
            contact,
            rock,
            others: [other(0), other(1)],
            unit: 2.0 * force / stiffest,
            ..Pair::default()
        })
    }

    fn masses(&self) -> [f64; 2] {
        from_fn(|body| self.graph().bodies[body].mass)
    }

    /// Puts both bodies as they are expanded from the epoch on into `steel`.
    pub(super) fn bodies(&self, pair: Pair, steel: &mut Steel) -> Left {
        let [places, speeds] = self.course().map(Course::start).unwrap_or_default();
        steel.blocks.clear();
        steel.pair = Some(Pair { places, speeds, ..pair });
        Left { longest: LONGEST, ..Left::default() }
    }

    /// `[q | q']` of both bodies at these displacements and velocities.
    pub(super) fn of_bodies(&self, motion: [[f64; 2]; 2]) -> Vec<f64> {
        let roots = self.roots();
        motion.into_iter().flat_map(|x| [x[0] * roots[0], x[1] * roots[1]]).collect()
    }

    /// The loads as polynomials of the time after the epoch.
    pub(crate) fn loads(&self) -> [Poly; CHANNELS] {
        let mut loads = self.state.loads;
        if let Some(course) = self.course() {
            let [drive, anvil] = course.forces();
            (loads[Channel::Drive as usize], loads[Channel::Anvil as usize]) = (drive, anvil);
        }
        loads
    }

    /// Takes the motion of both bodies at the epoch from the modes.
    pub(super) fn follow_bodies(&mut self) {
        let all = Group { bodies: self.graph().all(), spring: None };
        let (roots, mut whole) = (self.roots(), [0.0; 4]);
        for (index, track) in self.tracks.iter().enumerate() {
            let part = self.body_state(track, index, 0.0);
            let (q, v) = part.split_at(part.len() / 2);
            let shared = self.graph().overlaps(self.state.anchors[index].group, all);
            shared.iter().for_each(|overlap| overlap.copy([q, v], &mut whole));
        }
        let of = |k: usize| [whole[k] / roots[0], whole[k + 1] / roots[1]];
        self.state.course = Some(Arc::new(Course::from(of(0), of(2))));
        self.state.anchors.clear();
        self.tracks.clear();
        for channel in [Channel::Drive, Channel::Anvil] {
            self.state.loads[channel as usize] = Poly::default();
        }
        self.steady = false;
    }

    /// Gives the motion of both bodies at the epoch back to the modes.
    ///
    /// # Errors
    /// Those of [`Model::system`](crate::modal::model::Model::system); nothing is changed then.
    pub(super) fn leave_bodies(&mut self) -> Result<(), Error> {
        let Some(course) = self.course() else { return Ok(()) };
        let whole = self.of_bodies(course.start());
        let mode = self.state.mode;
        let all = Group { bodies: self.graph().all(), spring: None };
        let groups = self.graph().groups(&mode);
        let system = |group: &Group| self.model.system(*group, mode);
        let systems = groups.iter().map(system).collect::<Result<Vec<_>, _>>()?;
        self.state.course = None;
        for (index, (group, system)) in groups.into_iter().zip(systems).enumerate() {
            let mut state = vec![0.0; 2 * system.modes()];
            let (q, v) = whole.split_at(whole.len() / 2);
            let shared = self.graph().overlaps(all, group);
            shared.iter().for_each(|overlap| overlap.copy([q, v], &mut state));
            self.state.anchors.push(Anchor::of(group));
            self.tracks.push(Track { system, z: Vec::new(), at: 0.0 });
            self.enter(index, group, &state)?;
        }
        Ok(())
    }

    /// Square roots of the masses of both bodies.
    fn roots(&self) -> [f64; 2] {
        self.masses().map(f64::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use crate::laws::event::Event;
    use crate::machine::Machine;
    use crate::quantities::inputs::Input;
    use crate::quantities::parameters::{Fidelity, InputValues, Parameters, Reloading, Source};
    use std::cell::Cell;

    thread_local! {
        /// True if rigid bodies are left to their modes.
        pub(super) static BY_MODES: Cell<bool> = const { Cell::new(false) };
    }

    /// Events and their instants in 0.1 s, and the positions and velocities at the end of each millisecond.
    fn run(
        parameters: &Parameters,
        supply: &[f64],
        by_modes: bool,
    ) -> (Vec<(Event, f64)>, Vec<[f64; 4]>) {
        BY_MODES.set(by_modes);
        let mut machine = Machine::new(parameters, &InputValues::default(), 0.0).expect("a scene");
        assert_eq!(machine.motion().course().is_some(), !by_modes);
        machine.keep_journal(true);
        if !supply.is_empty() {
            machine.set_input(Input::SupplyPressure, supply).expect("a pressure");
        }
        let mut places = Vec::new();
        for step in 1..=100 {
            machine.advance(1e-3 * f64::from(step)).expect("a step");
            let now = machine.kinematics();
            let (relative, tip) = (now.relative, now.tip);
            places.push([relative.displacement, tip.displacement, relative.velocity, tip.velocity]);
            let energies = machine.energies();
            assert!(energies.residual.abs() < 1e-12 * energies.turnover().max(1.0));
        }
        BY_MODES.set(false);
        let events = machine.take_journal().into_iter().map(|record| (record.event, record.time));
        (events.collect(), places)
    }

    /// Series and modes are two independent solutions of the same equations. At a small allowed error they have the same
    /// events, and differ by no more than that error may grow to in two blows: a thousand times.
    #[test]
    fn a_series_and_the_modes_give_the_same_motion() {
        let plain = {
            let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
            (p.drive.source, p.air.error) = (Source::Air, 1e-10);
            p
        };
        type Change = (fn(&mut Parameters), &'static [f64]);
        let changes: [Change; 8] = [
            (|_| {}, &[]),
            (|p| p.air.leakage_area = 2e-5, &[]),
            (|p| p.air.drag = 120.0, &[]),
            (|p| p.rock.reloading = Reloading::Unloading, &[]),
            (|p| (p.rock.viscosity, p.rock.energy_barrier) = (8e4, 3.0), &[]),
            (|p| p.air.returning.exhaust = p.air.returning.supply, &[]),
            (|p| p.gravity = -2.0, &[]),
            (|_| {}, &[9e5, 4e6, -3e7]),
        ];
        for (index, (change, supply)) in changes.into_iter().enumerate() {
            let mut parameters = plain;
            change(&mut parameters);
            let [(events, ours), (others, theirs)] =
                [false, true].map(|by_modes| run(&parameters, supply, by_modes));
            assert!(events.len() > 60, "{index}: {} events", events.len());
            assert_eq!(events.len(), others.len(), "{index}");
            for ((event, time), (other, at)) in events.iter().zip(&others) {
                // At the start a guard may lie at its level; then it crosses within its resolution.
                let allowed = if *time < 1e-5 { 1e-6 } else { 1e-9 };
                let same = event == other && (time - at).abs() < allowed;
                assert!(same, "{index}: {event} {time} {other} {at}");
            }
            for (one, other) in ours.iter().zip(&theirs) {
                let scales = [1e-3, 1e-3, 1.0, 1.0];
                for ((a, b), scale) in one.iter().zip(other).zip(scales) {
                    assert!((a - b).abs() < 1e-7 * scale, "{index}: {one:?} {other:?}");
                }
            }
        }
    }
}
