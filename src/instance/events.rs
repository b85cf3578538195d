//! What FMI 3.0 adds: its modes, events, clocks, and variables that FMI 2.0 has no word for.

use super::values::{INTEGER, REAL, read_only, row};
use super::{Instance, Phase, finite};
use crate::error::CallError;
use crate::events::{Clock, Extra, MAX_POSITIONS, MAX_STATIONS, STATIONS};
use crate::waves::FAMILIES;
use hammer::variables::{Role, Slot};
use hammer::{Body, Input, ParameterError, Stop, Stops};
use serde::{Deserialize, Serialize};

const BOOLEAN: &str = "a Boolean variable";
const UNSIGNED: &str = "a UInt64 variable";
const ENUMERATION: &str = "an enumeration variable";

/// By which standard the host calls, and what it has agreed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three {
        /// The host handles events.
        event_mode: bool,
        /// Steps may end before their time.
        early_return: bool,
    },
}

impl Face {
    /// The name of a call in this standard.
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

/// Modes of FMI 3.0 within a [`Phase`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Mode {
    /// The phase says all.
    #[default]
    Plain,
    /// Before initialization: structural parameters may be set.
    Configuration,
    /// Between steps: events are handled.
    Event,
}

/// The state of what this file is about.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Events {
    mode: Mode,
    blow: bool,
    positions: i32,
    position: [f64; MAX_POSITIONS],
    stations: u64,
    slopes: [f64; Input::ALL.len()],
    stops: Option<Stops>,
    ticks: [bool; Clock::ALL.len()],
}

impl Default for Events {
    fn default() -> Self {
        Self {
            mode: Mode::Plain,
            blow: true,
            positions: 0,
            position: [0.0; MAX_POSITIONS],
            stations: STATIONS,
            slopes: [0.0; Input::ALL.len()],
            stops: None,
            ticks: [false; Clock::ALL.len()],
        }
    }
}

impl Events {
    /// As they stand, for a host that may not handle events.
    pub(super) fn of_state(&self, face: Face) -> Self {
        let mut events = self.clone();
        if events.mode == Mode::Event && !face.handles_events() {
            events.mode = Mode::Plain;
        }
        events
    }

    /// Where steps end, if the host has agreed to both.
    pub(super) fn stops(&mut self, face: Face) -> Option<&mut Stops> {
        let agreed = Face::Three { event_mode: true, early_return: true };
        self.stops.as_mut().filter(|_| face == agreed)
    }

