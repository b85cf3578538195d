//! The hammer in motion: its state at the last event, and values at any later instant.
//!
//! **The state lives at the last event**, the *epoch*. Between events the hammer is linear with
//! constant coefficients, so the state at any later instant is a formula:
//!
//! ```text
//! y(t) = exp(B (t - at)) z + static and translating parts,        u = shapes . y
//! ```
//!
//! Here `z` is the modal vector of an [`Anchor`] at its instant `at`. There are two anchors (bit and
//! piston) while the contact is open, and one while it is closed. Displacements are measured from the *origin*, the
//! zero of the present rock line, and times from the epoch; origin and epoch are stored in double-double precision. The
//! stored displacement of the piston is its displacement minus `g0`, so that the gap is a simple difference.

mod air;
mod line;
mod rigid;
mod start;
pub mod state;
mod tracks;
mod transition;

pub(crate) use crate::air::course::{Bounds, CURVES, Course};
pub(crate) use crate::air::part::Part;

use crate::air::series::Series;
use crate::air::steel::Steel;
use crate::air::{Places, Window};
use crate::error::Error;
use crate::laws::event::{Bodies, Displacement, Event};
use crate::laws::mode::{Mode, Tie};
use crate::laws::rock::{Coefficients, Spring};
use crate::modal::model::Model;
use crate::modal::stretch::Stretch;
use crate::modal::track::Track;
use crate::numerics::{instant::Double, kernel, poly::Poly};
use crate::quantities::{inputs::Input, parameters::Parameters};
use crate::scene::graph::CHANNELS;
use crate::scene::graph::{Edge, Graph, Group};
use state::{Anchor, Milestone, MotionState};
use std::sync::Arc;

/// A displacement and its first two rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PointMotion {
    /// m.
    pub displacement: f64,
    /// m/s.
    pub velocity: f64,
    /// m/s2.
    pub acceleration: f64,
}

/// Model, state at the epoch, and the tracks by which it is evaluated later.
#[derive(Clone, Debug)]
pub struct Motion {
    pub(crate) model: Model,
    pub(crate) state: MotionState,
    /// The tracks as the search left them: each is the vector of an anchor, rotated to an instant at or after the
    /// anchor's.
    pub(crate) tracks: Vec<Track>,
    /// Result of [`MotionState::is_steady`] for `state`.
    steady: bool,
    /// True if no input varies.
    still: bool,
    pub(crate) basis_changes: u64,
    /// Storage for the coordinates that are expanded with the air, for its series, and for its next window.
    steel: Steel,
    series: Option<Box<Series>>,
    window: Option<Box<Window>>,
    /// Polynomials of displacements in a window of the air: track, functional, and the result of [`Self::poly`].
    polys: Vec<(usize, usize, Poly)>,
    /// The piston's positions in the cylinder and their rates at the last move of the epoch. The window that begins
    /// there uses them.
    cylinder: Option<[Places; 2]>,
}

impl Motion {
    /// Continues from a stored state of a scene with these parameters.
    ///
    /// # Errors
    /// A state that does not fit the parameters' dimensions; nothing is changed then.
    pub(crate) fn restore(
        &mut self,
        parameters: &Parameters,
        state: &MotionState,
        basis_changes: u64,
    ) -> Result<(), Error> {
        let other = *parameters != self.model.parameters;
        let fresh = if other { Some(Model::new(parameters)?) } else { None };
        let tracks = state.tracks(fresh.as_ref().unwrap_or(&self.model))?;
        if let Some(model) = fresh {
            self.model = model;
        }
        (self.tracks, self.state, self.basis_changes) = (tracks, state.clone(), basis_changes);
        self.cylinder = None;
        self.polys.clear();
        self.steady = self.state.is_steady();
        self.still = self.state.inputs.are_constant();
        Ok(())
    }

    /// Parameters, with the present tunable values.
    pub(crate) fn parameters(&self) -> &Parameters {
        &self.model.parameters
    }

