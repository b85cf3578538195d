//! The hybrid machine: exact flow from event to event.
//!
//! ```text
//! advance(to):
//!     while an event e of the present mode comes first, at t <= to:
//!         x- := flow(x, t)                      exact: modal exponentials and polynomials
//!         (mode, x+) := transit(e, mode, x-)    order at one instant: contact, rock, relay
//!         track the guards of the new mode from t on
//!     now := to                                 the state is read, not changed
//! ```
//!
//! The state belongs to the last event. A communication point reads it without changing it, and the search for the next
//! event does not depend on where the host stops. Hence the trajectory is identical to the last binary digit, however
//! the host divides the time into steps. The epoch moves only when the future really changes: at an event, when an
//! input becomes another polynomial, or when a parameter is tuned.

pub(crate) mod blows;
pub(crate) mod exchange;
pub(crate) mod journal;
pub(crate) mod outputs;
mod recorder;
pub(crate) mod state;
pub(crate) mod stops;
mod views;
pub(crate) mod zeno;

use crate::allowance::Allowance;
use crate::energy::deferred::DeferredLedger;
use crate::energy::interval::{Interval, Sums};
use crate::energy::ledger::{Ledger, Stored, damping_in_flight};
use crate::energy::peaks::PeakSearch;
use crate::error::Error;
use crate::laws::air::Opening;
use crate::laws::event::{Bodies, Event};
use crate::laws::mode::{Mode, RockMode, Tie, TieState};
use crate::modal::model::Model;
use crate::modal::track::ROUNDED;
use crate::motion::Motion;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{InputValues, Parameters};
use crate::scene::Scene;
use crate::scene::graph::Channel;
use crate::search::Search;
use blows::Progress;
use exchange::Exchange;
use journal::{Counters, Record};
use recorder::Recorder;
use serde::{Deserialize, Serialize};
use views::Views;
use zeno::ZenoDetector;

/// Observes the events of a step, and may end it at one.
pub(crate) trait Observer {
    /// Called before the epoch moves.
    fn before(&mut self, _machine: &Machine) {}

    /// Called after an event, at the epoch; true ends the step there.
    fn after(&mut self, _machine: &Machine, _event: Event) -> bool {
        false
    }

    /// Returns true if [`Self::stops_before`] may end a step.
    fn may_stop(&self) -> bool {
        false
    }

    /// May end the step between events, before `until` after the epoch, by moving the present there. Returns true if it
    /// did.
    fn stops_before(&mut self, _: &mut Machine, _until: f64, _to: f64) -> Result<bool, Error> {
        Ok(false)
    }
}

impl Observer for () {}

/// Everything that has been summed, counted and recorded since the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct History {
    /// Sums up to the last event.
    pub ledger: DeferredLedger,
    /// Counters, without the search's work.
    pub counters: Counters,
    /// Blows and collisions so far.
    pub blows: Progress,
    /// Observer that completes the record of each blow, if records are requested.
    pub recorder: Option<Recorder>,
    /// Peaks of the present step before the last event.
    pub peaks: PeakSearch,
    /// Spacing of recent transitions.
    pub zeno: ZenoDetector,
}

/// A scene in motion.
///
/// ```
/// let mut hammer = hammer::Scene::default().machine()?;
/// hammer.advance(0.1)?; // to t = 0.1 s, in a step of any size
///
/// let last = hammer.blow().expect("a blow every 45 ms");
/// assert!(last.time <= hammer.time() && last.rop > 0.0);
/// assert!(hammer.energies().residual.abs() < 1e-9 * hammer.energies().turnover());
/// # Ok::<(), hammer::Error>(())
/// ```
#[derive(Debug)]
pub struct Machine {
    motion: Motion,
    search: Search,
    history: History,
    exchange: Exchange,
    journal: Option<Vec<Record>>,
    failure: Option<Error>,
    views: Views,
}

impl Scene {
    /// The scene at its start, at time 0.
    ///
    /// # Errors
    /// Those of [`Machine::new`].
    pub fn machine(&self) -> Result<Machine, Error> {
        Machine::new(&self.parameters, &self.inputs, 0.0)
    }
}

