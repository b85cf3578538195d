//! Directional and adjoint derivatives.
//!
//! They are those of the standard: derivatives of a present output with respect to a present known. In initialization
//! mode the scene itself depends on the knowns. Afterwards the state is given, and an output depends on an input only
//! if the `dependencies` in the model description say so.
//!
//! The derivative of an output at the end of the last communication step with respect to an input during that step is
//! another number. The value reference of its unknown is that of the output plus [`OVER_STEP`].

use super::events::Face;
use super::inputs::Inputs;
use super::settings::Settings;
use super::values::row;
use super::{Instance, Phase, finite};
use crate::capabilities::OVER_STEP;
use crate::error::CallError;
use crate::events::Extra;
use hammer::Scene;
use hammer::sensitivity::{Argument, Derivative, Sample, derivatives, over_step};
use hammer::variables::{Parameter, Read, Role, Slot, VARIABLES};
use hammer::{Input, Machine};
use std::collections::BTreeSet;

/// The variable by which a derivative is taken.
#[derive(Clone, Copy)]
enum Known {
    /// An input.
    Input(Input),
    /// A real parameter.
    Parameter(Argument),
    /// A variable on which no present output depends: the time, an input's slope, or a position at which steps end.
    Unrelated,
}

impl Instance {
    /// `sum_k d unknown / d known_k seed_k`, for each unknown.
    ///
    /// # Errors
    ///
    /// An unknown is not a real output; a known is not a real parameter or input, or cannot change any more.
    pub fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, CallError> {
        seed.iter().try_for_each(|value| finite("seed", *value))?;
        let mut sums = Vec::new();
        for (row, seed) in self.jacobian(unknowns, knowns)?.iter().zip(seed) {
            sums.resize(row.len(), 0.0);
            sums.iter_mut().zip(row).for_each(|(sum, slope)| *sum += product(*slope, *seed));
        }
        Ok(sums)
    }

