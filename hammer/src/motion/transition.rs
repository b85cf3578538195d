//! Transitions: how an event changes the mode and the state.
//!
//! At an event the state of a track is converted to displacements and velocities of the bodies' modes, the law changes,
//! and the state is converted to the system of the new mode. The parts of the state that change are
//!
//! ```text
//! tie       the groups. It holds: [lower], [upper] -> [both].  It opens: [both] -> [lower], [upper]
//! rock      spring and origin of the track that ends at the tip
//! drive     only the loads
//! ```

use super::Motion;
use crate::error::Error;
use crate::laws::air::Opening;
use crate::laws::event::{Displacement, Event, RockEvent};
use crate::laws::mode::{Chamber, Port, Relay, Tie, TieState};
use crate::laws::rock::{Spring, Transition};
use crate::modal::system::System;
use crate::modal::system::driven::Driven;
use crate::modal::system::passage::Passage;
use crate::modal::track::Track;
use crate::motion::state::Anchor;
use crate::numerics::{combine, kernel};
use crate::quantities::parameters::Rock;
use crate::scene::graph::{Edge, Group};
use std::cell::OnceCell;
use std::sync::Arc;

/// Bound on the number of roundings in a transition, each of half an `eps`. The state is converted with two bases, and
/// it is evaluated before and after. Each basis rounds a term [`combine::roundings`] times (30 for a hundred modes),
/// and its entries are sums themselves. 190 roundings were observed. The search is correct with any value. If the bound
/// is too low, a guard may cross again at once, which Zeno detection turns into an error. If it is too high, a guard
/// that starts above its level by less than the bound is treated as if it started at its level.
const ROUNDINGS: f64 = 256.0;

impl Motion {
    /// Makes the systems that a transition needs, and changes nothing else.
    ///
    /// # Errors
    /// Those of [`Model::system`](crate::modal::model::Model::system).
    pub(crate) fn prepare(&self, event: Event) -> Result<(), Error> {
        let mut mode = self.state.mode;
        match event {
            Event::Tie(tie, to) => mode = mode.with(tie, to),
            Event::Rock(event) => {
                mode.rock = mode.rock.next(event, &self.state.memory, self.rock())
            }
            // Events of the drive change no system.
            _ => return Ok(()),
        }
        if self.course().is_some() {
            if self.follows(&mode) {
                return Ok(());
            }
            let groups = self.graph().groups(&mode);
            return groups
                .into_iter()
                .try_for_each(|group| self.model.system(group, mode).map(drop));
        }
        if self.graph().is_loose() {
            let exists = |group: &Group| self.state.anchors.iter().any(|a| a.group == *group);
            for group in self.graph().groups(&mode).into_iter().filter(|group| !exists(group)) {
                self.model.system(group, mode)?;
            }
        }
        let system = self.model.system(self.graph().at_tip(&mode), mode)?;
        if Spring::of(mode.rock).coefficients(self.rock()).viscosity > 0.0 {
            system.prepare_viscous_form()?;
        }
        Ok(())
    }

    fn rock(&self) -> &Rock {
        &self.model.parameters.rock
    }

    /// Makes transition Q9 or Q10: the relay switches.
    pub(crate) fn switch_relay(&mut self) {
        self.state.mode.relay = self.state.mode.relay.turned();
        self.reload();
    }

    /// Makes the transition in which the piston passes the edge of a port. From there on the state of the port is
    /// `opening`.
    pub(crate) fn switch_port(&mut self, chamber: Chamber, port: Port, opening: Opening) {
        if let Some(air) = &mut self.state.air {
            air.openings[chamber as usize][port as usize] = opening;
        }
    }

    /// Begins or ends venting. The drive is vented while the bit hangs out beyond the idle travel; its chambers then
    /// have the exhaust's pressure.
    pub(crate) fn switch_vent(&mut self, vented: bool) {
        self.state.mode.vented = vented;
        self.state.mode.relay = Relay::Drive;
        self.change_air(|air, parameters, positions, exhaust| {
            air.vent(parameters, positions, vented, exhaust);
        });
    }

    /// Makes the transition in which the piston enters or leaves the end of an air hammer's cylinder.
    pub(crate) fn pass_end(&mut self, inside: bool) {
        let vented = self.state.mode.vented;
        self.change_air(|air, parameters, positions, exhaust| {
            air.pass_end(parameters, positions, [inside, vented], exhaust);
        });
    }

