//! The hybrid machine: exact flow from event to event.
//!
//! ```text
//! advance(to):
//!     while an event e of the present mode comes first, at t <= to:
//!         x- := flow(x, t)                      exact: modal exponentials and polynomials
//!         (mode, x+) := transit(e, mode, x-)    order at one instant: contact, rock, relay
//!         watch the guards of the new mode from t on
//!     now := to                                 the state is not touched: only looked at
//! ```
//!
//! The state lives at the last event; a communication point reads it and leaves it alone.
//! The search for the next event does not know where the host will stop. Hence the
//! trajectory is the same, bit for bit, however time is sliced.

use crate::barrier::Barrier;
use crate::error::Error;
use crate::guard::{DISPLACEMENT_RESOLUTION, Guard, Part, Track, VELOCITY_RESOLUTION, Watch, Work};
use crate::inputs::{Input, Inputs};
use crate::instant::Double;
use crate::mode::{Mode, Relay, RockMode};
use crate::model::{self, Model, Span};
use crate::observe::{Counters, Kinematics, Record};
use crate::parameters::{InputValues, Parameters, Source};
use crate::peaks::Pending;
use crate::poly::Poly;
use crate::rock::{RockEvent, Spring};
use crate::state::{Anchor, State};
use std::sync::Arc;

/// Events closer than this are at one instant, s.
pub const TIME_RESOLUTION: f64 = 1e-15;
/// Transitions at one instant beyond which a cascade is without end.
pub const MAX_CASCADE: u32 = 100;

/// A run of this many transitions must take at least [`SHORTEST_BURST`].
pub const MAX_BURST: u32 = 20_000;
/// See [`MAX_BURST`]; s. A blow of the reference hammer has some 20 transitions in 2e-5 s.
pub const SHORTEST_BURST: f64 = 2e-3;
/// Evaluations that a search may take from an event on, and more a second of motion. The
/// reference hammer takes 3e4 a second.
const SEARCH_BUDGET: f64 = 1e6;
const SEARCH_BUDGET_RATE: f64 = 2e7;

/// What a watch announces; the order of declaration is the order at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    Contact,
    Rock(RockEvent),
    Relay,
}

impl Event {
    /// Name of the event function that crossed in `mode`.
    fn name(self, mode: Mode) -> &'static str {
        match self {
            Self::Contact => "Q11",
            Self::Relay if mode.relay == Relay::Drive => "Q9",
            Self::Relay => "Q10",
            Self::Rock(event) => event.name(mode.rock),
        }
    }
}

/// A scene in motion.
#[derive(Debug)]
pub struct Machine {
    pub(crate) model: Model,
    pub(crate) state: State,
    pub(crate) tracks: Vec<Track>,
    watches: Vec<(Event, Watch)>,
    barrier: Option<Barrier>,
    pub(crate) pending: Vec<Pending>,
    pub(crate) kinematics: Option<Kinematics>,
    work: Work,
    search_start: u64,
    failure: Option<Error>,
    journal: Option<Vec<Record>>,
}

