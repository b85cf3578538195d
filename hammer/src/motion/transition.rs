//! Transitions: how an event changes the mode, and how the state moves with it.
//!
//! At an event a track is converted to displacements and velocities of the bodies' modes, the law
//! changes, and the track is converted to the system of the new mode:
//!
//! ```text
//! tie       holds: [lower], [upper] -> [both]       opens: [both] -> [lower], [upper]
//! rock      spring and origin of the track that ends at the tip
//! drive     loads alone
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

/// Bound on the rounding of a transition, in half an `eps`. The state goes through two bases, each term with
/// [`combine::roundings`] (30 for a hundred modes), and is evaluated before and after; entries of the bases are
/// sums themselves. 190 roundings were observed. The search is correct for any value. A bound that is too low
/// would let a guard cross again at once, which Zeno detection turns into an error. A bound that is too high
/// would track a guard that starts so far above its level as if it started at it.
const LEFT: f64 = 256.0;

impl Motion {
    /// Makes the systems that a transition leads to, and changes nothing else.
    ///
    /// # Errors
    /// As [`Model::system`](crate::modal::model::Model::system).
    pub(crate) fn prepare(&self, event: Event) -> Result<(), Error> {
        let mut mode = self.state.mode;
        match event {
            Event::Tie(tie, to) => mode = mode.with(tie, to),
            Event::Rock(event) => {
                mode.rock = mode.rock.next(event, &self.state.memory, self.rock())
            }
            // The drive has no system of its own.
            _ => return Ok(()),
        }
        if self.graph().is_loose() {
            let stands = |group: &Group| self.state.anchors.iter().any(|a| a.group == *group);
            for group in self.graph().groups(&mode).into_iter().filter(|group| !stands(group)) {
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

    /// Transitions Q9 and Q10.
    pub(crate) fn switch_relay(&mut self) {
        self.state.mode.relay = self.state.mode.relay.turned();
        self.reload();
    }

    /// The piston passes the edge of a port, which is `opening` from there on.
    pub(crate) fn switch_port(&mut self, chamber: Chamber, port: Port, opening: Opening) {
        if let Some(air) = &mut self.state.air {
            air.openings[chamber as usize][port as usize] = opening;
        }
    }

    /// Begins or ends venting: the bit hangs out beyond the idle travel, or no longer does. Of a vented drive
    /// the chambers are at the exhaust's pressure.
    pub(crate) fn switch_vent(&mut self, vented: bool) {
        self.state.mode.vented = vented;
        self.state.mode.relay = Relay::Drive;
        self.change_air(|air, parameters, at, exhaust| air.vent(parameters, at, vented, exhaust));
    }

    /// The piston enters the end of an air hammer's cylinder, or leaves it.
    pub(crate) fn pass_end(&mut self, inside: bool) {
        let vented = self.state.mode.vented;
        self.change_air(|air, parameters, places, exhaust| {
            air.pass_end(parameters, places, [inside, vented], exhaust);
        });
    }

    /// The bodies of a tie meet or part. All tracks but that of a lone piston are at the epoch.
    pub(crate) fn switch_tie(&mut self, tie: Tie, to: TieState) -> Result<(), Error> {
        let Some(edge) = self.graph().edge(tie).copied() else { return Ok(()) };
        self.rotate_to_epoch(edge.ends);
        let ties = &mut self.state.mode.ties;
        let before = edge.law.offset(ties.of(tie));
        *ties = ties.with(tie, to);
        self.displace_beyond(&edge, edge.law.offset(to));
        self.regroup()?;
        self.displace_beyond(&edge, -before);
        Ok(())
    }

    /// Moves the bodies beyond a tie that is open now.
    fn displace_beyond(&mut self, edge: &Edge, by: f64) {
        for index in 0..self.tracks.len() {
            let group = self.state.anchors[index].group;
            if by != 0.0 && group.bodies.within(edge.beyond) {
                let root = self.root(group);
                self.state.anchors[index].driven.translation.0[0] += by * root;
            }
        }
    }

    /// Square root of a group's mass: the coordinate of a translation by 1 m.
    fn root(&self, group: Group) -> f64 {
        self.graph().mass(group.bodies).sqrt()
    }

    /// Assigns the bodies to the systems of the present ties. A group whose system stays the same is not
    /// touched.
    fn regroup(&mut self) -> Result<(), Error> {
        let groups = self.graph().groups(&self.state.mode);
        let gone = |index: &usize| !groups.contains(&self.state.anchors[*index].group);
        let from: Vec<Standing> =
            (0..self.tracks.len()).filter(gone).map(|index| self.standing(index)).collect();
        // Everything that may fail comes first, before any change.
        let system = |group: &Group| self.model.system(*group, self.state.mode);
        let systems = groups.iter().map(system).collect::<Result<Vec<_>, _>>()?;
        let most = groups.len();
        let mut tracks = std::mem::replace(&mut self.tracks, Vec::with_capacity(most));
        let mut anchors = std::mem::replace(&mut self.state.anchors, Vec::with_capacity(most));
        let mut made = vec![false; most];
        for ((made, &group), system) in made.iter_mut().zip(&groups).zip(systems) {
            if let Some(same) = anchors.iter().position(|anchor| anchor.group == group) {
                self.tracks.push(tracks.swap_remove(same));
                self.state.anchors.push(anchors.swap_remove(same));
                continue;
            }
            self.state.anchors.push(Anchor::of(group));
            self.tracks.push(Track { system, z: Vec::new(), at: 0.0 });
            *made = true;
        }
        for (index, &group) in groups.iter().enumerate().filter(|(index, _)| made[*index]) {
            let shares = |old: &&Standing| old.group.bodies.meet(group.bodies);
            let from: Vec<&Standing> = from.iter().filter(shares).collect();
            self.carry(index, group, &from, None)?;
        }
        Ok(())
    }

    /// Transitions Q1 to Q8. The tip's track is at the epoch.
    pub(crate) fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let steady = self.is_calm(0);
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
        for index in 1..self.tracks.len() {
            let root = self.root(self.state.anchors[index].group);
            let moved = &mut self.state.anchors[index].driven.translation;
            moved.0[0] -= transition.shift * root;
        }
        let group = self.graph().at_tip(&self.state.mode);
        let from = self.state.anchors[0].group;
        if steady && let Some(way) = self.model.passage(from, group, self.state.mode)? {
            return self.pass(group, &way, transition);
        }
        let before = self.standing(0);
        self.carry(0, group, &[&before], Some(transition))
    }

    /// The tip's displacement at the epoch, and the part of it that does not oscillate.
    fn tip(&self, steady: bool) -> [f64; 2] {
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = self.graph().share(anchor.group, Displacement::Tip) else {
            return [0.0; 2];
        };
        let functional = &track.system.functionals[tip];
        let drift = if steady {
            let moved = functional.rigid * anchor.driven.translation.0[0];
            moved + functional.strain(&self.state.loads)
        } else {
            self.poly(0, tip).0[0]
        };
        [drift + kernel::dot(&functional.rows[0], &track.z), drift]
    }

    /// Bound on the rounding of the tip's displacement.
    fn tip_rounding(&self, drift: f64) -> f64 {
        let (track, anchor) = (&self.tracks[0], &self.state.anchors[0]);
        let Some(tip) = self.graph().share(anchor.group, Displacement::Tip) else { return 0.0 };
        let weights = &track.system.functionals[tip].weights[0];
        let terms = drift.abs() + kernel::bound(weights, &track.z);
        0.5 * f64::EPSILON * combine::roundings(track.z.len()) as f64 * terms
    }

    /// Moves the tip's track to the system of `group` without its static part, which constant loads produce
    /// before and after.
    fn pass(&mut self, group: Group, way: &Passage, moved: Transition) -> Result<(), Error> {
        let system = self.model.system(group, self.state.mode)?;
        let loads = self.state.loads.each_ref().map(|load| load.0[0]);
        let (track, anchor) = (&mut self.tracks[0], &mut self.state.anchors[0]);
        let mut old = std::mem::take(&mut track.z);
        track.system.add_translation(&anchor.driven, &mut old);
        let mut y = std::mem::take(&mut anchor.z);
        y.resize(2 * system.blocks(), 0.0);
        way.apply_moving(&old, loads, &mut y);
        anchor.z = old; // Its memory is reused.
        if moved.shift != 0.0 {
            self.displace(group, &system, -moved.shift, &mut y);
            if let Some(tip) = self.graph().share(group, Displacement::Tip) {
                let strain = system.functionals[tip].strain(&self.state.loads);
                let off = moved.tip - system.displacement(tip, &y) - strain;
                self.displace(group, &system, off, &mut y);
            }
        }
        let driven = system.take_translation(&self.state.loads, &mut y);
        self.settle(0, group, system, y, driven);
        Ok(())
    }

    /// The state of track `index` at the epoch.
    fn standing(&self, index: usize) -> Standing {
        let (track, anchor) = (&self.tracks[index], &self.state.anchors[index]);
        let (system, mut y) = (track.system.clone(), track.z.clone());
        system.add_driven(&self.state.loads, &anchor.driven, 0.0, &mut y);
        Standing { group: anchor.group, system, y, bodies: OnceCell::new() }
    }

    /// Moves track `index` to the system of `group`, with the state of its bodies `from`. A transition of the
    /// rock also moves the origin of displacements.
    fn carry(
        &mut self,
        index: usize,
        group: Group,
        from: &[&Standing],
        moved: Option<Transition>,
    ) -> Result<(), Error> {
        let system = self.model.system(group, self.state.mode)?;
        let mut y = vec![0.0; 2 * system.blocks()];
        let shift = moved.map_or(0.0, |transition| transition.shift);
        if !self.carry_straight(group, from, &mut y)? {
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
        if let Some(transition) = moved.filter(|_| shift != 0.0) {
            // For a deep hole and a small force the rounding of the depth makes the shift uncertain.
            if let Some(tip) = self.graph().share(group, Displacement::Tip) {
                let off = transition.tip - system.displacement(tip, &y);
                self.displace(group, &system, off, &mut y);
            }
        }
        let driven = system.take_driven(&self.state.loads, &mut y);
        self.settle(index, group, system, y, driven);
        Ok(())
    }

    /// Moves all bodies of a group.
    fn displace(&self, group: Group, system: &System, by: f64, y: &mut [f64]) {
        let each = self.translations(group);
        each.for_each(|(mode, root)| system.displace(mode, by * root, y));
    }

    /// Writes to `y` the sum of the contributions of `from`, converted directly between the bases. Returns
    /// false if there is no direct conversion; then `y` must be computed through the bodies' modes.
    fn carry_straight(
        &self,
        group: Group,
        from: &[&Standing],
        y: &mut [f64],
    ) -> Result<bool, Error> {
        let way = |old: &Standing| self.model.passage(old.group, group, self.state.mode);
        let [first, others @ ..] = from else { return Ok(true) };
        let Some(straight) = way(first)? else { return Ok(false) };
        straight.apply(&first.y, y);
        for old in others {
            let Some(straight) = way(old)? else { return Ok(false) };
            let mut part = vec![0.0; y.len()];
            straight.apply(&old.y, &mut part);
            kernel::add(y, 1.0, &part);
        }
        Ok(true)
    }

    /// Bound on the rounding of a functional at the start of track `index`, of a displacement (`order` 0) or a
    /// velocity (1): [`LEFT`] roundings, plus the effect of the basis's mismatch, of everything that the modes
    /// contribute.
    pub(crate) fn rounding(&self, index: usize, functional: usize, order: usize) -> f64 {
        let (track, anchor) = (self.at_anchor(index), &self.state.anchors[index]);
        let (system, standing) = (&track.system, self.standing(index));
        let state = self.body_state(&track, index, anchor.at);
        let (displacements, velocities) = state.split_at(state.len() / 2);
        let modes = self.ends(anchor.group);
        let rates = modes.iter().map(|[_, rate]| *rate);
        let slowest = rates.filter(|rate| *rate > 0.0).fold(f64::INFINITY, f64::min);
        let static_bound =
            kernel::bound(&system.functionals[functional].weights[order], &standing.y);
        let [mut sum, mut swing, mut all] = [static_bound, 0.0f64, 0.0];
        for ((q, v), [end, rate]) in displacements.iter().zip(velocities).zip(&modes) {
            // A basis mixes displacements and velocities.
            let (speed, slow) = (v.abs() + rate * q.abs(), rate.max(slowest));
            sum += end * if order == 0 { q.abs() + v.abs() / slow } else { speed };
            swing = swing.max(speed);
            all += end / if order == 0 { slow } else { 1.0 };
        }
        LEFT * f64::EPSILON * sum + system.mismatch() * (swing * all + static_bound)
    }

    /// Overlap of the bodies that rounding cannot distinguish from a gap, m.
    pub(crate) fn least_overlap(&self) -> f64 {
        self.resolved(Displacement::Tie(Tie::Contact))
    }

    /// Resolution of a displacement by rounding and guards, m.
    pub(crate) fn resolved(&self, displacement: Displacement) -> f64 {
        let tracks = 0..self.tracks.len();
        let shares = tracks.filter_map(|i| Some((i, self.share(i, displacement)?)));
        let rounding: f64 = shares.map(|(index, share)| self.rounding(index, share, 0)).sum();
        rounding.max(self.model.resolutions[0])
    }

    /// The uniform translation of each body of a group: its mode, and the square root of the body's mass.
    fn translations(&self, group: Group) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        let bodies = self.graph().bodies_of(group.bodies);
        bodies.map(|(_, first, body)| (first, body.mass.sqrt()))
    }

    /// Of each free mode of a group: largest amplitude at a body's end (kg^-1/2), and frequency (rad/s).
    fn ends(&self, group: Group) -> Vec<[f64; 2]> {
        let modes = self.graph().bodies_of(group.bodies).flat_map(|(_, _, bar)| {
            let ends = bar.top.iter().zip(&bar.bottom).zip(&bar.omega2);
            ends.map(|((top, bottom), w2)| [top.abs().max(bottom.abs()), w2.sqrt()])
        });
        modes.collect()
    }

    /// Puts a group with `[q | q']` of its bodies on its system, at the epoch.
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

    /// Puts a track on a system at the epoch: takes the polynomial part of the motion out of `z`.
    fn settle(
        &mut self,
        index: usize,
        group: Group,
        system: Arc<System>,
        z: Vec<f64>,
        driven: Driven,
    ) {
        // If the motion was steady and this track is a parabola, it still is; otherwise all tracks are examined.
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

/// The state of a track at an instant, including the motion by the loads.
struct Standing {
    group: Group,
    system: Arc<System>,
    y: Vec<f64>,
    bodies: OnceCell<Vec<f64>>,
}

impl Standing {
    /// The state in the bodies' modes, converted once for all groups that take over a part of it.
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

    /// A scene of unequal bodies in which all times are `slow` times as long.
    fn slower(slow: f64) -> Motion {
        let mut p = Parameters::default();
        (p.piston.length, p.piston.initial_velocity) = (0.17, 8.0 / slow);
        let inputs = InputValues { feed_force: 5e3 / (slow * slow), ..InputValues::default() };
        for value in [&mut p.contact.stiffness, &mut p.rock.stiffness, &mut p.gravity] {
            *value /= slow * slow;
        }
        p.material.youngs_modulus /= slow * slow;
        p.material.damping_time *= slow;
        p.rock.viscosity /= slow;
        let model = Model::new(&p).expect("a model");
        Motion::new(model, Inputs::constant(&inputs), 0.0).expect("a scene")
    }

    /// A bound on a displacement does not depend on the unit of time; one on a velocity scales with its
    /// inverse. A factor that is a power of two scales all numbers exactly, except those of the decompositions.
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
