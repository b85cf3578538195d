//! The hybrid machine: exact flow from event to event.
//!
//! ```text
//! advance(to):
//!     while an event e of the present mode comes first, at t <= to:
//!         x- := flow(x, t)                      exact: modal exponentials and polynomials
//!         (mode, x+) := transit(e, mode, x-)    order at one instant: contact, rock, relay
//!         track the guards of the new mode from t on
//!     now := to                                 the state is not touched: only looked at
//! ```
//!
//! The state lives at the last event; a communication point reads it and leaves it alone.
//! The search for the next event does not know where the host will stop. Hence the
//! trajectory is the same, bit for bit, however time is sliced. Only what really changes the
//! future moves the epoch: an event, an input set to another polynomial, a tunable parameter.

mod account;
pub(crate) mod blows;
mod interrupt;
pub(crate) mod journal;
pub(crate) mod ledger;
pub(crate) mod outputs;
mod owed;
pub(crate) mod peaks;
mod powers;
pub(crate) mod state;
pub(crate) mod stops;
mod sums;
#[cfg(feature = "internals")]
mod tracked;
mod views;
pub(crate) mod zeno;

use crate::error::Error;
use crate::laws::chambers::Gas;
use crate::laws::event::Event;
use crate::laws::mode::{Mode, RockMode};
use crate::laws::rock::Memory;
use crate::modal::model::Model;
use crate::motion::Motion;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{InputValues, Parameters};
use crate::search::Search;
use crate::search::work::Interrupt;
use account::Account;
use blows::{Closing, Progress};
use journal::{Counters, Record};
use ledger::{Ledger, Stored, damping_in_flight};
use owed::Owed;
use peaks::PeakSearch;
use state::State;
use std::sync::Arc;
use sums::Sums;
use views::Views;
use zeno::ZenoDetector;

/// Observes the events of a step, and may end it at one.
pub(crate) trait Observer {
    /// The epoch is about to move, to an event or along a stretch.
    fn before(&mut self, _machine: &Machine) {}

    /// An event has happened, at the epoch; true ends the step here.
    fn after(&mut self, _machine: &Machine, _event: Event) -> bool {
        false
    }

    /// True if the step ends, where the present is put, before `until` after the epoch, though
    /// nothing happens there.
    fn stops_before(&mut self, _: &mut Machine, _until: f64, _to: f64) -> Result<bool, Error> {
        Ok(false)
    }
}

impl Observer for () {}

/// A scene in motion.
#[derive(Debug)]
pub struct Machine {
    motion: Motion,
    search: Search,
    ledger: Account,
    blows: Progress,
    peaks: PeakSearch,
    zeno: ZenoDetector,
    counters: Counters,
    journal: Option<Vec<Record>>,
    keeps_rock_work: bool,
    failure: Option<Error>,
    views: Views,
}

impl Machine {
    /// The scene at its start: piston at rest (or at its initial velocity), bit in static
    /// equilibrium in standstill, or, if its loads lift it, at rest and just touching in free
    /// flight; without oscillation in any case.
    ///
    /// # Errors
    /// A parameter or input out of its domain; a spectrum that cannot be resolved.
    pub fn new(parameters: &Parameters, inputs: &InputValues, start: f64) -> Result<Self, Error> {
        let model = Model::new(parameters)?;
        let inputs = Inputs::constant(inputs);
        for input in Input::ALL {
            input.polynomial(&inputs.of(input).0[..1]).map_err(Error::of_input(input))?;
        }
        if !start.is_finite() {
            return Err(Error::Backwards { from: start, to: start });
        }
        let mut machine = Self {
            motion: Motion::new(model, inputs, start)?,
            search: Search::default(),
            ledger: Account::default(),
            blows: Progress::default(),
            peaks: PeakSearch::default(),
            zeno: ZenoDetector::new(start),
            counters: Counters::default(),
            journal: None,
            keeps_rock_work: false,
            failure: None,
            views: Views::default(),
        };
        if machine.kinematics().contact_gap < -machine.motion.least_overlap() {
            // Gravity holds the bit down, the feed pulls it into the piston: in contact.
            machine.switch_contact()?;
        }
        machine.ledger = Ledger::from(Stored::at_epoch(&machine.motion)).into();
        machine.restart_search();
        Ok(machine)
    }