    /// Makes the transition in which the bodies of a tie meet or part. All tracks must be at the epoch, except that of
    /// a piston that flies alone.
    pub(crate) fn switch_tie(&mut self, tie: Tie, to: TieState) -> Result<(), Error> {
        let Some(edge) = self.graph().edge(tie).copied() else { return Ok(()) };
        self.rotate_to_epoch(edge.ends);
        let ties = &mut self.state.mode.ties;
        let before = edge.law.offset(ties.of(tie));
        *ties = ties.with(tie, to);
        if self.course().is_some() {
            return Ok(());
        }
        self.displace_beyond(&edge, edge.law.offset(to));
        self.regroup()?;
        self.displace_beyond(&edge, -before);
        Ok(())
    }

    /// Displaces the bodies beyond a tie that is open now by `distance` (m).
    fn displace_beyond(&mut self, edge: &Edge, distance: f64) {
        for index in 0..self.tracks.len() {
            let group = self.state.anchors[index].group;
            if distance != 0.0 && group.bodies.within(edge.beyond) {
                let root = self.root_mass(group);
                self.state.anchors[index].driven.translation.0[0] += distance * root;
            }
        }
    }

    /// Square root of a group's mass, which is the coordinate of a translation by 1 m.
    fn root_mass(&self, group: Group) -> f64 {
        self.graph().mass(group.bodies).sqrt()
    }

    /// Assigns the bodies to the groups of the present ties. A group that stays the same is not changed.
    fn regroup(&mut self) -> Result<(), Error> {
        let groups = self.graph().groups(&self.state.mode);
        let ends = |index: &usize| !groups.contains(&self.state.anchors[*index].group);
        let from: Vec<TrackState> =
            (0..self.tracks.len()).filter(ends).map(|index| self.track_state(index)).collect();
        // Everything that may fail comes first, before any change.
        let system = |group: &Group| self.model.system(*group, self.state.mode);
        let systems = groups.iter().map(system).collect::<Result<Vec<_>, _>>()?;
        let count = groups.len();
        let mut tracks = std::mem::replace(&mut self.tracks, Vec::with_capacity(count));
        let mut anchors = std::mem::replace(&mut self.state.anchors, Vec::with_capacity(count));
        let mut is_new = vec![false; count];
        for ((is_new, &group), system) in is_new.iter_mut().zip(&groups).zip(systems) {
            if let Some(same) = anchors.iter().position(|anchor| anchor.group == group) {
                self.tracks.push(tracks.swap_remove(same));
                self.state.anchors.push(anchors.swap_remove(same));
                continue;
            }
            self.state.anchors.push(Anchor::of(group));
            self.tracks.push(Track { system, z: Vec::new(), at: 0.0 });
            *is_new = true;
        }
        for (index, &group) in groups.iter().enumerate().filter(|(index, _)| is_new[*index]) {
            let shares = |old: &&TrackState| old.group.bodies.meet(group.bodies);
            let from: Vec<&TrackState> = from.iter().filter(shares).collect();
            self.convert(index, group, &from, None)?;
        }
        Ok(())
    }

