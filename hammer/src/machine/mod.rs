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

pub mod ledger;
pub mod observe;
mod peaks;
mod report;
mod start;
pub mod state;
mod transit;
mod watchlist;

use crate::error::Error;
use crate::machine::observe::{Counters, Record, Views};
use crate::machine::peaks::Pending;
use crate::machine::state::State;
use crate::modal::model::Model;
use crate::numerics::instant::Double;
use crate::physics::inputs::{Input, Inputs};
use crate::physics::mode::{Mode, Relay};
use crate::physics::parameters::{InputValues, Parameters};
use crate::physics::rock::RockEvent;
use crate::search::barrier::Barrier;
use crate::search::guard::{Track, Watch, Work};

/// Events closer than this are at one instant, s.
pub const TIME_RESOLUTION: f64 = 1e-15;
/// Transitions at one instant beyond which a cascade is without end.
pub const MAX_CASCADE: u32 = 100;

/// A run of this many transitions must take at least [`SHORTEST_SPACING`] each on average.
pub const MAX_BURST: u32 = 20_000;
/// Least mean spacing of transitions, radians of the fastest motion that mesh, contact and
/// rock can make: a contact that rattles opens and closes once in `2 pi`.
pub const SHORTEST_SPACING: f64 = 0.05;
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
    pub(crate) fn name(self, mode: Mode) -> &'static str {
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
    pub(crate) watches: Vec<(Event, Watch)>,
    pub(crate) barrier: Option<Barrier>,
    pub(crate) pending: Vec<Pending>,
    pub(crate) views: Views,
    pub(crate) work: Work,
    pub(crate) search_start: u64,
    failure: Option<Error>,
    pub(crate) journal: Option<Vec<Record>>,
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
        let (state, tracks) = crate::machine::start::state(&model, inputs, start)?;
        let mut machine = Self {
            model,
            state,
            tracks,
            watches: Vec::new(),
            barrier: None,
            pending: Vec::new(),
            views: Views::default(),
            work: Work::default(),
            search_start: 0,
            failure: None,
            journal: None,
        };
        for index in 0..machine.tracks.len() {
            machine.state.anchors[index].form = machine.damping_form(index);
        }
        if machine.kinematics().contact_gap < -parameters.resolutions()[0] {
            // Gravity holds the bit down, the feed pulls it into the piston: in contact.
            machine.switch_contact()?;
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
        self.views = Views::default();
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
        let tracks = crate::machine::start::tracks(fresh.as_ref().unwrap_or(&self.model), state)?;
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
        crate::machine::start::warnings(&self.model.parameters)
    }

    /// Time and hole depth now.
    pub(crate) fn milestone(&self) -> crate::machine::state::Milestone {
        let mut hole: Double = self.state.origin;
        hole.add(self.state.memory.unloaded);
        crate::machine::state::Milestone { time: self.state.epoch, hole }
    }
}