    /// The hammer in motion.
    pub(crate) fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.motion.state().time
    }

    /// Discrete state.
    pub fn mode(&self) -> Mode {
        self.motion.mode()
    }

    /// Parameters, with the tunables as they are now.
    pub fn parameters(&self) -> &Parameters {
        self.motion.parameters()
    }

    /// What a user should know about this scene.
    pub fn warnings(&self) -> Vec<String> {
        crate::quantities::warnings::warnings(self.motion.parameters())
    }

    /// Value of an input now.
    pub fn input(&self, input: Input) -> f64 {
        let state = self.motion.state();
        state.inputs.of(input).at(state.now)
    }

    /// Sets an input's value and derivatives now, in its unit per s, per s2, ...; it is that
    /// polynomial of time from now on.
    ///
    /// # Errors
    /// A number that is not finite, or too many derivatives; nothing is changed then.
    pub fn set_input(&mut self, input: Input, derivatives: &[f64]) -> Result<(), Error> {
        let poly = input.polynomial(derivatives).map_err(Error::of_input(input))?;
        let state = self.motion.state();
        if state.inputs.of(input).shifted(state.now) == poly {
            return Ok(());
        }
        self.move_epoch_to_now()?;
        self.motion.set_input(input, poly);
        self.restart_search();
        Ok(())
    }

    /// Adds a constant to an input from now on.
    pub(crate) fn add_to_input(&mut self, input: Input, constant: f64) -> Result<(), Error> {
        let state = self.motion.state();
        let mut poly = state.inputs.of(input).shifted(state.now);
        poly.0[0] += constant;
        self.move_epoch_to_now()?;
        self.motion.set_input(input, poly);
        self.restart_search();
        Ok(())
    }

    /// Takes over the tunable parameters among these now; positions and memory are kept.
    ///
    /// # Errors
    /// A parameter out of its domain, or a fixed one that differs from the scene's; nothing is
    /// changed then.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), Error> {
        if parameters == self.parameters() {
            return Ok(());
        }
        let tuned = self.parameters().retuned(parameters)?;
        self.move_epoch_to_now()?;
        let before = Stored::at_epoch(&self.motion).total();
        self.motion.retune(&tuned)?;
        let retuned = Stored::at_epoch(&self.motion).total() - before;
        self.ledger.add(Sums { retuned, ..Sums::default() });
        self.motion.reload();
        self.restart_search();
        Ok(())
    }

    /// One communication step, from the present time to `to`.
    ///
    /// # Errors
    /// `to` before the present or not finite: nothing is changed then. [`Error::Cancelled`]: the
    /// present is the last event, or the present of before if none came, and later steps lead to
    /// the same motion as if it had not been cancelled. Transitions without end, too much work,
    /// a state that is no longer finite: every further step returns the same error.
    pub fn advance(&mut self, to: f64) -> Result<(), Error> {
        self.advance_observed(to, &mut ())
    }

    /// [`Self::advance`] with an observer of every event on the way.
    pub(crate) fn advance_observed(
        &mut self,
        to: f64,
        observer: &mut impl Observer,
    ) -> Result<(), Error> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if !(to.is_finite() && to >= self.time()) {
            return Err(Error::Backwards { from: self.time(), to });
        }
        if self.views.ledger.get().is_some() {
            self.ledger.settle(); // All of it is known: not to be added up again.
        }
        self.views = Views::default();
        self.peaks.begin_step(&self.motion);
        self.blows.step.clear();
        let span = to - self.time();
        self.search.budget.begin_step(&self.motion, span, &self.search.work);
        let done = self.run(to, observer);
        if let Err(error) = &done {
            if self.motion.state().now < 0.0 {
                // The last event has come since the step began: what is read is of then.
                self.motion.set_present(0.0, self.motion.state().epoch.value());
            }
            self.failure =
                Some(error.clone()).filter(|error| !matches!(error, Error::Cancelled { .. }));
        }
        done
    }

    /// What ends a step under way from another thread, see [`Interrupt`].
    pub fn interrupt_handle(&self) -> Interrupt {
        self.search.budget.interrupt.clone()
    }

    /// From now on listens to `interrupt`, which other machines may listen to as well.
    pub fn listen_to(&mut self, interrupt: Interrupt) {
        self.search.budget.interrupt = interrupt;
    }

    fn run(&mut self, to: f64, observer: &mut impl Observer) -> Result<(), Error> {
        loop {
            let (target, reach) = (self.motion.until(to), self.motion.reach());
            let level = self.motion.next_level().filter(|(at, _)| *at <= target.min(reach));
            let end = level.map_or(target.min(reach), |(at, _)| at);
            let found = self.search.next(&mut self.motion, end)?;
            let next = found.or(level.map(|(at, chamber)| (at, Event::Level(chamber))));
            if observer.stops_before(self, next.map_or(end, |(at, _)| at), to)? {
                return Ok(());
            }
            match next {
                Some((at, event)) => {
                    observer.before(self);
                    self.occur(at, event)?;
                    if observer.after(self, event) {
                        self.motion.set_present(0.0, self.motion.state().epoch.value());
                        return Ok(());
                    }
                }
                None if reach < target => {
                    // The series of slow coordinates are made anew from here.
                    observer.before(self);
                    self.move_epoch(reach, true)?;
                    self.search.budget.count(None);
                    self.restart_search();
                }
                None => {
                    self.motion.set_present(target, to);
                    return Ok(());
                }
            }
        }
    }

    /// The transition of an event at `at` after the epoch.
    fn occur(&mut self, at: f64, event: Event) -> Result<(), Error> {
        let from = self.mode();
        self.move_epoch(at, !matches!(event, Event::Rock(_)))?;
        self.counters.events += 1;
        self.search.budget.count(Some(event));
        self.zeno.count(&self.motion, at)?;
        match event {
            Event::Contact => self.switch_contact()?,
            Event::Rock(event) => {
                self.motion.switch_rock(event)?;
                let begun = self.mode().rock == RockMode::DissipativeForward;
                self.counters.rock_cycles += u64::from(begun);
            }
            Event::Relay(_) => self.motion.switch_relay(),
            Event::Port { chamber, port, .. } => self.motion.switch_port(chamber, port),
            Event::Level(chamber) => self.motion.reach_level(chamber),
        }
        if let Some(journal) = &mut self.journal {
            let epoch = self.motion.state().epoch;
            let (time, time_rest) = (epoch.value(), epoch.rest());
            journal.push(Record { time, time_rest, event, mode: self.motion.mode() });
        }
        self.zeno.check_cascade(&self.motion, from)?;
        self.restart_search();
        Ok(())
    }

    fn switch_contact(&mut self) -> Result<(), Error> {
        if self.mode().closed {
            self.blows.note_opening(&self.motion);
        } else {
            self.motion.rotate_to_epoch();
            let closing = self.blows.note_closing(&self.motion);
            self.counters.contacts += u64::from(closing != Closing::Again);
            if closing == Closing::Blow {
                self.counters.blows += 1;
                self.note_work();
            }
            let damping = damping_in_flight(&self.motion, &self.motion.tracks()[1]);
            self.ledger.add(Sums { damping, ..Sums::default() });
        }
        self.motion.switch_contact()
    }

    /// What the rock has been given up to a blow; not summed unless it is asked for.
    fn note_work(&mut self) {
        let per_length = self.parameters().work_per_length();
        let work = (self.keeps_rock_work || per_length.is_some()).then(|| {
            self.ledger.settle();
            let sums = self.ledger.paid().sums;
            sums.rock + sums.viscous
        });
        self.blows.note_work(work, per_length);
    }

    /// Moves the epoch by `at`, and keeps what the sums of the stretch that ends there follow
    /// from; `goes_on` if the rock's law is the same after it.
    fn move_epoch(&mut self, at: f64, goes_on: bool) -> Result<(), Error> {
        self.search.bring_tip(&mut self.motion, at);
        self.blows.note_stretch(&self.motion, at);
        let (end, form) = (&self.motion.tracks()[0].z, self.search.viscous_form());
        let owed = Arc::new(Owed::new(&self.motion, end, at, form));
        self.peaks.record(&self.motion, &owed);
        // What the barrier has seen counts only while the same cycle goes on.
        let by_series = self.search.sums_series(&self.motion.tracks()[0]);
        let viscous = if goes_on { owed.viscous_seen(by_series) } else { 0.0 };
        self.ledger.owe(owed);
        self.counters.near_misses += self.search.stop(at);
        self.views = Views::default();
        self.motion.move_epoch(at, viscous)
    }

    /// Makes the present the epoch.
    pub(crate) fn settle(&mut self) -> Result<(), Error> {
        self.move_epoch_to_now()?;
        self.restart_search();
        Ok(())
    }

    /// Puts the hammer into another mode and state now; energies are counted from here.
    pub(crate) fn place(
        &mut self,
        mode: Mode,
        memory: Memory,
        psi: f64,
        gas: [Gas; 2],
        whole: &[f64],
    ) -> Result<(), Error> {
        self.move_epoch_to_now()?;
        self.motion.place(mode, memory, psi, gas, whole)?;
        let energy_start = Stored::at_epoch(&self.motion).total();
        self.ledger = Ledger { energy_start, ..Ledger::default() }.into();
        self.restart_search();
        Ok(())
    }

    /// Moves the epoch to the present time, from the last event in one flow; what the search
    /// saw ahead of the present is void.
    fn move_epoch_to_now(&mut self) -> Result<(), Error> {
        self.motion.rewind();
        let now = self.motion.state().now;
        self.counters.near_misses += self.search.stop(now);
        self.move_epoch(now, true)
    }

    /// Starts the search for the next event at the epoch.
    fn restart_search(&mut self) {
        self.views = Views::default();
        self.search.start(&self.motion);
    }

    /// The whole dynamic state.
    pub fn state(&self) -> State {
        State {
            parameters: *self.parameters(),
            motion: self.motion.state().clone(),
            ledger: self.ledger.clone(),
            counters: Counters { basis_changes: self.motion.basis_changes(), ..self.counters },
            blows: self.blows.clone(),
            peaks: self.peaks.recorded(),
            step_start: self.peaks.step_start(),
            zeno: self.zeno,
        }
    }

    /// Continues from a state of a scene of the same make, bit for bit.
    ///
    /// # Errors
    /// A state of another make (parameters or dimensions differ), or of none; nothing is
    /// changed then.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        state.check()?;
        self.motion.restore(&state.parameters, &state.motion, state.counters.basis_changes)?;
        (self.ledger, self.blows) = (state.ledger.clone(), state.blows.clone());
        self.peaks = PeakSearch::resume(state.peaks, state.step_start);
        (self.zeno, self.counters) = (state.zeno, state.counters);
        self.failure = None;
        self.restart_search();
        Ok(())
    }

    /// Keeps the work given to the rock from blow to blow ([`rock_work`](crate::Blow)), also
    /// where no specific energy asks for it; the motion does not depend on it.
    pub fn keep_rock_work(&mut self, keep: bool) {
        self.keeps_rock_work = keep;
    }

    /// Starts or stops keeping a journal of transitions.
    pub fn keep_journal(&mut self, keep: bool) {
        self.journal = keep.then(Vec::new);
    }

    /// The transitions since the last call.
    pub fn take_journal(&mut self) -> Vec<Record> {
        self.journal.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Puts another journal in place of the one that is kept, if any.
    pub(crate) fn exchange_journal(&mut self, other: Option<Vec<Record>>) -> Option<Vec<Record>> {
        std::mem::replace(&mut self.journal, other)
    }

    /// Counts so far.
    pub fn counters(&self) -> Counters {
        let work = &self.search.work;
        Counters {
            near_misses: self.counters.near_misses
                + self.search.near_misses(self.motion.state().now),
            basis_changes: self.motion.basis_changes(),
            guard_evaluations: work.evaluations,
            samples: work.samples,
            windows: work.windows,
            ..self.counters
        }
    }
}