impl Machine {
    /// The scene at its start: piston at rest (or at its initial velocity), bit in static
    /// equilibrium in standstill, or just touching in free flight if its loads lift it.
    ///
    /// # Errors
    /// A parameter or input out of its domain; a spectrum that cannot be resolved.
    pub fn new(parameters: &Parameters, inputs: &InputValues, start: f64) -> Result<Self, Error> {
        let model = Model::new(parameters)?;
        for (input, poly) in Input::ALL.into_iter().zip(Inputs::constant(inputs).0) {
            input.polynomial(&poly.0[..1])?;
        }
        if !start.is_finite() {
            return Err(Error::Backwards { from: start, to: start });
        }
        let inputs = Inputs::constant(inputs);
        let (state, tracks) = crate::start::state(&model, inputs, start)?;
        let mut machine = Self {
            model,
            state,
            tracks,
            watches: Vec::new(),
            barrier: None,
            pending: Vec::new(),
            kinematics: None,
            work: Work::default(),
            search_start: 0,
            failure: None,
            journal: None,
        };
        for index in 0..machine.tracks.len() {
            machine.state.anchors[index].form = machine.damping_form(index);
        }
        machine.state.energy_start = machine.mechanical_energy();
        machine.arm();
        Ok(machine)
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Discrete state.
    pub fn mode(&self) -> Mode {
        self.state.mode
    }

    /// Parameters, with the tunables as they are now.
    pub fn parameters(&self) -> &Parameters {
        &self.state.parameters
    }

    /// What has been counted so far.
    pub fn counters(&self) -> Counters {
        let near: u64 = self.watches.iter().map(|(_, w)| w.undecided).sum();
        Counters {
            undecided: self.state.counters.undecided + near,
            guard_evaluations: self.work.evaluations,
            samples: self.work.samples,
            windows: self.work.windows,
            ..self.state.counters
        }
    }

    /// Starts or stops keeping a journal of transitions.
    pub fn keep_journal(&mut self, keep: bool) {
        self.journal = keep.then(Vec::new);
    }

    /// The transitions since the last call.
    pub fn take_journal(&mut self) -> Vec<Record> {
        self.journal.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Value of an input now.
    pub fn input(&self, input: Input) -> f64 {
        self.state.inputs.of(input).at(self.state.now)
    }

    /// Sets an input's value and derivatives now; it is that polynomial from now on.
    ///
    /// # Errors
    /// A number that is not finite, or too many derivatives; nothing is changed then.
    pub fn set_input(&mut self, input: Input, derivatives: &[f64]) -> Result<(), Error> {
        let poly = input.polynomial(derivatives)?;
        if self.state.inputs.of(input).shifted(self.state.now) == poly {
            return Ok(());
        }
        self.settle_now()?;
        self.state.inputs.0[input as usize] = poly;
        self.reload();
        self.arm();
        Ok(())
    }

    /// Takes over the tunable parameters of `parameters` (`rock.stiffness`,
    /// `rock.unloading_ratio`, `rock.viscosity`, `rock.energy_barrier`,
    /// `drive.amplitude`); positions and memory are kept.
    ///
    /// # Errors
    /// A parameter out of its domain; nothing is changed then.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let mut wanted = self.state.parameters;
        (wanted.rock, wanted.drive.amplitude) = (parameters.rock, parameters.drive.amplitude);
        wanted.validate()?;
        if wanted == self.state.parameters {
            return Ok(());
        }
        self.settle_now()?;
        let before = self.mechanical_energy();
        let hub = self.lift(0);
        self.model.retune(&wanted);
        self.state.parameters = self.model.parameters;
        self.land(0, self.state.anchors[0].span, &hub)?;
        self.state.sums.retuned += self.mechanical_energy() - before;
        self.reload();
        self.arm();
        Ok(())
    }

    /// One communication step, from the present time to `to`.
    ///
    /// # Errors
    /// `to` before the present or not finite (nothing is changed then); a cascade without
    /// end; a state that is no longer finite. After the latter two every further step
    /// returns the same error.
    pub fn advance(&mut self, to: f64) -> Result<(), Error> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if !(to.is_finite() && to >= self.state.time) {
            return Err(Error::Backwards { from: self.state.time, to });
        }
        self.begin_step();
        if let Err(error) = self.run(to) {
            self.failure = Some(error.clone());
            return Err(error);
        }
        Ok(())
    }

    fn begin_step(&mut self) {
        self.kinematics = None;
        self.pending.clear();
        self.state.peaks = Default::default();
        self.state.step_start = self.state.now;
    }

    fn run(&mut self, to: f64) -> Result<(), Error> {
        loop {
            let target = self.state.epoch.until(to);
            let Some((at, event)) = self.next_event(target)? else {
                (self.state.now, self.state.time) = (target, to);
                return Ok(());
            };
            self.occur(at, event)?;
        }
    }

