//! The inputs that the host sets. They are collected until the engine needs them.
//!
//! A host may set a value and its derivatives in any order. Therefore the last value and the last derivatives of a
//! communication point go to the engine together.

use crate::error::CallError;
use hammer::{Input, InputValues, MAX_INPUT_ORDER, Machine};
use serde::{Deserialize, Serialize};

/// Value and derivatives of an input that were set since the last communication step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Fresh {
    value: Option<f64>,
    derivatives: [f64; MAX_INPUT_ORDER],
    order: usize,
}

/// The inputs that were set since the last communication step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Start values of the model description.
    start: InputValues,
    /// For each input, true if it was ever set to another value or given a derivative.
    set: [bool; Input::ALL.len()],
    fresh: [Fresh; Input::ALL.len()],
    dirty: bool,
    /// True if `fresh` is known to have nothing.
    #[serde(skip)]
    passed: bool,
}

impl Inputs {
    /// Inputs with the start values of the model description.
    pub fn new(start: InputValues) -> Self {
        let [mut values, mut defaults] = [start, InputValues::default()];
        let set = Input::ALL.map(|input| *slot(&mut values, input) != *slot(&mut defaults, input));
        Self { start, set, fresh: Default::default(), dirty: false, passed: true }
    }

    /// True if calls of a host can have led to this state. This is checked because a stored state may be corrupt.
    pub fn is_sound(&self) -> bool {
        let is_valid = |input: &Input| {
            let Fresh { value, derivatives, order } = self.fresh[*input as usize];
            let start = *slot(&mut self.start.clone(), *input);
            let rates = (1..).zip(derivatives).all(|(k, rate)| input.check(k, rate).is_ok());
            let values = [Some(start), value].into_iter().flatten();
            rates && order <= MAX_INPUT_ORDER && { values }.all(|v| input.check(0, v).is_ok())
        };
        Input::ALL.iter().all(is_valid)
    }

    /// True if anything was set that the engine does not have yet.
    pub fn wait(&self) -> bool {
        self.dirty
    }

    /// True if a derivative was set, or a value other than the start value.
    pub fn sets(&self, input: Input) -> bool {
        self.set[input as usize]
    }

    /// The value that was set since the last communication step, if one was.
    pub fn value(&self, input: Input) -> Option<f64> {
        self.fresh[input as usize].value
    }

    /// Sets a value, which is constant unless derivatives are set too.
    pub fn set_value(&mut self, input: Input, value: f64) {
        self.fresh[input as usize].value = Some(value);
        self.set[input as usize] |= value != *slot(&mut self.start.clone(), input);
        self.reapply();
    }

    /// Sets the derivative of an `order` from 1 to [`MAX_INPUT_ORDER`] at the present time.
    pub fn set_derivative(&mut self, input: Input, order: usize, value: f64) {
        let fresh = &mut self.fresh[input as usize];
        if let Some(slot) = order.checked_sub(1).and_then(|i| fresh.derivatives.get_mut(i)) {
            *slot = value;
            fresh.order = fresh.order.max(order);
            self.set[input as usize] |= value != 0.0;
            self.reapply();
        }
    }

    /// The values at the start, for which the engine finds its equilibrium.
    pub fn starting(&self) -> InputValues {
        let mut values = self.start;
        for input in Input::ALL {
            if let Some(value) = self.value(input) {
                *slot(&mut values, input) = value;
            }
        }
        values
    }

    /// One value of [`Inputs::starting`].
    pub fn starting_value(&self, input: Input) -> f64 {
        *slot(&mut self.starting(), input)
    }

    /// Passes everything that was set to the engine, if there is anything.
    ///
    /// # Errors
    ///
    /// The engine refuses the polynomial of an input.
    pub fn apply(&mut self, machine: &mut Machine) -> Result<(), CallError> {
        if !self.dirty {
            return Ok(());
        }
        for input in Input::ALL {
            let Fresh { value, derivatives, order } = self.fresh[input as usize];
            if value.is_none() && order == 0 {
                continue;
            }
            let mut polynomial = [0.0; MAX_INPUT_ORDER + 1];
            polynomial[0] = value.unwrap_or_else(|| machine.input(input));
            polynomial[1..].copy_from_slice(&derivatives);
            machine.set_input(input, &polynomial[..=order])?;
        }
        self.dirty = false;
        Ok(())
    }

    /// Marks everything that was set, so that it is passed again to an engine that was created anew.
    pub fn reapply(&mut self) {
        (self.dirty, self.passed) = (true, false);
    }

    /// Forgets values that were set for a communication point that has passed. The engine continues its polynomials.
    pub fn pass(&mut self) {
        if !self.passed {
            (self.fresh, self.dirty, self.passed) = (Default::default(), false, true);
        }
    }
}

fn slot(values: &mut InputValues, input: Input) -> &mut f64 {
    (input.row().start)(values)
}
