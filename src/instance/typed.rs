//! Reads and sets variables by the types of FMI 3.0, including those that FMI 2.0 does not have.

use super::events::Mode;
use super::values::{INTEGER, REAL, check, read_only, row, sound};
use super::{Instance, Phase, finite};
use crate::error::CallError;
use crate::events::{Extra, Length, MAX_LENGTH};
use hammer::variables::{ALONG, InputRow, OF_BLOW, Parameter, Role, Slot};
use hammer::{Input, ParameterError};

const BOOLEAN: &str = "a Boolean variable";
const UNSIGNED: &str = "a UInt64 variable";
const ENUMERATION: &str = "an enumeration variable";

impl Instance {
    /// Appends the values of a real variable.
    ///
    /// # Errors
    /// There is no such variable; or the scene is not made yet, and its parameters are wrong.
    pub fn float64s(&mut self, reference: u32, values: &mut Vec<f64>) -> Result<(), CallError> {
        let value = match Extra::of(reference) {
            Some(Extra::Time) => self.time(),
            Some(Extra::Position(index)) => self.events.position[index],
            Some(Extra::Slope(input)) => self.events.slopes[input as usize],
            Some(Extra::Along(family)) => return self.along(family, values),
            Some(Extra::EventKind) => self.events.last()[0],
            Some(Extra::EventPosition) => self.events.last()[1],
            Some(Extra::BlowCount) => self.machine()?.step_blows().len() as f64,
            Some(Extra::OfBlow(figure)) => return self.of_blows(figure, values),
            Some(_) => return Err(CallError::Reference { reference, wanted: REAL }),
            None => {
                row(reference, REAL)?;
                self.real(reference)?
            }
        };
        values.push(value);
        Ok(())
    }

    /// Number of values of a variable: the length of an array, otherwise 1.
    pub fn count(&self, reference: u32) -> usize {
        match Extra::of(reference) {
            Some(Extra::Along(_)) => self.length(Length::Stations),
            Some(Extra::OfBlow(_)) => self.length(Length::Blows),
            _ => 1,
        }
    }

    fn length(&self, length: Length) -> usize {
        self.events.lengths[length as usize] as usize
    }

    /// Appends stress or velocity at the stations. A rigid body has no stress, and the same velocity at all stations.
    fn along(&mut self, family: usize, values: &mut Vec<f64>) -> Result<(), CallError> {
        let (stations, family) = (self.length(Length::Stations), &ALONG[family]);
        let elements = self.machine()?.parameters().spans(family.body);
        let profile = self.profile()?;
        let value_at = |station: usize| {
            let element = (2 * station + 1) * elements / (2 * stations);
            // A rigid body has a single node.
            let end = |node| family.value(profile, node).or_else(|| family.value(profile, 0));
            let ends = [element, element + usize::from(family.nodal)].map(end);
            let value = f64::midpoint(ends[0].unwrap_or_default(), ends[1].unwrap_or_default());
            sound(family.name, value)
        };
        for station in 0..stations {
            values.push(value_at(station)?);
        }
        Ok(())
    }

    /// Appends a figure of the last step's blows in their order. If the array is too short, it has the last of them.
    fn of_blows(&mut self, figure: usize, values: &mut Vec<f64>) -> Result<(), CallError> {
        let (length, before) = (self.length(Length::Blows), values.len());
        let blows = self.machine()?.step_blows();
        let last = blows.iter().skip(blows.len().saturating_sub(length));
        values.extend(last.map(OF_BLOW[figure].value));
        if OF_BLOW[figure].is_instant() {
            values[before..].iter_mut().for_each(|time| *time = self.on_clock(*time));
        }
        values.resize(before + length, 0.0);
        Ok(())
    }

