//! The modes and events of FMI 3.0.

use super::{Instance, Phase};
use crate::error::CallError;
use crate::events::{Extra, Length, MAX_LENGTH, MAX_POSITIONS};
use hammer::{Input, Machine, ParameterError, Stop, Stops};
use serde::{Deserialize, Serialize};

/// The version of FMI that the host uses, and the options that it has chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three {
        /// True if the host handles events.
        event_mode: bool,
        /// True if steps may end early.
        early_return: bool,
    },
}

impl Face {
    /// The name of a call in this version of FMI.
    pub fn call(self, name: &str) -> String {
        let three = match (self, name) {
            (Self::Two, _) => return format!("fmi2{name}"),
            (_, "SetReal") => "SetFloat64",
            (_, "SetInteger") => "SetInt32 (or SetInt64)",
            (_, "SetupExperiment") => "EnterInitializationMode",
            (_, same) => same,
        };
        format!("fmi3{three}")
    }

    fn handles_events(self) -> bool {
        matches!(self, Self::Three { event_mode: true, .. })
    }
}

/// A mode of FMI 3.0 within a [`Phase`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Mode {
    /// The usual mode of the phase. While stepping, this is step mode.
    #[default]
    Plain,
    /// Configuration mode, before initialization: structural parameters may be set.
    Configuration,
    /// Event mode, between steps: the host handles events.
    Event,
}

/// The host's choices about events, arrays and slopes, and the events of the last step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Events {
    pub(super) mode: Mode,
    pub(super) blow: bool,
    pub(super) positions: i32,
    pub(super) position: [f64; MAX_POSITIONS],
    pub(super) lengths: [u64; Length::ALL.len()],
    pub(super) slopes: [f64; Input::ALL.len()],
    stops: Option<Stops>,
    /// Events of the last step.
    last: Stop,
}

impl Default for Events {
    fn default() -> Self {
        Self {
            mode: Mode::Plain,
            blow: true,
            positions: 0,
            position: [0.0; MAX_POSITIONS],
            lengths: Length::START,
            slopes: [0.0; Input::ALL.len()],
            stops: None,
            last: Stop::default(),
        }
    }
}

impl Events {
    /// True if calls of a host can have led to this state. This is checked because a stored state may be corrupt.
    pub(super) fn is_sound(&self) -> bool {
        let positions = self.position.get(..self.positions.unsigned_abs() as usize);
        let fit =
            |stops: &Stops| positions.is_some_and(|positions| stops.are(self.blow, positions));
        self.last.position.is_none_or(|index| index < MAX_POSITIONS)
            && self.position.iter().all(|position| position.is_finite())
            && Input::ALL.iter().all(|i| i.check(1, self.slopes[*i as usize]).is_ok())
            && self.lengths.iter().all(|length| (1..=MAX_LENGTH).contains(length))
            && self.stops.as_ref().is_none_or(fit)
    }

    /// These events, adapted to the restored state of the engine and to the host, which may not handle events.
    pub(super) fn of_state(&self, face: Face, machine: Option<&Machine>) -> Self {
        let mut events = self.clone();
        if let (Some(stops), Some(machine)) = (&mut events.stops, machine) {
            stops.settle(machine);
        }
        if events.mode == Mode::Event && !face.handles_events() {
            events.mode = Mode::Plain;
        }
        events
    }

    /// Sets a start value from the model description of a variant.
    pub(super) fn start_with(&mut self, reference: u32, value: f64) {
        match Extra::of(reference) {
            Some(Extra::EventBlow) => self.blow = value != 0.0,
            Some(Extra::Positions) => self.positions = value as i32,
            Some(Extra::Position(index)) => self.position[index] = value,
            Some(Extra::Length(length)) => self.lengths[length as usize] = value as u64,
            _ => {}
        }
    }

    /// The stops, if the host handles events. They end a step only if the host accepts an early return; otherwise they
    /// are only recorded.
    pub(super) fn stops(&mut self, face: Face) -> Option<&mut Stops> {
        let Face::Three { event_mode: true, early_return } = face else { return None };
        let stops = self.stops.as_mut()?;
        stops.ends = early_return;
        Some(stops)
    }

    /// The values of `event_kind` and `event_position`.
    pub(super) fn last(&self) -> [f64; 2] {
        let position = self.last.position.map_or(0.0, |index| index as f64 + 1.0);
        [if self.last.blow { 1.0 } else { 2.0 * position.min(1.0) }, position]
    }