    /// Makes the transitions Q1 to Q8. The tip's track must be at the epoch.
    pub(crate) fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let steady = self.course().is_none() && self.is_calm(0);
        let is_turn = matches!(event, RockEvent::DissipativeTurn | RockEvent::Turn);
        let [p, drift] = self.tip(steady);
        // Only these events need the uncertainty of the position.
        let error = if is_turn { self.tip_rounding(drift) } else { 0.0 };
        let before = self.spring();
        let (from, rock) = (self.state.mode.rock, &self.model.parameters.rock);
        let transition = self.state.memory.transit(from, event, p, error, rock);
        self.state.mode.rock = transition.mode;
        if !(from.is_viscous() && transition.mode.is_viscous()) {
            self.state.psi = 0.0;
        }
        let after = Spring::of(transition.mode);
        if before == after && transition.shift == 0.0 {
            return Ok(());
        }
        self.state.origin.move_by(transition.shift);
        if let Some(course) = &mut self.state.course {
            Arc::make_mut(course).move_origin(transition.shift, transition.tip);
            return Ok(());
        }
        for index in 1..self.tracks.len() {
            let root = self.root_mass(self.state.anchors[index].group);
            let translation = &mut self.state.anchors[index].driven.translation;
            translation.0[0] -= transition.shift * root;
        }
        let group = self.graph().at_tip(&self.state.mode);
        let from = self.state.anchors[0].group;
        if steady && let Some(passage) = self.model.passage(from, group, self.state.mode)? {
            return self.pass(group, &passage, transition);
        }
        let before = self.track_state(0);
        self.convert(0, group, &[&before], Some(transition))
    }

    /// The tip's displacement at the epoch, and the part of it that does not oscillate.
    fn tip(&self, steady: bool) -> [f64; 2] {
        if let Some(course) = self.course() {
            return [course.rows[0][1]; 2];
        }
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = self.graph().share(anchor.group, Displacement::Tip) else {
            return [0.0; 2];
        };
        let functional = &track.system.functionals[tip];
        let drift = if steady {
            let translation = functional.rigid * anchor.driven.translation.0[0];
            translation + functional.strain(&self.state.loads)
        } else {
            self.poly(0, tip).0[0]
        };
        [drift + kernel::dot(&functional.rows[0], &track.z), drift]
    }

    /// Bound on the rounding of the tip's displacement, m. `drift` is the part of the displacement that does not
    /// oscillate.
    fn tip_rounding(&self, drift: f64) -> f64 {
        if let Some(course) = self.course() {
            return course.rounding[0];
        }
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = self.graph().share(anchor.group, Displacement::Tip) else { return 0.0 };
        let weights = &track.system.functionals[tip].weights[0];
        let terms = drift.abs() + kernel::bound(weights, &track.z);
        0.5 * f64::EPSILON * combine::roundings(track.z.len()) as f64 * terms
    }

    /// Converts the tip's track to the system of `group` by a direct passage, under constant loads. The static part is
    /// not converted, since these loads also produce it in the new system.
    fn pass(
        &mut self,
        group: Group,
        passage: &Passage,
        transition: Transition,
    ) -> Result<(), Error> {
        let system = self.model.system(group, self.state.mode)?;
        let loads = self.state.loads.each_ref().map(|load| load.0[0]);
        let (track, anchor) = (&mut self.tracks[0], &mut self.state.anchors[0]);
        let mut old = std::mem::take(&mut track.z);
        track.system.add_translation(&anchor.driven, &mut old);
        let mut y = std::mem::take(&mut anchor.z);
        y.resize(2 * system.blocks(), 0.0);
        passage.apply_moving(&old, loads, &mut y);
        anchor.z = old; // The memory of the old vector is reused.
        if transition.shift != 0.0 {
            self.displace(group, &system, -transition.shift, &mut y);
            if let Some(tip) = self.graph().share(group, Displacement::Tip) {
                let strain = system.functionals[tip].strain(&self.state.loads);
                let correction = transition.tip - system.displacement(tip, &y) - strain;
                self.displace(group, &system, correction, &mut y);
            }
        }
        let driven = system.take_translation(&self.state.loads, &mut y);
        self.settle(0, group, system, y, driven);
        Ok(())
    }

    /// The state of track `index` at the epoch.
    fn track_state(&self, index: usize) -> TrackState {
        let (track, anchor) = (&self.tracks[index], &self.state.anchors[index]);
        let (system, mut y) = (track.system.clone(), track.z.clone());
        system.add_driven(&self.state.loads, &anchor.driven, 0.0, &mut y);
        TrackState { group: anchor.group, system, y, bodies: OnceCell::new() }
    }

    /// Puts track `index` on the system of `group`, with the state that the group's bodies have in `from`. A transition
    /// of the rock also moves the origin of displacements.
    fn convert(
        &mut self,
        index: usize,
        group: Group,
        from: &[&TrackState],
        transition: Option<Transition>,
    ) -> Result<(), Error> {
        let system = self.model.system(group, self.state.mode)?;
        let mut y = vec![0.0; 2 * system.blocks()];
        let shift = transition.map_or(0.0, |transition| transition.shift);
        if !self.convert_directly(group, from, &mut y)? {
            let mut state = vec![0.0; 2 * system.modes()];
            for old in from {
                let (q, v) = old.bodies().split_at(old.system.modes());
                let shared = self.graph().overlaps(old.group, group);
                shared.iter().for_each(|overlap| overlap.copy([q, v], &mut state));
            }
            self.translations(group).for_each(|(mode, root)| state[mode] -= shift * root);
            system.to_modal(&state, &mut y);
        } else if shift != 0.0 {
            self.displace(group, &system, -shift, &mut y);
        }
        if let Some(transition) = transition.filter(|_| shift != 0.0) {
            // In a deep hole, if the force is small, the rounding of the depth makes the shift uncertain. The tip's new
            // position is known more accurately.
            if let Some(tip) = self.graph().share(group, Displacement::Tip) {
                let correction = transition.tip - system.displacement(tip, &y);
                self.displace(group, &system, correction, &mut y);
            }
        }
        let driven = system.take_driven(&self.state.loads, &mut y);
        self.settle(index, group, system, y, driven);
        Ok(())
    }

    /// Displaces all bodies of a group by `distance` (m) in the modal state `y`.
    fn displace(&self, group: Group, system: &System, distance: f64, y: &mut [f64]) {
        let translations = self.translations(group);
        translations.for_each(|(mode, root)| system.displace(mode, distance * root, y));
    }

    /// Writes to `y` the sum of the states in `from`, converted by direct passages. Returns false if a passage is
    /// missing; then `y` must be computed through the bodies' modes.
    fn convert_directly(
        &self,
        group: Group,
        from: &[&TrackState],
        y: &mut [f64],
    ) -> Result<bool, Error> {
        let passage = |old: &TrackState| self.model.passage(old.group, group, self.state.mode);
        let [first, others @ ..] = from else { return Ok(true) };
        let Some(direct) = passage(first)? else { return Ok(false) };
        direct.apply(&first.y, y);
        for old in others {
            let Some(direct) = passage(old)? else { return Ok(false) };
            let mut part = vec![0.0; y.len()];
            direct.apply(&old.y, &mut part);
            kernel::add(y, 1.0, &part);
        }
        Ok(true)
    }

    /// Bound on the rounding of a functional at the start of track `index`: of the displacement (`order` 0) or of the
    /// velocity (`order` 1). It covers [`ROUNDINGS`] roundings of everything that the modes contribute, and the effect
    /// of the basis's mismatch.
    pub(crate) fn rounding(&self, index: usize, functional: usize, order: usize) -> f64 {
        let (track, anchor) = (self.at_anchor(index), &self.state.anchors[index]);
        let (system, whole) = (&track.system, self.track_state(index));
        let state = self.body_state(&track, index, anchor.at);
        let (displacements, velocities) = state.split_at(state.len() / 2);
        let modes = self.ends(anchor.group);
        let rates = modes.iter().map(|[_, rate]| *rate);
        let slowest = rates.filter(|rate| *rate > 0.0).fold(f64::INFINITY, f64::min);
        let static_bound = kernel::bound(&system.functionals[functional].weights[order], &whole.y);
        let [mut sum, mut swing, mut all] = [static_bound, 0.0f64, 0.0];
        for ((q, v), [end, rate]) in displacements.iter().zip(velocities).zip(&modes) {
            // A basis mixes displacements and velocities.
            let (speed, slow) = (v.abs() + rate * q.abs(), rate.max(slowest));
            sum += end * if order == 0 { q.abs() + v.abs() / slow } else { speed };
            swing = swing.max(speed);
            all += end / if order == 0 { slow } else { 1.0 };
        }
        ROUNDINGS * f64::EPSILON * sum + system.mismatch() * (swing * all + static_bound)
    }

    /// Largest overlap of piston and bit that rounding cannot distinguish from a gap, m.
    pub(crate) fn least_overlap(&self) -> f64 {
        self.resolved(Displacement::Tie(Tie::Contact))
    }

    /// Resolution of a displacement, m: its rounding, or the resolution of guards if that is larger.
    pub(crate) fn resolved(&self, displacement: Displacement) -> f64 {
        let tracks = 0..self.tracks.len();
        let shares = tracks.filter_map(|i| Some((i, self.share(i, displacement)?)));
        let rounding: f64 = shares.map(|(index, share)| self.rounding(index, share, 0)).sum();
        rounding.max(self.model.resolutions[0])
    }

    /// For each body of a group, the index of its uniform translation among the modes, and the square root of its mass.
    fn translations(&self, group: Group) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        let bodies = self.graph().bodies_of(group.bodies);
        bodies.map(|(_, first, body)| (first, body.mass.sqrt()))
    }

    /// For each free mode of a group, the larger amplitude at its body's two ends (kg^-1/2) and its frequency (rad/s).
    fn ends(&self, group: Group) -> Vec<[f64; 2]> {
        let modes = self.graph().bodies_of(group.bodies).flat_map(|(_, _, bar)| {
            let ends = bar.top.iter().zip(&bar.bottom).zip(&bar.omega2);
            ends.map(|((top, bottom), w2)| [top.abs().max(bottom.abs()), w2.sqrt()])
        });
        modes.collect()
    }

    /// Puts a group at the epoch on its system, with the state `[q | q']` of its bodies.
    pub(super) fn enter(
        &mut self,
        index: usize,
        group: Group,
        body_state: &[f64],
    ) -> Result<(), Error> {
        let system = self.model.system(group, self.state.mode)?;
        let mut z = vec![0.0; 2 * system.blocks()];
        system.to_modal(body_state, &mut z);
        let driven = system.take_driven(&self.state.loads, &mut z);
        self.settle(index, group, system, z, driven);
        Ok(())
    }

    /// Puts a track on a system at the epoch, with the modal vector `z` and the polynomial part `driven` of the motion.
    fn settle(
        &mut self,
        index: usize,
        group: Group,
        system: Arc<System>,
        z: Vec<f64>,
        driven: Driven,
    ) {
        // If the motion was steady and this track is a parabola, the motion is still steady. Otherwise all tracks are
        // examined.
        let parabolic = driven.is_parabola();
        let anchor = &mut self.state.anchors[index];
        anchor.driven = driven;
        anchor.group = group;
        anchor.at = 0.0;
        anchor.z.clone_from(&z);
        self.tracks[index] = Track { system, z, at: 0.0 };
        self.basis_changes += 1;
        self.steady = self.steady && parabolic || self.state.is_steady();
        if group == Group::PISTON {
            self.state.anchors[index].form = self.damping_form(&self.tracks[index]);
        }
    }
}