    /// Refuses numbers that no scene can have.
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
        let phase = match self.events.mode {
            Mode::Plain => self.phase.describe(),
            Mode::Configuration => "in configuration mode",
            Mode::Event => "in event mode",
        };
        Err(CallError::Order { call: self.face.call(call), phase })
    }

    /// Refuses to enter initialization mode out of configuration mode.
    ///
    /// # Errors
    /// If that mode was not left.
    pub fn leave_configuration_first(&self) -> Result<(), CallError> {
        self.demand_mode("EnterInitializationMode", Phase::Instantiated, Mode::Plain)
    }

    /// Lets structural parameters be set.
    ///
    /// # Errors
    /// After initialization mode was entered: none of them is tunable.
    pub fn enter_configuration(&mut self) -> Result<(), CallError> {
        self.demand_mode("EnterConfigurationMode", Phase::Instantiated, Mode::Plain)?;
        self.events.mode = Mode::Configuration;
        Ok(())
    }

    /// Ends that.
    ///
    /// # Errors
    /// Out of configuration mode.
    pub fn exit_configuration(&mut self) -> Result<(), CallError> {
        self.demand_mode("ExitConfigurationMode", Phase::Instantiated, Mode::Configuration)?;
        self.events.mode = Mode::Plain;
        Ok(())
    }

    /// The scene is made: events are looked out for, and the first mode is that of events.
    pub(super) fn begin_events(&mut self) {
        if !self.face.handles_events() {
            return;
        }
        self.events.mode = Mode::Event;
        let Some(machine) = &self.machine else { return };
        let positions = &self.events.position[..self.events.positions.unsigned_abs() as usize];
        self.events.stops = Some(Stops::new(machine, self.events.blow, positions));
    }

    /// Opens event mode after a step.
    ///
    /// # Errors
    /// Not while stepping; a host that has not announced to use it.
    pub fn enter_event_mode(&mut self) -> Result<(), CallError> {
        self.demand_mode("EnterEventMode", Phase::Stepping, Mode::Plain)?;
        if !self.face.handles_events() {
            let text = "fmi3EnterEventMode is not allowed: eventModeUsed was false";
            return Err(CallError::Argument(text.into()));
        }
        self.events.mode = Mode::Event;
        Ok(())
    }

    /// Goes on to the next step.
    ///
    /// # Errors
    /// Out of event mode.
    pub fn enter_step_mode(&mut self) -> Result<(), CallError> {
        self.demand_event_mode("EnterStepMode")?;
        self.events.mode = Mode::Plain;
        self.events.ticks = Default::default();
        Ok(())
    }

    /// Refuses a call out of event mode.
    ///
    /// # Errors
    /// Out of event mode.
    pub fn demand_event_mode(&self, call: &'static str) -> Result<(), CallError> {
        self.demand_mode(call, Phase::Stepping, Mode::Event)
    }

    /// Ends the instant of a tick: what an event changes has changed already.
    ///
    /// # Errors
    /// Out of event mode.
    pub fn update_discrete_states(&mut self) -> Result<(), CallError> {
        self.demand_event_mode("UpdateDiscreteStates")?;
        self.events.ticks = Default::default();
        Ok(())
    }

    /// Whether a clock ticks now.
    ///
    /// # Errors
    /// Out of event mode.
    pub fn ticks(&self, clock: Clock) -> Result<bool, CallError> {
        self.demand_event_mode("GetClock")?;
        Ok(self.events.ticks[clock as usize])
    }

    /// [`Instance::step`], to the next event if that comes first: whether there is one, and
    /// whether it was before the end of the step.
    ///
    /// # Errors
    /// As [`Instance::step`]; in event mode.
    pub fn step_to_event(&mut self, point: f64, size: f64) -> Result<[bool; 2], CallError> {
        if self.phase == Phase::Stepping {
            self.demand_mode("DoStep", Phase::Stepping, Mode::Plain)?;
        }
        let target = point + size;
        let stop = self.step(point, size)?;
        self.events.ticks = [stop.blow, stop.position];
        Ok([stop.any(), stop != Stop::default() && self.time() < target])
    }

    /// The values of a real variable, one behind the other.
    ///
    /// # Errors
    /// No such variable, or wrong parameters while the scene is not yet made.
    pub fn float64s(&mut self, reference: u32, found: &mut Vec<f64>) -> Result<(), CallError> {
        let value = match Extra::of(reference) {
            Some(Extra::Time) => self.time(),
            Some(Extra::Position(index)) => self.events.position[index],
            Some(Extra::Slope(input)) => self.events.slopes[input as usize],
            Some(Extra::Array(family)) => return self.array(family, found),
            Some(_) => return Err(CallError::Reference { reference, wanted: REAL }),
            None => {
                row(reference, REAL)?;
                self.real(reference)?
            }
        };
        found.push(value);
        Ok(())
    }

    /// A family of waves at the stations; a rigid body is without stress, and moves as one.
    fn array(&mut self, family: usize, found: &mut Vec<f64>) -> Result<(), CallError> {
        let stations = self.events.stations as usize;
        let profile = self.machine()?.profile();
        let (stress, nodes) = match FAMILIES[family].body {
            Body::Piston => (&profile.piston_stress, &profile.piston),
            Body::Bit => (&profile.bit_stress, &profile.bit),
        };
        let elements = nodes.len().saturating_sub(1).max(1);
        let at = |station: usize| {
            let element = (2 * station + 1) * elements / (2 * stations);
            if FAMILIES[family].nodal {
                let end = |node: usize| nodes.get(node).or(nodes.last()).map_or(0.0, |[_, v]| *v);
                f64::midpoint(end(element), end(element + 1))
            } else {
                stress.get(element).copied().unwrap_or_default()
            }
        };
        found.extend((0..stations).map(at));
        Ok(())
    }

    /// Sets parameters, inputs and slopes of inputs: all or none.
    ///
    /// # Errors
    /// The first that does not exist, is not finite, or cannot be set now.
    pub fn set_float64s(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        for (reference, value) in references.iter().zip(values) {
            match Extra::of(*reference) {
                Some(extra @ Extra::Position(_)) => {
                    self.demand_fixed(extra)?;
                    finite(extra.name(), *value)?;
                }
                Some(extra @ Extra::Slope(_)) => {
                    self.demand_settable("SetReal", references)?;
                    finite(extra.name(), *value)?;
                }
                Some(extra @ (Extra::Time | Extra::Array(_))) => {
                    return Err(read_only(extra.name()));
                }
                Some(_) => {
                    return Err(CallError::Reference { reference: *reference, wanted: REAL });
                }
                None => {
                    row(*reference, REAL)?;
                }
            }
        }
        let (plain, extra): (Vec<_>, Vec<_>) =
            references.iter().zip(values).partition(|(r, _)| Extra::of(**r).is_none());
        let (names, numbers): (Vec<u32>, Vec<f64>) = plain.into_iter().unzip();
        self.set_reals(&names, &numbers)?;
        for (reference, value) in extra {
            match Extra::of(*reference) {
                Some(Extra::Position(index)) => self.events.position[index] = *value,
                Some(Extra::Slope(input)) => {
                    self.events.slopes[input as usize] = *value;
                    self.incline(input);
                }
                _ => {}
            }
        }
        for reference in names {
            if let Role::Input { input, .. } = &row(reference, REAL)?.role {
                self.incline(*input);
            }
        }
        Ok(())
    }

    /// Makes an input the straight line of its value now and its slope.
    fn incline(&mut self, input: Input) {
        let (value, slope) = (self.input(input), self.events.slopes[input as usize]);
        self.inputs.set_value(input, value);
        self.inputs.set_derivative(input, 1, slope);
    }

    fn demand_fixed(&self, extra: Extra) -> Result<(), CallError> {
        let open = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let reason = "it is fixed after initialization";
        if open { Ok(()) } else { Err(CallError::ReadOnly { name: extra.name(), reason }) }
    }

    /// An integer variable.
    ///
    /// # Errors
    /// As [`Instance::float64s`].
    pub fn int32(&mut self, reference: u32, found: &mut Vec<i32>) -> Result<(), CallError> {
        found.push(match Extra::of(reference) {
            Some(Extra::Positions) => self.events.positions,
            _ if is_choice(reference) => {
                return Err(CallError::Reference { reference, wanted: INTEGER });
            }
            _ => self.integer(reference)?,
        });
        Ok(())
    }

    /// Sets integer parameters: all or none.
    ///
    /// # Errors
    /// As [`Instance::set_float64s`].
    pub fn set_int32s(&mut self, references: &[u32], values: &[i32]) -> Result<(), CallError> {
        let (mut names, mut numbers, mut positions) = (Vec::new(), Vec::new(), None);
        for (reference, value) in references.iter().zip(values) {
            if Extra::of(*reference) == Some(Extra::Positions) {
                self.demand_fixed(Extra::Positions)?;
                positions = Some(*value);
            } else if is_choice(*reference) {
                return Err(CallError::Reference { reference: *reference, wanted: INTEGER });
            } else {
                names.push(*reference);
                numbers.push(*value);
            }
        }
        self.set_integers(&names, &numbers)?;
        self.events.positions = positions.unwrap_or(self.events.positions);
        Ok(())
    }

    /// An enumeration's value, from 1.
    ///
    /// # Errors
    /// As [`Instance::float64s`].
    pub fn int64(&mut self, reference: u32, found: &mut Vec<i64>) -> Result<(), CallError> {
        if !is_choice(reference) {
            return Err(CallError::Reference { reference, wanted: ENUMERATION });
        }
        found.push(self.integer(reference)?.into());
        Ok(())
    }

    /// Sets enumeration parameters: all or none.
    ///
    /// # Errors
    /// As [`Instance::set_float64s`].
    pub fn set_int64s(&mut self, references: &[u32], values: &[i64]) -> Result<(), CallError> {
        if let Some(reference) = references.iter().copied().find(|r| !is_choice(*r)) {
            return Err(CallError::Reference { reference, wanted: ENUMERATION });
        }
        // What has no such number is none of the items, whichever.
        let number = |value: &i64| i32::try_from(*value).unwrap_or(i32::MAX);
        self.set_integers(references, &values.iter().map(number).collect::<Vec<_>>())
    }

    /// The number of stations.
    ///
    /// # Errors
    /// As [`Instance::float64s`].
    pub fn uint64(&mut self, reference: u32, found: &mut Vec<u64>) -> Result<(), CallError> {
        if Extra::of(reference) != Some(Extra::Stations) {
            return Err(CallError::Reference { reference, wanted: UNSIGNED });
        }
        found.push(self.events.stations);
        Ok(())
    }

    /// Sets the number of stations.
    ///
    /// # Errors
    /// Out of configuration mode; a number that is not allowed.
    pub fn set_uint64s(&mut self, references: &[u32], values: &[u64]) -> Result<(), CallError> {
        let name = Extra::Stations.name();
        for (reference, value) in references.iter().zip(values) {
            if Extra::of(*reference) != Some(Extra::Stations) {
                return Err(CallError::Reference { reference: *reference, wanted: UNSIGNED });
            }
            if self.events.mode != Mode::Configuration {
                let reason = "it is structural, and set in configuration mode alone";
                return Err(CallError::ReadOnly { name, reason });
            }
            if !(1..=MAX_STATIONS).contains(value) {
                let (value, allowed) = (*value as f64, format!("1 to {MAX_STATIONS}"));
                return Err(ParameterError { name, value, allowed }.into());
            }
        }
        self.events.stations = values.last().copied().unwrap_or(self.events.stations);
        Ok(())
    }

    /// A Boolean variable.
    ///
    /// # Errors
    /// As [`Instance::float64s`].
    pub fn truth(&mut self, reference: u32, found: &mut Vec<u8>) -> Result<(), CallError> {
        found.push(match Extra::of(reference) {
            Some(Extra::EventBlow) => self.events.blow.into(),
            _ => self.boolean(reference)?.into(),
        });
        Ok(())
    }

    /// Sets Boolean parameters: all or none.
    ///
    /// # Errors
    /// As [`Instance::set_float64s`].
    pub fn set_truths(&mut self, references: &[u32], values: &[u8]) -> Result<(), CallError> {
        for reference in references {
            match Extra::of(*reference) {
                Some(Extra::EventBlow) => self.demand_fixed(Extra::EventBlow)?,
                Some(_) => {
                    return Err(CallError::Reference { reference: *reference, wanted: BOOLEAN });
                }
                None => self.set_booleans(&[*reference])?,
            }
        }
        self.events.blow = values.last().map_or(self.events.blow, |value| *value != 0);
        Ok(())
    }

    /// `sum_k seed_k d unknown_k / d known`, for each known.
    ///
    /// # Errors
    /// As [`Instance::directional`].
    pub fn adjoint(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, CallError> {
        for value in seed {
            finite("seed", *value)?;
        }
        let column = |known: &u32| {
            let column = self.directional(unknowns, &[*known], &[1.0])?;
            // What is not asked for may be infinite.
            let terms = column.iter().zip(seed).filter(|(_, seed)| **seed != 0.0);
            Ok(terms.map(|(derivative, seed)| derivative * seed).sum())
        };
        knowns.iter().map(column).collect()
    }
}

/// True for an enumeration, which FMI 3.0 reads as Int64.
fn is_choice(reference: u32) -> bool {
    let Ok(variable) = row(reference, ENUMERATION) else { return false };
    let of_slot = |slot: &Slot| matches!(slot, Slot::Choice(..));
    match &variable.role {
        Role::Parameter { slot, .. } => of_slot(slot),
        Role::Choice(..) => true,
        _ => false,
    }
}