    /// The first event not after `target`, for certain.
    fn next_event(&mut self, target: f64) -> Result<Option<(f64, Event)>, Error> {
        loop {
            let found = self.first_found();
            self.check_search()?;
            let limit = found.map_or(target, |(at, _)| at.min(target));
            // What is clear until the limit itself may still cross there.
            let open = |clear: f64| {
                if found.is_some_and(|(at, _)| at <= target) {
                    clear < limit
                } else {
                    clear <= limit
                }
            };
            let next = self
                .watches
                .iter()
                .enumerate()
                .filter(|(_, (_, w))| w.found.is_none() && open(w.clear))
                .min_by(|a, b| a.1.1.clear.total_cmp(&b.1.1.clear))
                .map(|(i, (_, w))| (i, w.clear));
            let barrier = self
                .barrier
                .as_ref()
                .filter(|b| b.found.is_none() && open(b.clear))
                .map(|b| b.clear);
            match (next, barrier) {
                (None, None) => return Ok(found.filter(|(at, _)| *at <= target)),
                (Some((_, clear)), Some(b)) if b < clear => self.extend_barrier(),
                (None, Some(_)) => self.extend_barrier(),
                (Some((i, _)), _) => self.watches[i].1.extend(&mut self.tracks, &mut self.work),
            }
        }
    }

    /// A search that is not a number, or does not get on, is an error and not a hang.
    fn check_search(&self) -> Result<(), Error> {
        let reach = self
            .watches
            .iter()
            .map(|(_, w)| w.horizon())
            .fold(f64::INFINITY, |a, b| if b.is_nan() { b } else { a.min(b) });
        let time = self.state.epoch.value();
        if reach.is_nan() {
            return Err(Error::NotFinite { time });
        }
        let taken = (self.work.evaluations - self.search_start) as f64;
        if taken > SEARCH_BUDGET + SEARCH_BUDGET_RATE * reach {
            let reason = "too many evaluations since the last event";
            return Err(Error::Overwork { time: time + reach, reason, mode: self.state.mode });
        }
        Ok(())
    }

    fn extend_barrier(&mut self) {
        if let Some(barrier) = &mut self.barrier {
            barrier.extend(&self.state.anchors[0].z, &self.state.loads, &mut self.work);
        }
    }

    /// The earliest crossing found; at one instant the first in order.
    fn first_found(&self) -> Option<(f64, Event)> {
        let watched = self.watches.iter().filter_map(|(event, w)| w.found.map(|at| (at, *event)));
        let barrier = self.barrier.as_ref().and_then(|b| b.found);
        let barrier = barrier.map(|at| (at, Event::Rock(RockEvent::Barrier)));
        let rank = |event: &Event| match event {
            Event::Contact => 0,
            Event::Rock(_) => 1,
            Event::Relay => 2,
        };
        watched.chain(barrier).reduce(|a, b| {
            let tie = (a.0 - b.0).abs() <= TIME_RESOLUTION;
            let earlier = if tie { rank(&b.1) < rank(&a.1) } else { b.0 < a.0 };
            if earlier { b } else { a }
        })
    }

    /// The transition of an event at `at` after the epoch.
    fn occur(&mut self, at: f64, event: Event) -> Result<(), Error> {
        let from = self.state.mode;
        self.settle(at)?;
        let state = &mut self.state;
        state.simultaneous = if at <= TIME_RESOLUTION { state.simultaneous + 1 } else { 0 };
        state.counters.events += 1;
        state.burst.0 += 1;
        if state.burst.0 == MAX_BURST {
            let span = state.epoch.since(state.burst.1);
            if span < SHORTEST_BURST {
                let reason = "too many transitions in too short a time";
                return Err(Error::Overwork {
                    time: state.epoch.value(),
                    reason,
                    mode: state.mode,
                });
            }
            state.burst = (0, state.epoch);
        }
        let name = event.name(state.mode);
        match event {
            Event::Contact => self.switch_contact()?,
            Event::Rock(event) => self.switch_rock(event)?,
            Event::Relay => self.switch_relay(),
        }
        if let Some(journal) = &mut self.journal {
            let epoch = self.state.epoch;
            let (time, time_rest) = (epoch.value(), epoch.rest());
            journal.push(Record { time, time_rest, event: name, mode: self.state.mode });
        }
        if self.state.simultaneous > MAX_CASCADE {
            return Err(Error::Cascade {
                time: self.state.epoch.value(),
                transitions: self.state.simultaneous,
                from,
                to: self.state.mode,
            });
        }
        self.arm();
        Ok(())
    }

    fn switch_relay(&mut self) {
        let relay = &mut self.state.mode.relay;
        *relay = if *relay == Relay::Drive { Relay::Return } else { Relay::Drive };
        self.reload();
    }