impl Machine {
    /// The scene at its start: the piston at rest or at its initial velocity; the bit in static
    /// equilibrium in standstill, or, if its loads lift it, in free flight, at rest and just
    /// touching the rock. Nothing oscillates.
    ///
    /// ```
    /// use hammer::{InputValues, Machine, Parameters};
    ///
    /// let hammer = Machine::new(&Parameters::default(), &InputValues::default(), 2.0)?;
    /// assert_eq!(hammer.time(), 2.0);
    ///
    /// let mut parameters = Parameters::default();
    /// parameters.rock.stiffness = -1.0;
    /// let refused = Machine::new(&parameters, &InputValues::default(), 0.0);
    /// assert!(refused.unwrap_err().to_string().starts_with("rock.stiffness = -1"));
    /// # Ok::<(), hammer::Error>(())
    /// ```
    ///
    /// # Errors
    /// A parameter or input out of its domain; a spectrum that cannot be resolved.
    pub fn new(parameters: &Parameters, inputs: &InputValues, start: f64) -> Result<Self, Error> {
        let model = Model::new(parameters)?;
        let inputs = Inputs::constant(inputs);
        for input in Input::ALL {
            let (value, source) = (inputs.of(input).0[0], parameters.drive.source);
            input.polynomial(&[value], source).map_err(Error::of_input(input))?;
        }
        if !start.is_finite() {
            return Err(Error::Backwards { from: start, to: start });
        }
        let exchange = Exchange::new(&inputs);
        let motion = Motion::new(model, inputs, start)?;
        let mut machine = Self {
            history: History {
                ledger: DeferredLedger::default(),
                counters: Counters::default(),
                blows: Progress::new(&motion),
                recorder: None,
                peaks: PeakSearch::default(),
                zeno: ZenoDetector::new(start),
            },
            motion,
            search: Search::default(),
            exchange,
            journal: None,
            failure: None,
            views: Views::default(),
        };
        if machine.kinematics().gap.displacement < -machine.motion.least_overlap() {
            // Gravity presses the bit down while the feed pulls it against the piston, so the two are in contact.
            machine.switch_contact(TieState::Pressed)?;
        }
        let energy_start = Stored::at_epoch(&machine.motion).total();
        machine.history.ledger = Ledger { energy_start, ..Ledger::default() }.into();
        machine.resume()?;
        Ok(machine)
    }