    /// True if no load varies and the polynomial part of the motion is at most a parabola.
    #[inline]
    pub(crate) fn is_steady(&self) -> bool {
        debug_assert_eq!(self.steady, self.state.is_steady());
        self.steady
    }

    /// True if no load that acts on track `index` varies, and the polynomial part of its motion is at
    /// most a parabola.
    #[inline]
    pub(crate) fn is_calm(&self, index: usize) -> bool {
        let is_calm = || {
            !self.tracks[index].system.varies(&self.state.loads)
                && self.state.anchors[index].driven.is_parabola()
        };
        self.is_steady() || is_calm()
    }

    pub(crate) fn mode(&self) -> Mode {
        self.state.mode
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.model.graph
    }

    /// Each tie that holds, with its stiffness and viscosity.
    pub(crate) fn ties(&self) -> impl Iterator<Item = (&Edge, Coefficients)> {
        self.graph().holding(self.state.mode.ties)
    }

    /// Constant offset of a displacement from the one that the engine stores, m.
    pub(crate) fn ahead(&self, displacement: Displacement) -> f64 {
        if self.course().is_some() {
            return 0.0; // A contact is never pulled.
        }
        self.graph().ahead(displacement, &self.state.mode.ties)
    }

    /// The track of the piston, while it flies alone.
    pub(crate) fn flying(&self) -> Option<usize> {
        self.state.anchors.iter().position(|anchor| anchor.group == Group::PISTON)
    }

    /// Bodies of the groups whose ledger interval ends at an event, or at an epoch without event. These are all bodies,
    /// unless the scene is a string with loose joints under constant loads. Then they are those that the event touches,
    /// those at the tip, and those of a closed tie whose largest force is an output.
    pub(crate) fn touched(&self, event: Option<Event>) -> Bodies {
        let graph = self.graph();
        let ends = match event.filter(|_| graph.is_loose() && self.is_steady()) {
            Some(Event::Tie(tie, _)) => graph.edge(tie).map_or(graph.all(), |edge| edge.ends),
            Some(Event::Rock(_)) => Bodies::default(),
            _ => return graph.all(),
        };
        let is_asked = |edge: &Edge| Tie::REPORTED.contains(&edge.tie);
        let asked = self.ties().map(|(edge, _)| edge).filter(|edge| is_asked(edge));
        asked.fold(ends.and(Bodies::one(graph.bit)), |all, edge| all.and(edge.ends))
    }

    /// Tracks of these bodies, except the tip's track and that of a lone piston.
    pub(crate) fn others(&self, bodies: Bodies) -> impl Iterator<Item = usize> {
        let anchors = self.state.anchors.iter().enumerate().skip(1);
        let theirs = anchors.filter(move |(_, anchor)| {
            anchor.group != Group::PISTON && anchor.group.bodies.meet(bodies)
        });
        theirs.map(|(index, _)| index)
    }

    /// The rock law at the tip.
    pub(crate) fn spring(&self) -> Spring {
        Spring::of(self.state.mode.rock)
    }

    /// Stiffness and viscosity of the rock law at the tip.
    pub(crate) fn tip_line(&self) -> Coefficients {
        self.spring().coefficients(&self.model.parameters.rock)
    }

    /// Time and hole depth at the epoch.
    pub(crate) fn milestone(&self) -> Milestone {
        let mut hole: Double = self.state.origin;
        hole.move_by(self.state.memory.unloaded);
        Milestone { time: self.state.epoch, hole }
    }

    /// How long after the epoch the motion's polynomials are valid, s.
    pub(crate) fn reach(&self) -> f64 {
        let reaches = self.state.anchors.iter().filter_map(|anchor| anchor.driven.reach);
        let of_air = self.air().map_or(f64::INFINITY, |air| {
            // A window ends where a pressure outside may vanish.
            let window = air.window.as_ref().map(|window| window.reach);
            window.unwrap_or_else(|| self.positive_until().0)
        });
        let line = self.state.line.reach.unwrap_or(f64::INFINITY);
        reaches.fold(of_air.min(line), f64::min)
    }

