//! One instance, and the order of calls that the standard allows. Pointers stay in `abi.rs`.
//!
//! Every method either succeeds, or returns a [`CallError`] and changes nothing. The exception is a step in which the
//! engine fails: afterwards the instance can only be read, until it is reset or a state is restored.

mod derivatives;
mod events;
mod inputs;
mod journal;
mod settings;
mod snapshot;
mod typed;
mod values;
mod warnings;

pub use events::Face;
pub use journal::Line;
pub use snapshot::Snapshot;

use crate::category::Category;
use crate::error::CallError;
use crate::variant::Variant;
use events::Events;
use hammer::variables::{InputRow, Role, VARIABLES};
use hammer::{
    Counters, DisplayNumber, InputValues, Interrupt, Machine, Parameters, Profile, Record, Scene,
    State, Stop,
};
use inputs::Inputs;
use journal::Journal;
use serde::{Deserialize, Serialize};
use settings::Settings;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use warnings::Warnings;

/// Tolerance of communication points and stop times, in units of `1 + |t|` seconds, because hosts add up step sizes.
const TIME_TOLERANCE: f64 = 1e-9;
/// A host may overshoot its own stop time by this, in units of `1 + |t|` seconds.
const STOP_TOLERANCE: f64 = 1e-6;
/// Longest run, s. Beyond it the spacing of doubles (1e-10 s) approaches the duration of a collision. If a run starts
/// later, as in hosts that count from 1970, its time is counted from its start.
const LATEST: f64 = 1e6;
/// Latest start, s.
const LATEST_START: f64 = 1e10;
/// Longest step, s: a longer one is probably a mistake and would hang the host.
const LONGEST_STEP: f64 = 1e3;

/// Phase of an instance in the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Terminated,
    Failed,
}

impl Phase {
    const fn describe(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::Stepping => "while stepping",
            Self::Terminated => "after termination",
            Self::Failed => "after a failed step",
        }
    }
}

/// Scene and start time of an engine that does not run yet.
type Origin = (Scene, f64);

/// Cancels long work from another thread: a step, the end of initialization, derivatives.
#[derive(Clone, Debug, Default)]
pub struct Cancel {
    interrupt: Interrupt,
    /// True while long work is under way.
    working: Arc<AtomicBool>,
}

impl Cancel {
    /// Cancels the work under way; false if there is none.
    pub fn cancel(&self) -> bool {
        let working = self.working.load(Ordering::SeqCst);
        if working {
            self.interrupt.set();
        }
        working
    }

    /// Performs work that [`Self::cancel`] can end.
    fn over<T>(&self, work: impl FnOnce() -> T) -> T {
        self.interrupt.clear();
        self.working.store(true, Ordering::SeqCst);
        let done = self.interrupt.watch(work);
        self.working.store(false, Ordering::SeqCst);
        self.interrupt.clear();
        done
    }
}

/// One instance of the FMU.
pub struct Instance {
    variant: Variant,
    face: Face,
    cancel: Cancel,
    events: Events,
    phase: Phase,
    settings: Settings,
    inputs: Inputs,
    start: f64,
    stop: Option<f64>,
    retune: bool,
    last_step_failed: bool,
    machine: Option<Machine>,
    origin: Option<Origin>,
    /// Waves along the bars at this communication point, if they were read.
    waves: Option<Profile>,
    warnings: Warnings,
    /// Start of the last step, s, and the state at this time if an event has moved the engine since.
    step_start: Option<(f64, Option<Box<State>>)>,
    journal: Journal,
}

impl Instance {
    /// A new instance of a variant, with debug logging on or off.
    pub fn new(variant: Variant, face: Face, debug: bool) -> Self {
        let (settings, inputs, events) = starting(&variant);
        Self {
            variant,
            face,
            cancel: Cancel::default(),
            events,
            phase: Phase::Instantiated,
            settings,
            inputs: Inputs::new(inputs),
            start: 0.0,
            stop: None,
            retune: false,
            last_step_failed: false,
            machine: None,
            origin: None,
            waves: None,
            warnings: Warnings::default(),
            step_start: None,
            journal: Journal::new(debug, debug || face == Face::Two),
        }
    }