/// The whole state of a track, including the polynomial part that loads cause.
struct TrackState {
    group: Group,
    system: Arc<System>,
    y: Vec<f64>,
    bodies: OnceCell<Vec<f64>>,
}

impl TrackState {
    /// The state in the bodies' modes. It is converted once, for all groups that take over a part of it.
    fn bodies(&self) -> &[f64] {
        self.bodies.get_or_init(|| {
            let mut state = vec![0.0; 2 * self.system.modes()];
            self.system.to_bodies(&self.y, &mut state);
            state
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::model::Model;
    use crate::quantities::inputs::Inputs;
    use crate::quantities::parameters::{InputValues, Parameters};

    /// A scene of unequal bodies in which all times are longer by `factor`.
    fn slower(factor: f64) -> Motion {
        let mut p = Parameters::default();
        (p.piston.length, p.piston.initial_velocity) = (0.17, 8.0 / factor);
        let inputs = InputValues { feed_force: 5e3 / (factor * factor), ..InputValues::default() };
        for value in [&mut p.contact.stiffness, &mut p.rock.stiffness, &mut p.gravity] {
            *value /= factor * factor;
        }
        p.material.youngs_modulus /= factor * factor;
        p.material.damping_time *= factor;
        p.rock.viscosity /= factor;
        let model = Model::new(&p).expect("a model");
        Motion::new(model, Inputs::constant(&inputs), 0.0).expect("a scene")
    }

    /// A bound on a displacement does not depend on the unit of time; a bound on a velocity scales with its inverse.
    /// The factor is a power of two, which scales all numbers exactly, except those of the decompositions.
    #[test]
    fn the_bound_on_rounding_has_the_unit_of_what_it_bounds() {
        let (quick, slow) = (slower(1.0), slower(1024.0));
        for (index, track) in quick.tracks.iter().enumerate() {
            for functional in 0..track.system.functionals.len() {
                for (order, scale) in [(0, 1.0), (1, 1024.0)] {
                    let [a, b] = [&quick, &slow].map(|m| m.rounding(index, functional, order));
                    assert!(
                        a > 0.0 && (scale * b / a - 1.0).abs() < 1e-6,
                        "{index} {order}: {a} {b}"
                    );
                }
            }
        }
    }
}