    /// `sum_k seed_k d unknown_k / d known`, for each known.
    ///
    /// # Errors
    /// Those of [`Instance::directional`].
    pub fn adjoint(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, CallError> {
        seed.iter().try_for_each(|value| finite("seed", *value))?;
        let sum = |row: &Vec<f64>| row.iter().zip(seed).map(|(a, b)| product(*a, *b)).sum();
        Ok(self.jacobian(unknowns, knowns)?.iter().map(sum).collect())
    }

    /// Derivatives of all scalars of the unknowns, with one row for each known.
    fn jacobian(&mut self, unknowns: &[u32], knowns: &[u32]) -> Result<Vec<Vec<f64>>, CallError> {
        use Phase::{Initialization, Instantiated, Stepping, Terminated};
        const CALL: &str = "GetDirectionalDerivative";
        self.demand(CALL, &[Instantiated, Initialization, Stepping, Terminated])?;
        // Equal knowns have equal rows, which are computed once.
        let distinct: Vec<u32> =
            knowns.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let rows = self.distinct_rows(unknowns, &distinct)?;
        let row = |known| distinct.binary_search(known).ok().and_then(|index| rows.get(index));
        Ok(knowns.iter().filter_map(row).cloned().collect())
    }

    fn distinct_rows(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
    ) -> Result<Vec<Vec<f64>>, CallError> {
        let knowns = knowns.iter().map(|r| self.known(*r)).collect::<Result<Vec<_>, _>>()?;
        if !unknowns.is_empty() && unknowns.iter().all(|reference| *reference >= OVER_STEP) {
            return self.over_step(unknowns, &knowns);
        }
        // Before any output is read, the scene must be created. This takes most of the time and can be cancelled.
        self.cancel.clone().over(|| self.machine().map(|_| ()))?;
        let mut sizes = Vec::with_capacity(unknowns.len());
        for reference in unknowns {
            sizes.push(self.output_values(*reference)?.len());
        }
        if matches!(self.phase, Phase::Stepping | Phase::Terminated) {
            let machine = self.machine()?;
            let row = |known: &Known| feedthrough(machine, unknowns, &sizes, *known);
            return Ok(knowns.iter().map(row).collect());
        }
        self.at_start(unknowns, sizes.iter().sum(), &knowns)
    }

    fn known(&self, reference: u32) -> Result<Known, CallError> {
        const WANTED: &str = "a real parameter or input";
        if let Face::Three { .. } = self.face
            && let Some(Extra::Time | Extra::Slope(_) | Extra::Position(_)) = Extra::of(reference)
        {
            return Ok(Known::Unrelated);
        }
        let variable = row(reference, WANTED)?;
        match variable.role {
            Role::Input(row) => return Ok(Known::Input(row.input)),
            Role::Parameter(Parameter { slot: Slot::Real(..), .. }) => self.may_set(variable)?,
            _ => {}
        }
        let argument = Argument::named(variable.name).map(Known::Parameter);
        argument.ok_or(CallError::Reference { reference, wanted: WANTED })
    }

    /// The values of a real output, which may be an array.
    fn output_values(&mut self, reference: u32) -> Result<Vec<f64>, CallError> {
        let is_fmi3 = self.face != Face::Two;
        if !(is_fmi3 && Extra::of(reference).is_some_and(Extra::is_output)) {
            output(reference)?;
        }
        let mut values = Vec::new();
        self.float64s(reference, &mut values)?;
        Ok(values)
    }

    /// The rows while initialization is not complete, by differences of scenes.
    fn at_start(
        &mut self,
        unknowns: &[u32],
        scalars: usize,
        knowns: &[Known],
    ) -> Result<Vec<Vec<f64>>, CallError> {
        let scene = self.scene()?;
        let (variant, face, events) = (&self.variant, self.face, &self.events);
        let run = |scene: &Scene| {
            let mut probe = Self::new(variant.clone(), face, false);
            probe.settings = Settings::of(&scene.parameters);
            (probe.inputs, probe.events) = (Inputs::new(scene.inputs), events.clone());
            probe.machine = Some(scene.machine()?);
            probe.phase = Phase::Stepping;
            let mut values = Vec::with_capacity(scalars);
            for reference in unknowns {
                if is_zero_at_start(*reference) {
                    // Differences would consist of rounding, and would contradict the model description.
                    values.push(0.0);
                    continue;
                }
                // The instance itself has just read the same outputs, so this can only fail because of an interrupt.
                let read = probe.output_values(*reference).map_err(|_| hammer::Error::Cancelled)?;
                values.extend(read);
            }
            Ok(Sample { values, ..Sample::default() })
        };
        let argument = |known: &Known| match known {
            Known::Input(input) => Argument::named(input.name()),
            Known::Parameter(argument) => Some(*argument),
            Known::Unrelated => None,
        };
        let by: Vec<Argument> = knowns.iter().filter_map(argument).collect();
        let rows = self.cancel.clone().over(|| derivatives(&scene, &by, &run))?;
        self.warn_of_kinks(by.iter().map(|by| by.name()).zip(&rows));
        // A known has no derivative if its neighbouring values are not allowed, for example the mass of a casing that
        // does not exist. The warning says so.
        let number_or_zero = |slope: f64| if slope.is_nan() { 0.0 } else { slope };
        let mut rows =
            rows.into_iter().map(|row| row.values.into_iter().map(number_or_zero).collect());
        let mut row = |known| argument(known).and_then(|_| rows.next());
        Ok(knowns.iter().map(|known| row(known).unwrap_or_else(|| vec![0.0; scalars])).collect())
    }

    /// The rows of unknowns above [`OVER_STEP`], by constants that are added to inputs during the last step.
    fn over_step(
        &mut self,
        unknowns: &[u32],
        knowns: &[Known],
    ) -> Result<Vec<Vec<f64>>, CallError> {
        self.demand(
            "GetDirectionalDerivative (over a step)",
            &[Phase::Stepping, Phase::Terminated],
        )?;
        let outputs = unknowns.iter().map(|reference| output(reference - OVER_STEP));
        let outputs = outputs.collect::<Result<Vec<_>, _>>()?;
        let mut inputs = Vec::with_capacity(knowns.len());
        for known in knowns {
            let Known::Input(input) = known else {
                let text = "derivatives over a step are by inputs alone";
                return Err(CallError::Argument(text.into()));
            };
            inputs.push(*input);
        }
        let read = |machine: &mut Machine| outputs.iter().map(|read| read(machine)).collect();
        let step_start = self.step_start.clone();
        let cancel = self.cancel.clone();
        let machine = self.machine()?;
        let present = machine.state();
        let start = match step_start {
            Some((time, None)) => present.looked_at(time),
            Some((_, Some(state))) => *state,
            None => present,
        };
        let rows = cancel.over(|| over_step(machine, &start, &inputs, &read))?;
        self.warn_of_kinks(inputs.iter().map(|input| input.name()).zip(&rows));
        Ok(rows.into_iter().map(|row| row.values).collect())
    }

    fn warn_of_kinks<'a>(&mut self, rows: impl Iterator<Item = (&'static str, &'a Derivative)>) {
        let warning = |(name, row): (_, &Derivative)| {
            let why = row.nonsmooth.first()?;
            Some(format!("derivatives by {name} hold on one side at most: {why}"))
        };
        let warnings: Vec<String> = rows.filter_map(warning).collect();
        self.warn(warnings);
    }
}

/// A row if the state is given. An output then depends only on the inputs that its row of the table names.
fn feedthrough(machine: &Machine, unknowns: &[u32], sizes: &[usize], known: Known) -> Vec<f64> {
    let slope = |reference: u32| match (known, VARIABLES.get(reference as usize)) {
        (Known::Input(input), Some(variable)) => match &variable.role {
            Role::Output(output) if output.feedthrough.contains(&input) => {
                (output.slope)(machine, input)
            }
            _ => 0.0,
        },
        _ => 0.0,
    };
    let values = unknowns.iter().zip(sizes);
    values.flat_map(|(reference, size)| std::iter::repeat_n(slope(*reference), *size)).collect()
}

/// The product of a slope and its seed. It is 0 if the seed is, even for an infinite slope.
fn product(slope: f64, seed: f64) -> f64 {
    if seed == 0.0 { 0.0 } else { slope * seed }
}

fn is_zero_at_start(reference: u32) -> bool {
    let row = VARIABLES.get(reference as usize).map(|variable| &variable.role);
    matches!(row, Some(Role::Output(output)) if output.zero_at_start)
}

fn output(reference: u32) -> Result<Read<f64>, CallError> {
    match VARIABLES.get(reference as usize).map(|variable| &variable.role) {
        Some(Role::Output(output)) => Ok(output.value),
        _ => Err(CallError::Reference { reference, wanted: "a real output" }),
    }
}