    fn demand(&self, call: &'static str, allowed: &[Phase]) -> Result<(), CallError> {
        if allowed.contains(&self.phase) {
            return Ok(());
        }
        if self.phase == Phase::Failed {
            return Err(CallError::Failed);
        }
        Err(self.out_of_order(call))
    }

    /// Sets start time and, if given, stop time, both in s. A tolerance would have no effect.
    ///
    /// # Errors
    /// Initialization mode was entered before, or the times are not finite or not in order.
    pub fn set_up(&mut self, start: f64, stop: Option<f64>) -> Result<(), CallError> {
        self.demand("SetupExperiment", &[Phase::Instantiated])?;
        finite("startTime", start)?;
        if start.abs() > LATEST_START {
            return Err(CallError::Argument(format!(
                "startTime = {} s is beyond {LATEST_START} s",
                DisplayNumber(start)
            )));
        }
        if let Some(stop) = stop {
            finite("stopTime", stop)?;
            if stop < start {
                let (stop, start) = (DisplayNumber(stop), DisplayNumber(start));
                let text = format!("stopTime = {stop} s is before startTime = {start} s");
                return Err(CallError::Argument(text));
            }
        }
        (self.start, self.stop) = (start, stop);
        Ok(())
    }

    /// Enters initialization mode.
    ///
    /// # Errors
    /// Initialization mode was entered before.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        self.demand("EnterInitializationMode", &[Phase::Instantiated])?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Checks the parameters and creates the scene.
    ///
    /// # Errors
    ///
    /// The instance is not in initialization mode, or a parameter is outside its domain or belongs to a drive that does
    /// not act. The host can then correct the parameter and repeat the call, or reset the instance.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.demand("ExitInitializationMode", &[Phase::Initialization])?;
        self.events.check()?;
        let (start, ..) = starting(&self.variant);
        self.settings.check_drive(&self.settings.parameters()?, &start)?;
        let cancel = self.cancel.clone();
        let machine = cancel.over(|| self.machine())?;
        let (parameters, mut warnings) = (*machine.parameters(), machine.warnings());
        self.phase = Phase::Stepping;
        self.origin = None;
        self.begin_events();
        warnings.extend(warnings::of_values(&self.settings, &self.inputs));
        warnings.extend(self.warnings.ignored(&parameters, &self.inputs));
        self.warn(warnings);
        Ok(())
    }

    fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        for warning in warnings {
            self.journal.write(Category::Warning, || warning);
        }
    }

    /// Warns if the energies do not balance, unless a failed step has reported an error.
    fn check_balance(&mut self) {
        let Some(machine) = &self.machine else { return };
        if self.phase == Phase::Failed {
            return;
        }
        let lines = self.warnings.unbalanced(&machine.energies());
        self.warn(lines);
    }

    /// Ends the simulation. Outputs remain readable.
    ///
    /// # Errors
    /// The instance is not initialized, or was terminated before.
    pub fn terminate(&mut self) -> Result<(), CallError> {
        // After a failed step, hosts call this before they free the instance.
        if self.phase != Phase::Failed {
            self.demand("Terminate", &[Phase::Stepping])?;
            self.check_balance();
        }
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// Returns to the state after [`Instance::new`], except for the log's categories.
    pub fn reset(&mut self) {
        let journal = std::mem::replace(&mut self.journal, Journal::new(false, false));
        let cancel = self.cancel.clone();
        *self = Self { journal, cancel, ..Self::new(self.variant.clone(), self.face, false) };
    }

    /// Integrates exactly from the communication point to `point + size`, s, or to an event if the host allows it.
    /// Returns why the step ended early.
    ///
    /// # Errors
    ///
    /// Nothing changes if the call is out of order, the point is not the present, the size is negative, far too large
    /// or not finite, or the stop time is exceeded. If the engine fails, the instance can only be read until it is
    /// reset or restored.
    pub fn step(&mut self, point: f64, size: f64) -> Result<Stop, CallError> {
        self.last_step_failed = true;
        self.demand("DoStep", &[Phase::Stepping])?;
        let now = self.time();
        let target = self.check_step(now, point, size)?;
        let before = self.listen();
        let cancel = self.cancel.clone();
        let stop = match cancel.over(|| self.advance(target)) {
            Ok(stop) => stop,
            Err(error) => {
                self.phase = Phase::Failed;
                return Err(error);
            }
        };
        self.last_step_failed = false;
        if let Some(before) = before {
            self.report_step(now, before);
        }
        Ok(stop)
    }

    fn advance(&mut self, target: f64) -> Result<Stop, CallError> {
        self.waves = None;
        let Some(machine) = &mut self.machine else { return Err(CallError::Failed) };
        let changed = self.retune || self.inputs.wait();
        if self.retune {
            let tuned = self.settings.parameters()?;
            machine.retune(&tuned)?;
            self.retune = false;
        }
        let mut lines = Vec::new();
        if changed {
            lines = self.warnings.ignored(machine.parameters(), &self.inputs);
            self.inputs.apply(machine)?;
        }
        let target = (target - zero_of(self.start)).max(machine.time());
        if target > machine.time() {
            lines.extend(self.warnings.starved(machine, &self.inputs));
        }
        let start = machine.time();
        self.step_start = None;
        let stops = self.events.stops(self.face);
        let done = machine.advance_keeping_start(target, stops);
        self.inputs.pass();
        self.warnings.after_step(machine, &mut lines);
        if !lines.is_empty() {
            self.warn(lines);
        }
        let (begun, stop) = done?;
        self.step_start = Some((start, begun));
        Ok(stop)
    }

    /// The end of the step, s, or an error if it is not allowed.
    fn check_step(&self, now: f64, point: f64, size: f64) -> Result<f64, CallError> {
        finite("currentCommunicationPoint", point)?;
        finite("communicationStepSize", size)?;
        let refuse = |text: String| Err(CallError::Argument(text));
        let (displayed_point, displayed_now, displayed_size) =
            (DisplayNumber(point), DisplayNumber(now), DisplayNumber(size));
        let far = |time: f64| 1.0 + (time - zero_of(self.start)).abs();
        // After a late start, both the host and this code round instants.
        let rounded = if zero_of(self.start) == 0.0 { 0.0 } else { 4.0 * f64::EPSILON * now.abs() };
        if (point - now).abs() > TIME_TOLERANCE * far(now) + rounded {
            return refuse(format!(
                "currentCommunicationPoint = {displayed_point} s, but the time is {displayed_now} s"
            ));
        }
        if !(0.0..=LONGEST_STEP).contains(&size) {
            return refuse(format!(
                "communicationStepSize = {displayed_size} s is not allowed: it must be 0 to {LONGEST_STEP}"
            ));
        }
        let target = point + size;
        let stop = self.stop.unwrap_or(zero_of(self.start) + LATEST);
        if target > stop + STOP_TOLERANCE * far(stop) + rounded {
            let (target, stop) = (DisplayNumber(target), DisplayNumber(stop));
            return refuse(format!("a step to {target} s goes past the stop time {stop} s"));
        }
        // Rounding must not make the engine go back.
        Ok(target.max(now))
    }

    /// The counts before the next step, if it will be logged.
    fn listen(&mut self) -> Option<Counters> {
        let machine = self.machine.as_mut().filter(|_| self.journal.wants_debug())?;
        machine.keep_journal(self.journal.wants(Category::Modes));
        Some(machine.counters())
    }

    fn report_step(&mut self, from: f64, before: Counters) {
        let Some(machine) = &mut self.machine else { return };
        let (after, to) = (machine.counters(), DisplayNumber(machine.time()));
        let from = DisplayNumber(from);
        for Record { time, event, mode, .. } in machine.take_journal() {
            self.journal.write(Category::Modes, || {
                let contact = if mode.closed() { "closed" } else { "open" };
                let time = DisplayNumber(time);
                format!(
                    "{time} s, {event}: rock {:?}, contact {contact}, relay {:?}",
                    mode.rock, mode.relay
                )
            });
        }
        machine.keep_journal(false);
        if after.events > before.events {
            self.journal.write(Category::Events, || {
                format!(
                    "{from} s to {to} s: {} changes of mode, {} collisions, {} blows",
                    after.events - before.events,
                    after.contacts - before.contacts,
                    after.blows - before.blows
                )
            });
        }
    }

    /// The handle that cancels long work from another thread.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// The scene as it is set before the first step.
    ///
    /// # Errors
    /// A parameter out of its domain.
    pub fn scene(&self) -> Result<Scene, CallError> {
        Ok(Scene { parameters: self.settings.parameters()?, inputs: self.inputs.starting() })
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        match &self.machine {
            Some(machine) if self.origin.is_none() => self.on_clock(machine.time()),
            _ => self.start,
        }
    }

    /// Converts the engine's time to the host's, s.
    fn on_clock(&self, time: f64) -> f64 {
        time + zero_of(self.start)
    }

    /// True if the last call of [`Instance::step`] failed.
    pub fn last_step_failed(&self) -> bool {
        self.last_step_failed
    }

    /// Marks the instance as failed after a panic. It may still be readable.
    pub fn give_up(&mut self) {
        self.phase = Phase::Failed;
    }

    /// Switches log categories.
    ///
    /// # Errors
    /// A name that is no category.
    pub fn switch_logging(&mut self, on: bool, names: &[String]) -> Result<(), CallError> {
        self.journal.switch(on, names)
    }

    /// Logs why a call was refused.
    pub fn complain(&mut self, error: &CallError) {
        self.journal.write(Category::Error, || error.to_string());
    }

    /// Takes the finished log lines out.
    pub fn take_lines(&mut self) -> Vec<Line> {
        self.journal.take()
    }

    /// The engine, with everything that was set. Before it runs, it is created again from the parameters whenever they
    /// have changed.
    fn machine(&mut self) -> Result<&mut Machine, CallError> {
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            let origin @ (scene, start) = (self.scene()?, self.start);
            if self.origin != Some(origin) {
                self.waves = None;
                let begin = start - zero_of(start);
                self.machine = Some(Machine::new(&scene.parameters, &scene.inputs, begin)?);
                self.origin = Some(origin);
                self.inputs.reapply();
            }
        }
        let Some(machine) = &mut self.machine else { return Err(CallError::Failed) };
        self.inputs.apply(machine)?;
        Ok(machine)
    }
}

/// Start values of a variant.
fn starting(variant: &Variant) -> (Settings, InputValues, Events) {
    let mut settings = Settings::of(&Parameters::default());
    let (mut inputs, mut events) = (InputValues::default(), Events::default());
    for (reference, value) in variant.start_values() {
        let row = *reference as usize;
        match VARIABLES.get(row).map(|variable| &variable.role) {
            Some(Role::Input(InputRow { start, .. })) => *start(&mut inputs) = *value,
            Some(_) => settings.set(row, *value),
            None => events.start_with(*reference, *value),
        }
    }
    (settings, inputs, events)
}

/// Origin of the engine's time for a run that starts at `start`, s.
fn zero_of(start: f64) -> f64 {
    if start.abs() > LATEST { start } else { 0.0 }
}

/// Refuses a number that is not finite.
fn finite(name: &'static str, value: f64) -> Result<(), CallError> {
    if value.is_finite() { Ok(()) } else { Err(CallError::NotFinite { name, value }) }
}
