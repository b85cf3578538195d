//! Directional derivatives of outputs by inputs.

use super::{Instance, Phase, finite};
use crate::error::CallError;
use hammer::sensitivity::{Argument, Derivative, Sample, Scene, derivatives, over_step};
use hammer::variables::{Role, VARIABLES};
use hammer::{Input, Machine};

impl Instance {
    /// `sum_k d unknown / d known_k direction_k`, by a constant added to an input over the last
    /// communication step, or, before initialization is complete, to its start value.
    ///
    /// # Errors
    ///
    /// Unknowns that are not outputs, knowns that are not inputs.
    pub fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
    ) -> Result<Vec<f64>, CallError> {
        use Phase::{Initialization, Instantiated, Stepping, Terminated};
        self.demand(
            "GetDirectionalDerivative",
            &[Instantiated, Initialization, Stepping, Terminated],
        )?;
        for value in direction {
            finite("dvKnown", *value)?;
        }
        let outputs = unknowns.iter().map(|r| output(*r)).collect::<Result<Vec<_>, _>>()?;
        let inputs = knowns.iter().map(|r| input(*r)).collect::<Result<Vec<_>, _>>()?;
        let cancel = self.cancel.clone();
        let rows = cancel.over(|| self.rows(&outputs, &inputs))?;
        for text in rows.iter().zip(&inputs).filter_map(|(row, input)| {
            let why = row.nonsmooth.first()?;
            Some(format!("derivatives by {} hold on one side at most: {why}", input.name()))
        }) {
            self.warn([text]);
        }
        let sum = |k: usize| rows.iter().zip(direction).map(|(row, d)| row.values[k] * d).sum();
        Ok((0..unknowns.len()).map(sum).collect())
    }

    /// Derivatives of outputs, one row per input.
    fn rows(
        &mut self,
        outputs: &[fn(&mut Machine) -> f64],
        inputs: &[Input],
    ) -> Result<Vec<Derivative>, CallError> {
        let read = |machine: &mut Machine| outputs.iter().map(|read| read(machine)).collect();
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            let scene =
                Scene { parameters: self.settings.parameters()?, inputs: self.inputs.starting() };
            let by = inputs.iter().filter_map(|input| Argument::named(input.name()));
            let run = |scene: &Scene| Sample::of_run(&mut scene.machine()?, &[0.0], &read);
            Ok(derivatives(&scene, &by.collect::<Vec<_>>(), &run)?)
        } else {
            let at_start = self.step_start.clone();
            let machine = self.machine()?;
            let present = machine.state();
            let start = match at_start {
                Some((time, None)) => present.looked_at(time),
                Some((_, Some(state))) => *state,
                None => present,
            };
            Ok(over_step(machine, &start, inputs, &read)?)
        }
    }
}

fn output(reference: u32) -> Result<fn(&mut Machine) -> f64, CallError> {
    match VARIABLES.get(reference as usize).map(|variable| &variable.role) {
        Some(Role::Output(output)) => Ok(output.value),
        _ => Err(CallError::Reference { reference, wanted: "an output" }),
    }
}

fn input(reference: u32) -> Result<Input, CallError> {
    match VARIABLES.get(reference as usize).map(|variable| &variable.role) {
        Some(Role::Input { input, .. }) => Ok(*input),
        _ => Err(CallError::Reference { reference, wanted: "an input" }),
    }
}