    fn switch_contact(&mut self) -> Result<(), Error> {
        let spring = Spring::of(self.state.mode.rock);
        let (piston, bit) = (2 * self.model.piston.len(), 2 * self.model.bit.len());
        let (p, b) = (piston / 2, bit / 2);
        if self.state.mode.closed {
            self.state.mode.closed = false;
            self.note_opening();
            let hub = self.lift(0);
            let both = p + b;
            let part = |i: std::ops::Range<usize>| {
                [&hub[i.clone()], &hub[both + i.start..both + i.end]].concat()
            };
            let (x, y) = (part(0..p), part(p..both));
            self.land(0, Span::Bit(spring), &y)?;
            self.add_track(Span::Piston)?;
            self.land(1, Span::Piston, &x)
        } else {
            self.state.mode.closed = true;
            self.note_closing();
            let lost = self.damping_left(1);
            self.state.sums.damping += lost;
            let (y, x) = (self.lift(0), self.lift(1));
            let hub = [&x[..p], &y[..b], &x[p..], &y[b..]].concat();
            self.tracks.truncate(1);
            self.state.anchors.truncate(1);
            self.land(0, Span::Both(spring), &hub)
        }
    }

    fn switch_rock(&mut self, event: RockEvent) -> Result<(), Error> {
        let p = self.tip(0.0)[0];
        let transition = self.state.memory.transit(event, p, &self.model.parameters.rock);
        let before = Spring::of(self.state.mode.rock);
        let after = Spring::of(transition.mode);
        self.state.mode.rock = transition.mode;
        if transition.mode == RockMode::DissipativeForward {
            self.state.counters.rock_cycles += 1;
            self.state.psi = 0.0;
        }
        if before == after && transition.shift == 0.0 {
            return Ok(());
        }
        let mut hub = self.lift(0);
        self.shift_origin(transition.shift, &mut hub);
        let span = if self.state.mode.closed { Span::Both(after) } else { Span::Bit(after) };
        self.land(0, span, &hub)
    }

    /// Measures displacements from a point `shift` further down.
    fn shift_origin(&mut self, shift: f64, hub: &mut [f64]) {
        self.state.origin.add(shift);
        let (mp, mb) = (self.model.piston.mass.sqrt(), self.model.bit.mass.sqrt());
        if self.state.mode.closed {
            hub[0] -= shift * mp;
            hub[self.model.piston.len()] -= shift * mb;
        } else {
            hub[0] -= shift * mb;
            self.state.anchors[1].translation.0[0] -= shift * mp;
        }
    }

    /// Moves the epoch to the present time, from the last event in one flow.
    pub(crate) fn settle_now(&mut self) -> Result<(), Error> {
        for (track, anchor) in self.tracks.iter_mut().zip(&self.state.anchors) {
            track.z.copy_from_slice(&anchor.z);
            track.at = anchor.at;
        }
        let now = self.state.now;
        // What the search counted ahead of the present is void.
        for (_, watch) in &mut self.watches {
            watch.undecided = 0;
        }
        self.settle(now)
    }

    /// Moves the epoch by `at` and sums up the stretch that ends there.
    fn settle(&mut self, at: f64) -> Result<(), Error> {
        self.keep_stretch(at);
        self.work.samples += self.tracks[0].rotate_to(at);
        let sums = self.stretch_sums(&self.tracks, at);
        self.state.psi +=
            if self.state.mode.rock == RockMode::DissipativeForward { sums.viscous } else { 0.0 };
        self.state.sums.add(&sums);
        self.state.counters.undecided += self.watches.iter().map(|(_, w)| w.undecided).sum::<u64>();
        self.watches.clear();
        self.barrier = None;
        let form = self.damping_form(0);
        for (i, (track, anchor)) in self.tracks.iter_mut().zip(&mut self.state.anchors).enumerate()
        {
            track.at -= at;
            anchor.z.copy_from_slice(&track.z);
            anchor.at = track.at;
            anchor.translation = anchor.translation.shifted(at);
            if i == 0 {
                (track.at, anchor.at, anchor.form) = (0.0, 0.0, form);
            }
        }
        let state = &mut self.state;
        state.epoch.add(at);
        state.now -= at;
        state.step_start = (state.step_start - at).max(0.0);
        state.inputs.shift(at);
        state.loads = state.loads.map(|p| p.shifted(at));
        self.kinematics = None;
        if self.tracks[0].z.iter().any(|x| !x.is_finite()) {
            return Err(Error::NotFinite { time: self.state.epoch.value() });
        }
        Ok(())
    }