    /// The functional of track `index` that contributes to a displacement.
    pub(crate) fn share(&self, index: usize, displacement: Displacement) -> Option<usize> {
        self.graph().share(self.state.anchors[index].group, displacement)
    }

    /// The tracks that contribute to a displacement, each with its functional.
    pub(crate) fn shares(
        &self,
        displacement: Displacement,
    ) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let place = self.graph().place(displacement);
        let share = move |(index, anchor): (usize, &Anchor)| {
            Some((index, self.graph().share_of_listed(anchor.group, place?)?))
        };
        self.state.anchors.iter().enumerate().filter_map(share)
    }

    /// Static and translating part of a functional of track `index`, after the epoch.
    pub(crate) fn poly(&self, index: usize, functional: usize) -> Poly {
        if let Some(poly) = self.noted(index, functional) {
            return *poly;
        }
        let (loads, driven) = (&self.state.loads, &self.state.anchors[index].driven);
        let system = &self.tracks[index].system;
        if self.is_steady() {
            return system.functionals[functional].parabola(loads, &driven.translation);
        }
        system.poly(functional, loads, driven)
    }

    /// A displacement and its rates at `t` after the epoch, to which `tracks` are rotated.
    pub(crate) fn point(
        &self,
        tracks: &[Track],
        displacement: Displacement,
        t: f64,
    ) -> PointMotion {
        let [displacement, velocity, acceleration] = self.rates(tracks, displacement, t);
        PointMotion { displacement, velocity, acceleration }
    }

    /// A displacement and its first rates, at most three.
    pub(crate) fn rates<const COUNT: usize>(
        &self,
        tracks: &[Track],
        displacement: Displacement,
        t: f64,
    ) -> [f64; COUNT] {
        if let Some(course) = self.course() {
            return course.rates(self.graph().shares_of_pair(displacement), t);
        }
        let shares = self.shares(displacement).take_while(|(index, _)| *index < tracks.len());
        let shares = shares.map(|(index, functional)| {
            let track = &tracks[index];
            let of = &track.system.functionals[functional];
            if of.still {
                let moved = &self.state.anchors[index].driven.translation;
                return moved.derivatives_at::<COUNT>(t).map(|rate| of.rigid * rate);
            }
            let mut rates: [f64; COUNT] = match self.noted(index, functional) {
                Some(poly) => poly.derivatives_at(t),
                None => self.poly(index, functional).derivatives_at(t),
            };
            for (rate, row) in rates.iter_mut().zip(&of.rows) {
                *rate += kernel::dot(row, &track.z);
            }
            rates
        });
        shares.reduce(|a, b| std::array::from_fn(|k| a[k] + b[k])).unwrap_or([0.0; COUNT])
    }

    /// Displacement of the piston's mean in the hole, m, and its first rates, at `t` after the epoch. For a flying
    /// piston they follow from its polynomial; the tracks of a piston in contact must be rotated to `t`.
    pub(crate) fn piston_in_hole<const COUNT: usize>(&self, t: f64) -> [f64; COUNT] {
        let mut rates = self.rates(&self.tracks, Displacement::PISTON, t);
        rates[0] += self.state.origin.value() + self.ahead(Displacement::PISTON);
        rates
    }

    /// The motion of track `index` from the epoch to `span` later, at which the track is `end`.
    pub(crate) fn stretch<'a>(&'a self, index: usize, end: &'a Track, span: f64) -> Stretch<'a> {
        let anchor = &self.state.anchors[index];
        Stretch::new(end, &anchor.z, span, &self.state.loads, &anchor.driven)
    }

    /// `z.Q z` of a track, J: the energy that damping will still dissipate.
    pub(crate) fn damping_form(&self, track: &Track) -> f64 {
        if !self.model.is_damped() {
            return 0.0;
        }
        track.system.damping_form().of(&track.z)
    }

    /// Displacements and velocities `[q | q']` of a track, rotated to `t`, in the bodies' modes.
    pub(crate) fn body_state(&self, track: &Track, index: usize, t: f64) -> Vec<f64> {
        let system = &track.system;
        let mut y = track.z.clone();
        system.add_driven(&self.state.loads, &self.state.anchors[index].driven, t, &mut y);
        let mut state = vec![0.0; 2 * system.modes()];
        system.to_bodies(&y, &mut state);
        state
    }

    /// `[q | q']` of all bodies' modes, from the piston down, now.
    pub(crate) fn whole_state(&self) -> Vec<f64> {
        let graph = self.graph();
        if let Some(course) = self.course() {
            return self.of_bodies(course.at(self.state.now));
        }
        let all = Group { bodies: graph.all(), spring: None };
        let mut whole = vec![0.0; 2 * graph.modes(all.bodies)];
        for (index, track) in self.present().iter().enumerate() {
            let part = self.body_state(track, index, self.state.now);
            let (q, v) = part.split_at(part.len() / 2);
            let shared = graph.overlaps(self.state.anchors[index].group, all);
            shared.iter().for_each(|overlap| overlap.copy([q, v], &mut whole));
        }
        whole
    }

    /// Sets the present: `now` seconds after the epoch, which is `time` for the host.
    pub(crate) fn set_present(&mut self, now: f64, time: f64) {
        (self.state.now, self.state.time) = (now, time);
    }

    /// Moves the epoch by `at`, to which all tracks except that of a lone piston must be rotated. The ledger's
    /// intervals of `touched` bodies end there. `viscous` is added to the work that counts towards the barrier.
    ///
    /// # Errors
    /// A state that is not finite.
    pub(crate) fn move_epoch(
        &mut self,
        at: f64,
        touched: Bodies,
        viscous: f64,
    ) -> Result<(), Error> {
        let followed = self.state.course.as_mut().map(|course| {
            // The ledger keeps the course of the window that ends here.
            *course = Arc::new(course.shifted(at));
            course.start().map(|[piston, bit]| [piston - bit; 2])
        });
        let in_cylinder = || self.air().map(|_| self.in_cylinder(&self.tracks, at));
        self.cylinder = followed.or_else(in_cylinder);
        let [places, _] = self.cylinder.unwrap_or_default();
        self.polys.clear();
        for (track, anchor) in self.tracks.iter_mut().zip(&mut self.state.anchors) {
            track.at -= at;
            if anchor.group != Group::PISTON {
                track.at = 0.0;
                anchor.move_start(at, anchor.group.bodies.meet(touched));
            }
            anchor.z.copy_from_slice(&track.z);
            anchor.at = track.at;
        }
        let steady = self.is_steady();
        let state = &mut self.state;
        if state.mode.rock.is_viscous() {
            state.psi += viscous;
        }
        state.epoch.move_by(at);
        state.now -= at;
        if !self.still {
            state.inputs.shift(at);
        }
        if let Some(window) = state.air.as_mut().and_then(|air| air.shift(places, at)) {
            self.window = Some(window);
        }
        let renewed = state.line.reach.take().is_some()
            || state.air.as_ref().is_some_and(|air| air.vented.is_none());
        let old = (!steady && self.state.course.is_none()).then_some(self.state.loads);
        let is_still = self.still && self.state.course.is_some();
        if !(steady || is_still) {
            self.state.loads.iter_mut().for_each(|load| load.shift(at));
        }
        for index in 0..self.tracks.len() {
            match old {
                Some(ref old)
                    if self.state.anchors[index].group != Group::PISTON && !self.is_calm(index) =>
                {
                    // These loads remain; the next window of the air or of a line adds its own.
                    let driven = &mut self.state.anchors[index].driven;
                    if !(renewed && driven.shift(at)) {
                        self.restart(index, old, at);
                    }
                }
                _ => self.state.anchors[index].driven.translation.shift(at),
            }
        }
        let is_finite = match &self.state.course {
            Some(course) => course.start().as_flattened().iter().all(|x| x.is_finite()),
            None => kernel::is_finite(&self.tracks[0].z),
        };
        if !is_finite {
            return Err(Error::NotFinite { time: self.state.epoch.value() });
        }
        Ok(())
    }

    /// Splits the motion of a track at the epoch again into polynomials and oscillation, under the present loads. `old`
    /// are the previous loads, as functions of time after an epoch that was `since` ago.
    fn restart(&mut self, index: usize, old: &[Poly; CHANNELS], since: f64) {
        let (track, anchor) = (&mut self.tracks[index], &self.state.anchors[index]);
        track.system.add_driven(old, &anchor.driven, since, &mut track.z);
        self.split(index);
        self.steady = self.state.is_steady();
    }

    /// Splits a track that holds its whole state, under the present loads.
    fn split(&mut self, index: usize) {
        let (track, anchor) = (&mut self.tracks[index], &mut self.state.anchors[index]);
        anchor.driven = track.system.take_driven(&self.state.loads, &mut track.z);
        anchor.z.copy_from_slice(&track.z);
    }

    pub(crate) fn set_input(&mut self, input: Input, poly: Poly) {
        self.state.inputs.0[input as usize] = poly;
        self.still = self.state.inputs.are_constant();
        self.reload();
    }

    /// The model with other tunable parameters. Its system for the present mode is computed.
    ///
    /// # Errors
    /// As [`Model::system`].
    pub(crate) fn retuned(&self, tuned: &Parameters) -> Result<Model, Error> {
        let model = self.model.retuned(tuned);
        model.system(self.graph().at_tip(&self.state.mode), self.state.mode)?;
        Ok(model)
    }

    /// Adopts tunable parameters at the epoch; positions and memory are unchanged.
    pub(crate) fn retune(&mut self, tuned: Model) -> Result<(), Error> {
        if self.course().is_some() {
            self.model = tuned;
            return Ok(());
        }
        self.tracks[0].rotate_to(0.0);
        let (state, line) = (self.body_state(&self.tracks[0], 0, 0.0), self.tip_line());
        self.model = tuned;
        // If the tip's spring is unchanged, the basis stays the same and nothing is rounded.
        let is_felt = line != self.tip_line();
        if is_felt { self.enter(0, self.state.anchors[0].group, &state) } else { Ok(()) }
    }

    /// Recomputes the loads at the epoch. Where a load jumps, the static shape changes and the
    /// oscillation about it takes up the difference.
    pub(crate) fn reload(&mut self) {
        let state = &self.state;
        let loads = start::loads(
            &self.model.parameters,
            &state.inputs,
            state.mode,
            self.air_forces(self.air()),
        );
        self.load(loads);
    }

    /// Replaces the loads at the epoch.
    pub(super) fn load(&mut self, loads: [Poly; CHANNELS]) {
        let old = std::mem::replace(&mut self.state.loads, loads);
        self.adopt(&old, |_, _| false);
    }

    /// Adopts the loads that have replaced `old` at the epoch. `whole` says which tracks hold their whole state.
    fn adopt(&mut self, old: &[Poly; CHANNELS], whole: impl Fn(&Self, usize) -> bool) {
        let same = *old == self.state.loads;
        // Under constant loads every track is restarted, even where its own load is the same.
        let is_constant = self.steady && self.state.loads.iter().all(Poly::is_constant);
        for index in 0..self.tracks.len() {
            if self.state.anchors[index].group != Group::PISTON {
                let system = &self.tracks[index].system;
                if whole(self, index) {
                    self.split(index);
                } else if !same && (is_constant || system.differ(old, &self.state.loads)) {
                    self.restart(index, old, 0.0);
                }
                continue;
            }
            if same {
                continue;
            }
            // Loads on a free body move only its translation.
            let (piston, anchor) = (&self.tracks[index], &mut self.state.anchors[index]);
            let [x, v, ..] = anchor.driven.translation.0;
            anchor.driven.translation = piston.system.translation([x, v], &self.state.loads);
        }
        self.steady = self.state.is_steady();
    }
}