    /// Refuses numbers that are invalid for any scene.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let allowed = 0..=MAX_POSITIONS as i32;
        if allowed.contains(&self.positions) {
            return Ok(());
        }
        let (name, value) = (Extra::Positions.name(), f64::from(self.positions));
        Err(ParameterError { name, value, allowed: format!("0 to {MAX_POSITIONS}") })
    }
}

impl Instance {
    fn demand_mode(&self, call: &'static str, phase: Phase, mode: Mode) -> Result<(), CallError> {
        self.demand(call, &[phase])?;
        if self.events.mode == mode {
            return Ok(());
        }
        Err(self.out_of_order(call))
    }

    /// The error of a call that the present phase or mode forbids.
    pub(super) fn out_of_order(&self, call: &str) -> CallError {
        let phase = match (self.phase, self.events.mode) {
            (Phase::Instantiated, Mode::Configuration) => "in configuration mode",
            (Phase::Stepping, Mode::Event) => "in event mode",
            (phase, _) => phase.describe(),
        };
        CallError::Order { call: self.face.call(call), phase }
    }

    /// Refuses to enter initialization mode while the instance is in configuration mode.
    ///
    /// # Errors
    /// The instance is still in configuration mode.
    pub fn leave_configuration_first(&self) -> Result<(), CallError> {
        self.demand_mode("EnterInitializationMode", Phase::Instantiated, Mode::Plain)
    }

    /// Enters configuration mode, in which structural parameters can be set.
    ///
    /// # Errors
    /// The unit has no structural parameter, or initialization mode was entered before: structural parameters cannot
    /// change later.
    pub fn enter_configuration(&mut self) -> Result<(), CallError> {
        self.demand_mode("EnterConfigurationMode", Phase::Instantiated, Mode::Plain)?;
        if !self.variant.lists_arrays() {
            let text = "fmi3EnterConfigurationMode is not allowed: this unit lists no structural parameter";
            return Err(CallError::Argument(text.into()));
        }
        self.events.mode = Mode::Configuration;
        Ok(())
    }

    /// Leaves configuration mode.
    ///
    /// # Errors
    /// The instance is not in configuration mode.
    pub fn exit_configuration(&mut self) -> Result<(), CallError> {
        self.demand_mode("ExitConfigurationMode", Phase::Instantiated, Mode::Configuration)?;
        self.events.mode = Mode::Plain;
        Ok(())
    }

    /// Starts to monitor events when the scene is complete. The instance is then in event mode.
    pub(super) fn begin_events(&mut self) {
        if !self.face.handles_events() {
            return;
        }
        self.events.mode = Mode::Event;
        let Some(machine) = &self.machine else { return };
        let positions = &self.events.position[..self.events.positions.unsigned_abs() as usize];
        self.events.stops = Some(Stops::new(machine, self.events.blow, positions));
    }

    /// Enters event mode after a step.
    ///
    /// # Errors
    ///
    /// The instance is not in step mode, or the host did not announce event mode.
    pub fn enter_event_mode(&mut self) -> Result<(), CallError> {
        self.demand_mode("EnterEventMode", Phase::Stepping, Mode::Plain)?;
        if !self.face.handles_events() {
            let text = "fmi3EnterEventMode is not allowed: eventModeUsed was false";
            return Err(CallError::Argument(text.into()));
        }
        self.events.mode = Mode::Event;
        Ok(())
    }

    /// Returns to step mode.
    ///
    /// # Errors
    /// The instance is not in event mode.
    pub fn enter_step_mode(&mut self) -> Result<(), CallError> {
        self.demand_event_mode("EnterStepMode")?;
        self.events.mode = Mode::Plain;
        Ok(())
    }

    /// Refuses a call that is allowed only in event mode.
    ///
    /// # Errors
    /// The instance is not in event mode.
    pub fn demand_event_mode(&self, call: &'static str) -> Result<(), CallError> {
        self.demand_mode(call, Phase::Stepping, Mode::Event)
    }

    /// Makes a step as [`Instance::step`] does, but ends it at the next event if the host accepts early returns.
    /// Returns true if there was an event, and true if it ended the step early.
    ///
    /// # Errors
    /// Those of [`Instance::step`]; the instance is in event mode.
    pub fn step_to_event(&mut self, point: f64, size: f64) -> Result<[bool; 2], CallError> {
        if self.phase == Phase::Stepping {
            self.demand_mode("DoStep", Phase::Stepping, Mode::Plain)?;
        }
        let target = point + size;
        let stop = self.step(point, size)?;
        self.events.last = stop;
        Ok([stop.any(), stop != Stop::default() && self.time() < target])
    }
}