    /// Displacements and velocities of a track's bodies in the bars' modes, at the epoch.
    pub(crate) fn lift(&mut self, index: usize) -> Vec<f64> {
        self.work.samples += self.tracks[index].rotate_to(0.0);
        self.hub(&self.tracks[index], index, 0.0)
    }

    /// `[q | q']` of a track standing at `t`.
    pub(crate) fn hub(&self, track: &Track, index: usize, t: f64) -> Vec<f64> {
        let system = &track.system;
        let mut y = track.z.clone();
        self.add_static(system, t, 1.0, &mut y);
        if system.rigid {
            let n = system.blocks();
            let translation = &self.state.anchors[index].translation;
            (y[0], y[n]) = (translation.at(t), translation.derivative().at(t));
        }
        let mut hub = vec![0.0; 2 * system.modes()];
        system.from_modal(&y, &mut hub);
        hub
    }

    fn add_static(&self, system: &crate::system::System, t: f64, sign: f64, y: &mut [f64]) {
        system.add_static(&self.state.loads, t, sign, y);
    }

    fn add_track(&mut self, span: Span) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let z = vec![0.0; 2 * system.blocks()];
        self.state.anchors.push(Anchor {
            span,
            z: z.clone(),
            at: 0.0,
            translation: Poly::default(),
            form: 0.0,
        });
        self.tracks.push(Track { system, z, at: 0.0 });
        Ok(())
    }

    /// Puts a track on the system of `span` with the state `hub` at the epoch.
    fn land(&mut self, index: usize, span: Span, hub: &[f64]) -> Result<(), Error> {
        let system = self.model.system(span, self.state.mode)?;
        let n = system.blocks();
        let mut z = vec![0.0; 2 * n];
        system.to_modal(hub, &mut z);
        let start = [z[0], z[n]];
        self.add_static(&system, 0.0, -1.0, &mut z);
        let anchor = &mut self.state.anchors[index];
        anchor.translation = Poly::default();
        if system.rigid {
            (z[0], z[n]) = (0.0, 0.0);
            anchor.translation =
                crate::system::translation(start, &system.gains, &self.state.loads);
        }
        anchor.span = span;
        anchor.at = 0.0;
        anchor.z.clone_from(&z);
        self.tracks[index] = Track { system, z, at: 0.0 };
        self.state.counters.basis_changes += 1;
        self.state.anchors[index].form = self.damping_form(index);
        Ok(())
    }

    /// Recomputes the loads at the epoch; where a load jumps, static shapes and the
    /// oscillation about them exchange.
    fn reload(&mut self) {
        let old = self.state.loads;
        let alpha = self.state.mode.relay.sign();
        self.state.loads[model::DRIVE] = self.state.inputs.drive(&self.model.parameters, alpha);
        self.state.loads[model::FEED] = *self.state.inputs.of(Input::FeedForce);
        if old == self.state.loads {
            return;
        }
        for index in 0..self.tracks.len() {
            let system: Arc<_> = self.tracks[index].system.clone();
            if self.state.anchors[index].span != Span::Piston {
                system.add_static(&old, 0.0, 1.0, &mut self.tracks[index].z);
                system.add_static(&self.state.loads, 0.0, -1.0, &mut self.tracks[index].z);
                let form = self.damping_form(index);
                let anchor = &mut self.state.anchors[index];
                anchor.z.copy_from_slice(&self.tracks[index].z);
                anchor.form = form;
            }
            if system.rigid {
                let t = self.state.anchors[index].translation;
                self.state.anchors[index].translation =
                    crate::system::translation([t.0[0], t.0[1]], &system.gains, &self.state.loads);
            }
        }
    }

    /// Watches the guards of the present mode, from the epoch on.
    fn arm(&mut self) {
        use RockEvent::{Lift, Restart, Retreat, Return, Touch, Turn};
        self.watches.clear();
        self.kinematics = None;
        self.search_start = self.work.evaluations;
        let closed = self.state.mode.closed;
        self.watch(Event::Contact, model::GAP, 0, if closed { 1.0 } else { -1.0 }, 0.0);
        let rock = self.model.parameters.rock;
        let vs = rock.standstill_speed;
        let rules: &[(RockEvent, usize, f64, f64)] = match self.state.mode.rock {
            RockMode::FreeFlight => &[(Touch, 0, 1.0, 0.0)],
            RockMode::DissipativeForward | RockMode::Forward => &[(Turn, 1, -1.0, 0.0)],
            RockMode::Backward => &[(Lift, 0, -1.0, 0.0), (Return, 1, 1.0, 0.0)],
            RockMode::Standstill => {
                &[(Lift, 0, -1.0, 0.0), (Restart, 1, 1.0, vs), (Retreat, 1, -1.0, vs)]
            }
        };
        for &(event, order, factor, level) in rules {
            self.watch(Event::Rock(event), model::TIP, order, factor, level);
        }
        if self.model.parameters.drive.source == Source::Relay {
            match self.state.mode.relay {
                Relay::Drive => self.watch(Event::Relay, model::RELATIVE, 0, 1.0, 0.0),
                Relay::Return => {
                    self.watch(
                        Event::Relay,
                        model::RELATIVE,
                        0,
                        -1.0,
                        self.model.parameters.drive.stroke,
                    );
                }
            }
        }
        self.barrier = (self.state.mode.rock == RockMode::DissipativeForward).then(|| {
            Barrier::new(&self.tracks[0], rock.energy_barrier - self.state.psi, rock.viscosity)
        });
    }

    /// Watches `factor * u - level` rising through zero.
    fn watch(&mut self, event: Event, functional: usize, order: usize, factor: f64, level: f64) {
        let mut parts = [Some(Part { track: 0, functional, factor }), None];
        if !self.state.mode.closed {
            let other = match functional {
                model::GAP => Some(model::PISTON_GAP),
                model::RELATIVE => Some(model::PISTON_ALONE_MEAN),
                _ => None,
            };
            parts[1] = other.map(|functional| Part { track: 1, functional, factor });
        }
        let mut poly = Poly::default();
        for part in parts.iter().flatten() {
            let f = &self.tracks[part.track].system.functionals[part.functional];
            poly = poly.plus(
                factor,
                &f.poly(&self.state.loads, &self.state.anchors[part.track].translation),
            );
        }
        if order == 1 {
            poly = poly.derivative();
        }
        poly.0[0] -= level;
        let resolution = if order == 1 { VELOCITY_RESOLUTION } else { DISPLACEMENT_RESOLUTION };
        self.watches.push((event, Watch::new(Guard::new(poly, parts, order, resolution), 0.0)));
    }

    /// True if the piston rests on the bit and, the loads staying as they are, neither the
    /// contact can open nor the relay switch: a state that the law never leaves.
    pub fn stalled(&self) -> bool {
        if !self.state.mode.closed || self.model.parameters.drive.source != Source::Relay {
            return false;
        }
        let tracks = self.present();
        let never = |event: Event| {
            self.watches.iter().any(|(e, w)| *e == event && w.found.is_none() && w.never(&tracks))
        };
        never(Event::Contact) && never(Event::Relay)
    }

    /// The whole dynamic state.
    pub fn state(&mut self) -> State {
        self.fold_peaks();
        self.state.clone()
    }

    /// Continues from a state of a scene of the same make, bit for bit.
    ///
    /// # Errors
    /// A state of another make (parameters or dimensions differ); nothing is changed then.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let other = state.parameters != self.model.parameters;
        let fresh = if other { Some(Model::new(&state.parameters)?) } else { None };
        let tracks = crate::start::tracks(fresh.as_ref().unwrap_or(&self.model), state)?;
        if let Some(model) = fresh {
            self.model = model;
        }
        self.tracks = tracks;
        self.state = state.clone();
        self.pending.clear();
        self.failure = None;
        self.arm();
        Ok(())
    }

    /// What the host should hear of this scene.
    pub fn warnings(&self) -> Vec<String> {
        crate::start::warnings(&self.model.parameters)
    }

    /// Time and hole depth now.
    pub(crate) fn milestone(&self) -> crate::state::Milestone {
        let mut hole: Double = self.state.origin;
        hole.add(self.state.memory.unloaded);
        crate::state::Milestone { time: self.state.epoch, hole }
    }
}
