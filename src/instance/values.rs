//! Reads and sets variables. Outputs are computed here, never in a step.

use super::events::Mode;
use super::{Instance, Phase, finite};
use crate::error::CallError;
use hammer::variables::{InputRow, Parameter, Role, Slot, VARIABLES, Variable};
use hammer::{Error, Input, MAX_INPUT_ORDER, Profile};

pub(super) const REAL: &str = "a real variable";
pub(super) const INTEGER: &str = "an integer or enumeration variable";
const BOOLEAN: &str = "a Boolean variable";

pub(super) fn row(reference: u32, wanted: &'static str) -> Result<&'static Variable, CallError> {
    usize::try_from(reference)
        .ok()
        .and_then(|position| VARIABLES.get(position))
        .ok_or(CallError::Reference { reference, wanted })
}

/// Turns -0 into 0, since a force of -0 N would look like tension.
fn unsigned_zero(value: f64) -> f64 {
    value + 0.0
}

impl Instance {
    /// The value of a real variable.
    ///
    /// # Errors
    /// There is no such variable; or the scene is not made yet, and its parameters are wrong.
    pub fn real(&mut self, reference: u32) -> Result<f64, CallError> {
        let Variable { name, role, .. } = row(reference, REAL)?;
        match role {
            Role::Parameter(Parameter { slot: Slot::Real(..), .. }) => {
                Ok(self.settings.get(reference as usize))
            }
            Role::Input(row) => Ok(self.input(row.input)),
            Role::Output(output) => {
                if let Some(prepare) = output.prepare {
                    let cancel = self.cancel.clone();
                    let machine = self.machine()?;
                    cancel.over(|| prepare(machine))?;
                }
                let value = unsigned_zero((output.value)(self.machine()?));
                if *name == "energy_residual" {
                    self.check_balance();
                }
                let struck = *name == "blow_time" && self.machine()?.blow().is_some();
                sound(name, if struck { self.on_clock(value) } else { value })
            }
            _ => Err(CallError::Reference { reference, wanted: REAL }),
        }
    }

    /// Motion and stress along the bars. Everything is computed at the first read of any part.
    pub fn profile(&mut self) -> Result<&Profile, CallError> {
        self.machine()?;
        let Some(machine) = &self.machine else { return Err(CallError::Failed) };
        Ok(self.waves.get_or_insert_with(|| machine.profile()))
    }

    pub(super) fn input(&self, input: Input) -> f64 {
        let running = self.machine.as_ref().filter(|_| self.origin.is_none());
        match (self.inputs.value(input), running) {
            (Some(value), _) => value,
            (None, Some(machine)) => machine.input(input),
            (None, None) => self.inputs.starting_value(input),
        }
    }

    /// The value of an integer variable, or of an enumeration, which counts from 1.
    ///
    /// # Errors
    /// Those of [`Instance::real`].
    pub fn integer(&mut self, reference: u32) -> Result<i32, CallError> {
        match &row(reference, INTEGER)?.role {
            Role::Parameter(Parameter { slot: Slot::Integer(_) | Slot::Choice(..), .. }) => {
                Ok(self.settings.get(reference as usize) as i32)
            }
            Role::Choice(_, index) => Ok(index(self.machine()?) as i32 + 1),
            _ => Err(CallError::Reference { reference, wanted: INTEGER }),
        }
    }

    /// The value of a Boolean variable.
    ///
    /// # Errors
    /// Those of [`Instance::real`].
    pub fn boolean(&mut self, reference: u32) -> Result<bool, CallError> {
        match &row(reference, BOOLEAN)?.role {
            Role::Truth(value) => Ok(value(self.machine()?)),
            _ => Err(CallError::Reference { reference, wanted: BOOLEAN }),
        }
    }

    /// A derivative of a real output: the first derivative of any output, the second if the engine knows it, and
    /// otherwise 0, as the standard demands (FMI 2.0, 4.2.2).
    ///
    /// # Errors
    ///
    /// The order is below 1, or the variable is not an output.
    pub fn output_derivative(&mut self, reference: u32, order: i32) -> Result<f64, CallError> {
        const WANTED: &str = "an output";
        if order < 1 {
            let text = format!("output derivatives have an order of at least 1, not {order}");
            return Err(CallError::Argument(text));
        }
        let Role::Output(output) = &row(reference, WANTED)?.role else {
            return Err(CallError::Reference { reference, wanted: WANTED });
        };
        let rate = match order {
            1 => Some(output.rate),
            2 => output.second,
            _ => None,
        };
        let name = row(reference, WANTED)?.name;
        rate.map_or(Ok(0.0), |rate| sound(name, unsigned_zero(rate(self.machine()?))))
    }

    /// Sets parameters and inputs: all or none.
    ///
    /// # Errors
    /// A variable does not exist or cannot be set now, or a value is not finite.
    pub fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        self.demand_settable("SetReal", references)?;
        for (reference, value) in references.iter().zip(values) {
            let variable = row(*reference, REAL)?;
            match &variable.role {
                Role::Parameter(row) if matches!(row.slot, Slot::Real(..)) => {
                    self.may_set(variable)?
                }
                Role::Input(_) => {}
                Role::Output(_) => return Err(read_only(variable.name)),
                _ => return Err(CallError::Reference { reference: *reference, wanted: REAL }),
            }
            match &variable.role {
                Role::Input(row) => check(row.input, 0, *value)?,
                _ => finite(variable.name, *value)?,
            }
            // While the simulation runs, the value is checked immediately, because no later call could refuse it.
            if self.phase == Phase::Stepping
                && let Role::Parameter(row) = &variable.role
            {
                row.check(*value)?;
            }
        }
        for (reference, value) in references.iter().zip(values) {
            match &row(*reference, REAL)?.role {
                Role::Input(row) => self.inputs.set_value(row.input, *value),
                _ => {
                    self.settings.set(*reference as usize, *value);
                    self.retune |= self.phase == Phase::Stepping;
                }
            }
        }
        Ok(())
    }

    /// Sets integer and enumeration parameters: all or none.
    ///
    /// # Errors
    /// A variable does not exist, or cannot be set now.
    pub fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Result<(), CallError> {
        self.demand_settable("SetInteger", references)?;
        for reference in references {
            let variable = row(*reference, INTEGER)?;
            match &variable.role {
                Role::Parameter(row) if !matches!(row.slot, Slot::Real(..)) => {
                    self.may_set(variable)?;
                }
                Role::Choice(..) => return Err(read_only(variable.name)),
                _ => return Err(CallError::Reference { reference: *reference, wanted: INTEGER }),
            }
        }
        for (reference, value) in references.iter().zip(values) {
            self.settings.set(*reference as usize, f64::from(*value));
        }
        Ok(())
    }

    /// Refuses to set Boolean variables, since none of them can be set.
    ///
    /// # Errors
    /// Always, unless the call is empty.
    pub fn set_booleans(&mut self, references: &[u32]) -> Result<(), CallError> {
        self.demand_settable("SetBoolean", references)?;
        let Some(reference) = references.first() else { return Ok(()) };
        let variable = row(*reference, BOOLEAN)?;
        match variable.role {
            Role::Truth(_) => Err(read_only(variable.name)),
            _ => Err(CallError::Reference { reference: *reference, wanted: BOOLEAN }),
        }
    }

    /// Sets derivatives of inputs at the present time, with orders from 1: all or none.
    ///
    /// # Errors
    /// A variable is not an input, a value is not finite, or an order is not supported.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), CallError> {
        const WANTED: &str = "an input";
        self.demand_settable("SetRealInputDerivatives", references)?;
        let mut set = Vec::with_capacity(references.len());
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let variable = row(*reference, WANTED)?;
            let Role::Input(InputRow { input, .. }) = &variable.role else {
                return Err(CallError::Reference { reference: *reference, wanted: WANTED });
            };
            match usize::try_from(*order) {
                Ok(order) if (1..=MAX_INPUT_ORDER).contains(&order) => {
                    check(*input, order, *value)?;
                    set.push((*input, order, *value));
                }
                _ => {
                    return Err(CallError::Argument(format!(
                        "derivatives of {} have order 1 to {MAX_INPUT_ORDER}, not {order}",
                        variable.name
                    )));
                }
            }
        }
        for (input, order, value) in set {
            self.inputs.set_derivative(input, order, value);
        }
        Ok(())
    }

    /// Refuses to set variables in phases and modes that forbid it. An empty call is allowed in any phase, because
    /// hosts make it.
    pub(super) fn demand_settable(
        &self,
        call: &'static str,
        references: &[u32],
    ) -> Result<(), CallError> {
        if references.is_empty() {
            return Ok(());
        }
        self.demand(call, &[Phase::Instantiated, Phase::Initialization, Phase::Stepping])?;
        // Only structural parameters may be set in configuration mode, by another call.
        if self.events.mode == Mode::Configuration { Err(self.out_of_order(call)) } else { Ok(()) }
    }

    pub(super) fn may_set(&self, parameter: &Variable) -> Result<(), CallError> {
        match parameter.role {
            Role::Parameter(row) if !row.tunable && self.phase == Phase::Stepping => {
                let reason = "it is fixed after initialization";
                Err(CallError::ReadOnly { name: parameter.name, reason })
            }
            _ => Ok(()),
        }
    }
}

/// The value, or an error if it is not finite.
pub(super) fn sound(name: &'static str, value: f64) -> Result<f64, CallError> {
    if value.is_finite() { Ok(value) } else { Err(CallError::Overflowed { name }) }
}

/// Refuses a value of an input (order 0) or one of its derivatives by the engine's own rule.
pub(super) fn check(input: Input, order: usize, value: f64) -> Result<(), CallError> {
    finite(input.name(), value)?;
    let refusal = |error| Error::Input { name: input.name(), error }.into();
    input.check(order, value).map_err(refusal)
}

pub(super) fn read_only(name: &'static str) -> CallError {
    CallError::ReadOnly { name, reason: "it is a result" }
}