    /// Sets parameters, inputs and slopes of inputs: all or none.
    ///
    /// # Errors
    /// A variable does not exist or cannot be set now, or a value is not finite.
    pub fn set_float64s(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        self.demand_settable("SetReal", references)?;
        for (reference, value) in references.iter().zip(values) {
            match Extra::of(*reference) {
                Some(extra @ Extra::Position(_)) => {
                    self.demand_fixed(extra)?;
                    finite(extra.name(), *value)?;
                }
                Some(Extra::Slope(input)) => check(input, 1, *value)?,
                Some(extra) if extra == Extra::Time || extra.is_output() => {
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
        let (common, extra): (Vec<_>, Vec<_>) =
            references.iter().zip(values).partition(|(r, _)| Extra::of(**r).is_none());
        let (common, numbers): (Vec<u32>, Vec<f64>) = common.into_iter().unzip();
        self.set_reals(&common, &numbers)?;
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
        for reference in common {
            if let Role::Input(InputRow { input, .. }) = &row(reference, REAL)?.role {
                self.incline(*input);
            }
        }
        Ok(())
    }

    /// Makes an input a straight line with its present value and slope.
    fn incline(&mut self, input: Input) {
        let (value, slope) = (self.input(input), self.events.slopes[input as usize]);
        self.inputs.set_value(input, value);
        self.inputs.set_derivative(input, 1, slope);
    }

    /// Refuses to set a fixed parameter after initialization.
    fn demand_fixed(&self, extra: Extra) -> Result<(), CallError> {
        let is_settable = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let reason = "it is fixed after initialization";
        if is_settable { Ok(()) } else { Err(CallError::ReadOnly { name: extra.name(), reason }) }
    }

    /// Appends the value of an integer variable.
    ///
    /// # Errors
    /// Those of [`Instance::float64s`].
    pub fn int32(&mut self, reference: u32, values: &mut Vec<i32>) -> Result<(), CallError> {
        values.push(match Extra::of(reference) {
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
    /// Those of [`Instance::set_float64s`].
    pub fn set_int32s(&mut self, references: &[u32], values: &[i32]) -> Result<(), CallError> {
        self.demand_settable("SetInteger", references)?;
        let (mut common, mut numbers, mut positions) = (Vec::new(), Vec::new(), None);
        for (reference, value) in references.iter().zip(values) {
            if Extra::of(*reference) == Some(Extra::Positions) {
                self.demand_fixed(Extra::Positions)?;
                positions = Some(*value);
            } else if is_choice(*reference) {
                return Err(CallError::Reference { reference: *reference, wanted: INTEGER });
            } else {
                common.push(*reference);
                numbers.push(*value);
            }
        }
        self.set_integers(&common, &numbers)?;
        self.events.positions = positions.unwrap_or(self.events.positions);
        Ok(())
    }

    /// Appends the value of an enumeration, which counts from 1.
    ///
    /// # Errors
    /// Those of [`Instance::float64s`].
    pub fn int64(&mut self, reference: u32, values: &mut Vec<i64>) -> Result<(), CallError> {
        if !is_choice(reference) {
            return Err(CallError::Reference { reference, wanted: ENUMERATION });
        }
        values.push(self.integer(reference)?.into());
        Ok(())
    }

    /// Sets enumeration parameters: all or none.
    ///
    /// # Errors
    /// Those of [`Instance::set_float64s`].
    pub fn set_int64s(&mut self, references: &[u32], values: &[i64]) -> Result<(), CallError> {
        if let Some(reference) = references.iter().copied().find(|r| !is_choice(*r)) {
            return Err(CallError::Reference { reference, wanted: ENUMERATION });
        }
        // A number that is too large becomes one that is no item either.
        let number = |value: &i64| i32::try_from(*value).unwrap_or(i32::MAX);
        self.set_integers(references, &values.iter().map(number).collect::<Vec<_>>())
    }

    /// Appends a length of arrays.
    ///
    /// # Errors
    /// Those of [`Instance::float64s`].
    pub fn uint64(&mut self, reference: u32, values: &mut Vec<u64>) -> Result<(), CallError> {
        values.push(self.events.lengths[length_of(reference)? as usize]);
        Ok(())
    }

    /// Sets lengths of arrays: all or none.
    ///
    /// # Errors
    /// The instance is not in configuration mode, or a number is not allowed.
    pub fn set_uint64s(&mut self, references: &[u32], values: &[u64]) -> Result<(), CallError> {
        let mut lengths = self.events.lengths;
        for (reference, value) in references.iter().zip(values) {
            let length = length_of(*reference)?;
            let name = length.name();
            if self.events.mode != Mode::Configuration {
                let reason = "it is structural, and set in configuration mode alone";
                return Err(CallError::ReadOnly { name, reason });
            }
            if !(1..=MAX_LENGTH).contains(value) {
                let (value, allowed) = (*value as f64, format!("1 to {MAX_LENGTH}"));
                return Err(ParameterError { name, value, allowed }.into());
            }
            lengths[length as usize] = *value;
        }
        self.events.lengths = lengths;
        Ok(())
    }

    /// Appends the value of a Boolean variable.
    ///
    /// # Errors
    /// Those of [`Instance::float64s`].
    pub fn truth(&mut self, reference: u32, values: &mut Vec<u8>) -> Result<(), CallError> {
        values.push(match Extra::of(reference) {
            Some(Extra::EventBlow) => self.events.blow.into(),
            _ => self.boolean(reference)?.into(),
        });
        Ok(())
    }

    /// Sets Boolean parameters: all or none.
    ///
    /// # Errors
    /// Those of [`Instance::set_float64s`].
    pub fn set_truths(&mut self, references: &[u32], values: &[u8]) -> Result<(), CallError> {
        self.demand_settable("SetBoolean", references)?;
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
}

fn length_of(reference: u32) -> Result<Length, CallError> {
    match Extra::of(reference) {
        Some(Extra::Length(length)) => Ok(length),
        _ => Err(CallError::Reference { reference, wanted: UNSIGNED }),
    }
}

/// True for an enumeration, which FMI 3.0 reads as Int64.
fn is_choice(reference: u32) -> bool {
    let role = row(reference, ENUMERATION).map(|variable| &variable.role);
    matches!(role, Ok(Role::Choice(..) | Role::Parameter(Parameter { slot: Slot::Choice(..), .. })))
}