    pub(crate) fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.motion.state.time
    }

    /// Discrete state.
    pub fn mode(&self) -> Mode {
        self.motion.mode()
    }

    /// Parameters, with the present tunable values.
    pub fn parameters(&self) -> &Parameters {
        self.motion.parameters()
    }

    /// Value of an input now.
    pub fn input(&self, input: Input) -> f64 {
        let state = &self.motion.state;
        let acting = || state.inputs.of(input).at(state.now);
        self.exchange.value(input).unwrap_or_else(acting)
    }

    /// Replaces an input, from now on, by the polynomial of time with this value and these derivatives, in the input's
    /// unit per s, per s2, ...
    ///
    /// # Errors
    /// A number that is not finite, or too many derivatives; nothing is changed then.
    pub fn set_input(&mut self, input: Input, derivatives: &[f64]) -> Result<(), Error> {
        let source = self.parameters().drive.source;
        let poly = input.polynomial(derivatives, source).map_err(Error::of_input(input))?;
        let repeats = self.exchange.repeats(input, &poly) && self.parameters().drive.delay != 0.0;
        let state = &self.motion.state;
        if repeats || state.inputs.of(input).shifted(state.now) == poly {
            return Ok(());
        }
        self.put(&[(input, poly)])
    }

    /// Replaces inputs by polynomials from now on.
    fn put(&mut self, inputs: &[(Input, Poly)]) -> Result<(), Error> {
        self.move_epoch_to_now()?;
        if self.motion.loads()[Channel::Drive as usize] == Poly::default() {
            self.history.blows.acts_since = self.motion.state.epoch;
        }
        inputs.iter().for_each(|(input, poly)| self.motion.set_input(*input, *poly));
        self.resume()
    }

    pub(crate) fn add_to_input(&mut self, input: Input, constant: f64) -> Result<(), Error> {
        let state = &self.motion.state;
        let mut poly = state.inputs.of(input).shifted(state.now);
        poly.0[0] += constant;
        self.exchange.shift(input, constant);
        self.put(&[(input, poly)])
    }

    /// Adopts the tunable parameters among these from now on; positions and memory are unchanged.
    ///
    /// # Errors
    /// A parameter out of its domain, or a fixed one that differs from the scene's; nothing is
    /// changed then.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), Error> {
        if parameters == self.parameters() {
            return Ok(());
        }
        let tuned = self.motion.retuned(&self.parameters().retuned(parameters)?)?;
        self.move_epoch_to_now()?;
        let before = Stored::at_epoch(&self.motion).total();
        self.motion.retune(tuned)?;
        let retuned = Stored::at_epoch(&self.motion).total() - before;
        self.history.ledger.add(Sums { retuned, ..Sums::default() });
        self.motion.reload();
        self.resume()
    }

    /// One communication step, from the present time to `to`.
    ///
    /// ```
    /// let scene = hammer::Scene::default();
    /// let (mut one, mut many) = (scene.machine()?, scene.machine()?);
    /// one.advance(0.1)?;
    /// (1..=100).try_for_each(|k| many.advance(0.001 * f64::from(k)))?;
    /// assert_eq!(one.kinematics(), many.kinematics()); // identical to the last binary digit
    /// # Ok::<(), hammer::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `to` is before the present or not finite, nothing is changed. After [`Error::Cancelled`] the present is the
    /// last event (or unchanged, if there was none), and later steps produce the same motion as without the
    /// cancellation. After Zeno behaviour, too much work or a state that is no longer finite, every further step
    /// returns the same error.
    pub fn advance(&mut self, to: f64) -> Result<(), Error> {
        self.advance_observed(to, &mut ())
    }

    /// [`Self::advance`], with an observer of every event.
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
        let (from, begun) = (self.time(), self.begin_exchange(to)?);
        if self.views.ledger.get().is_some() {
            self.history.ledger.settle(); // Evaluated once here, not at every read.
        }
        self.views.forget();
        self.history.peaks.begin_step(&self.motion);
        self.history.blows.step.clear();
        if !observer.may_stop() && self.is_quiet(to) {
            self.search.budget.paid.set(0);
            self.pass(to);
            self.end_exchange(from, begun);
            return Ok(());
        }
        self.search.budget.begin_step(&self.motion, &self.search.work);
        let allowance = Allowance::of_seconds(self.parameters().work_limit);
        let done = allowance.within(|| {
            let done = self.run(to, observer);
            self.search.budget.pay(&self.search.work);
            done
        });
        if let Err(error) = &done {
            if self.motion.state.now < 0.0 {
                // After an event in this step, outputs are those of the event's instant.
                self.motion.set_present(0.0, self.motion.state.epoch.value());
            }
            self.failure = Some(error.clone()).filter(|error| !matches!(error, Error::Cancelled));
        }
        self.end_exchange(from, begun);
        done
    }

    /// True if the search has already proved that nothing happens up to `to`, and nobody interrupts: then there is no
    /// work to do.
    fn is_quiet(&self, to: f64) -> bool {
        let target = self.motion.state.epoch.until(to);
        self.search.is_clear(target)
            && target <= self.motion.reach()
            && self.history.recorder.is_none()
            && Error::if_interrupted().is_ok()
    }

    /// Moves the present to `to`, before which nothing happens.
    fn pass(&mut self, to: f64) {
        let now = self.motion.state.epoch.until(to).max(0.0); // Never before the event.
        self.motion.set_present(now, to);
    }

    /// Completes the record of a blow that just occurred.
    fn complete_record(&mut self) -> Result<(), Error> {
        let History { ledger, blows, recorder, .. } = &mut self.history;
        let Some(recorder) = recorder else { return Ok(()) };
        recorder.complete(&self.motion, ledger, blows)?;
        recorder.peaks.work_off()
    }

    fn run(&mut self, to: f64, observer: &mut impl Observer) -> Result<(), Error> {
        loop {
            self.complete_record()?;
            self.history.ledger.work_off()?;
            self.history.peaks.work_off()?;
            // Rounding may put the host's time of an event before the event.
            let target = self.motion.state.epoch.until(to).max(-ROUNDED);
            let reach = self.motion.reach();
            let end = target.min(reach);
            let next = self.search.next(&mut self.motion, end)?;
            if observer.stops_before(self, next.map_or(end, |(at, _)| at), to)? {
                return Ok(());
            }
            match next {
                Some((at, event)) => {
                    // This is the long part of a transition. An interrupt may end it before anything has changed.
                    self.motion.prepare(event)?;
                    observer.before(self);
                    self.occur(at, event)?;
                    self.complete_record()?;
                    if observer.after(self, event) {
                        self.motion.set_present(0.0, self.motion.state.epoch.value());
                        return Ok(());
                    }
                }
                None if reach < target => {
                    // The series of slow coordinates are renewed here.
                    observer.before(self);
                    self.move_epoch(reach, None)?;
                    self.search.budget.count(None);
                    self.resume()?;
                }
                None => {
                    self.pass(to);
                    return Ok(());
                }
            }
        }
    }

    /// Performs the transition of an event at `at` after the epoch.
    fn occur(&mut self, at: f64, event: Event) -> Result<(), Error> {
        let from = self.mode();
        self.move_epoch(at, Some(event))?;
        self.history.counters.events += 1;
        self.search.budget.count(Some(event));
        self.history.zeno.count(&self.motion, at)?;
        match event {
            Event::Tie(Tie::Contact, to) => self.switch_contact(to)?,
            Event::Tie(tie, to) => self.motion.switch_tie(tie, to)?,
            Event::Rock(event) => {
                self.motion.switch_rock(event)?;
                let begun = self.mode().rock == RockMode::DissipativeForward;
                self.history.counters.rock_cycles += u64::from(begun);
            }
            Event::Relay(_) => self.motion.switch_relay(),
            Event::Port { chamber, port, opens } => {
                let opening = if opens { Opening::Partial } else { Opening::Closed };
                self.motion.switch_port(chamber, port, opening);
            }
            Event::Opening { chamber, port, full } => {
                let opening = if full { Opening::Full } else { Opening::Partial };
                self.motion.switch_port(chamber, port, opening);
            }
            Event::Vent(vented) => {
                self.motion.switch_vent(vented);
                self.history.blows.acts_since = self.motion.state.epoch;
            }
            Event::End(inside) => self.motion.pass_end(inside),
        }
        if let Some(journal) = &mut self.journal {
            let epoch = self.motion.state.epoch;
            let (time, time_rest) = (epoch.value(), epoch.rest());
            journal.push(Record { time, time_rest, event, mode: self.motion.mode() });
        }
        self.history.zeno.check_simultaneous(&self.motion, from)?;
        self.resume()
    }

    fn switch_contact(&mut self, to: TieState) -> Result<(), Error> {
        if to == TieState::Open {
            self.history.blows.note_opening(&self.motion);
            let recorder = self.history.recorder.as_mut();
            recorder.into_iter().for_each(|recorder| recorder.note_opening(&self.motion));
        } else {
            self.motion.rotate_to_epoch(Bodies::PISTON);
            let History { blows, counters, recorder, .. } = &mut self.history;
            if blows.note_closing(&self.motion, counters) {
                recorder.iter_mut().for_each(Recorder::note_blow);
            }
            let damping = damping_in_flight(&self.motion, &self.motion.tracks);
            self.history.ledger.add(Sums { damping, ..Sums::default() });
        }
        self.motion.switch_tie(Tie::Contact, to)
    }

    /// Moves the epoch by `at`, where an event may happen, and adds the interval before it to the deferred ledger.
    fn move_epoch(&mut self, at: f64, event: Option<Event>) -> Result<(), Error> {
        self.search.bring_tip(&mut self.motion, at);
        self.motion.rotate_others_to(at);
        self.history.blows.note_stretch(&self.motion, at);
        let touched = self.motion.touched(event);
        let (ends, viscous) = (&self.motion.tracks, self.search.viscous(at));
        let make = || Interval::new(&self.motion, ends, touched, at, viscous);
        let deferred = self.history.ledger.defer(make);
        self.history.peaks.record(&self.motion, deferred);
        if let Some(recorder) = &mut self.history.recorder {
            recorder.peaks.record(&self.motion, deferred);
        }
        let interval = &deferred.interval;
        let work = interval.given.iter().sum();
        self.history.blows.note_work(work, work / self.motion.parameters().work_per_length());
        // The barrier's estimate is valid only within the same drilling cycle.
        let goes_on = !matches!(event, Some(Event::Rock(_)));
        let by_series = goes_on && self.search.sums_series(&self.motion);
        let (mut viscous, panels) = interval.viscous_of_barrier(by_series);
        if !goes_on {
            viscous = 0.0;
        }
        self.search.work.count_panels(panels);
        self.search.stop();
        self.views.forget();
        self.motion.move_epoch(at, touched, viscous)
    }

    /// Moves the epoch to the present time, by one flow from the last event, and restarts the search there.
    fn move_epoch_to_now(&mut self) -> Result<(), Error> {
        self.motion.return_to_anchors(f64::NEG_INFINITY);
        let now = self.motion.state.now;
        self.search.stop();
        self.move_epoch(now, None)
    }

    /// Continues from the epoch: solves the window of air or of a line, then starts the search for the next event.
    fn resume(&mut self) -> Result<(), Error> {
        let series = self.motion.renew_air()?;
        self.search.work.count_air([self.motion.renew_line()?, series]);
        self.restart_search();
        Ok(())
    }

    fn restart_search(&mut self) {
        self.views.forget();
        self.search.start(&self.motion);
    }
}
