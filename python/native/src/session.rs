//! A machine, and everything that was set on it since the last step.

use crate::failure::Failure;
use crate::table::Pick;
use hammer::Scene;
use hammer::variables::{ALONG, InputRow, Parameter, Role, VARIABLES};
use hammer::{Input, MAX_INPUT_ORDER, Machine, Parameters, Profile, Stops};
use serde::{Deserialize, Serialize};

/// A value and derivatives of an input.
type Polynomial = [f64; MAX_INPUT_ORDER + 1];

/// Everything that was set since the last step. Values and derivatives come separately, in any order; the last ones
/// are passed to the engine together, as one polynomial.
#[derive(Clone, Serialize, Deserialize)]
pub struct Pending {
    /// Parameters, with the tunable values that were set.
    pub parameters: Parameters,
    inputs: [Option<Polynomial>; Input::ALL.len()],
    /// Events that end steps early, if any.
    pub stops: Option<Stops>,
}

/// A machine that is stepped and read.
pub struct Session {
    pub machine: Machine,
    pub pending: Pending,
    /// Values along the bodies, if they were read since the last step.
    profile: Option<Profile>,
    handed: bool,
    /// True if a tunable parameter may differ from the machine's.
    retunes: bool,
    /// Number of warnings of the exchange that were reported.
    reported: u32,
}

impl Session {
    /// A session at time 0.
    pub fn new(scene: &Scene, journal: bool) -> Result<Self, Failure> {
        let mut machine = scene.machine()?;
        machine.keep_journal(journal);
        let inputs = [None; Input::ALL.len()];
        let pending = Pending { parameters: scene.parameters, inputs, stops: None };
        Ok(Self { machine, pending, profile: None, handed: true, retunes: false, reported: 0 })
    }

    /// Continues from another state, which must not allow calls more work than this machine does.
    pub fn resume(&mut self, state: &hammer::State, pending: &Pending) -> Result<(), Failure> {
        let [allowed, wanted] =
            [self.machine.parameters(), state.parameters()].map(|p| p.work_limit);
        if wanted > allowed {
            return Err(Failure::Refused(format!(
                "the state has work_limit = {wanted}, above this hammer's {allowed}"
            )));
        }
        self.machine.restore(state)?;
        (self.pending, self.profile, self.handed) = (pending.clone(), None, false);
        if let Some(stops) = &mut self.pending.stops {
            stops.settle(&self.machine);
        }
        self.retunes = true;
        Ok(())
    }

    /// Sets an input's value, or its derivatives, from now on.
    pub fn set_input(&mut self, input: Input, value: Option<f64>, derivatives: &[f64]) {
        let now = self.machine.input(input);
        let poly = self.pending.inputs[input as usize].get_or_insert_with(|| {
            let mut poly = Polynomial::default();
            poly[0] = now;
            poly
        });
        poly[0] = value.unwrap_or(poly[0]);
        for (k, derivative) in derivatives.iter().enumerate().take(MAX_INPUT_ORDER) {
            poly[k + 1] = *derivative;
        }
        (self.handed, self.profile) = (false, None);
    }

    /// Sets a tunable parameter from the next step on.
    pub fn tune(&mut self, row: usize, value: f64) {
        if let Role::Parameter(Parameter { slot, .. }) = &VARIABLES[row].role {
            slot.write(&mut self.pending.parameters, value);
            self.retunes = true;
        }
    }

    /// Steps to an instant, or to an event that ends the step.
    pub fn advance(&mut self, to: f64) -> Result<(), Failure> {
        if self.retunes {
            self.machine.retune(&self.pending.parameters)?;
            self.retunes = false;
        }
        self.hand_over()?;
        self.profile = None;
        let done = match &mut self.pending.stops {
            None => self.machine.advance(to),
            stops => self.machine.advance_keeping_start(to, stops.as_mut()).map(drop),
        };
        self.pending.inputs = [None; Input::ALL.len()];
        Ok(done?)
    }

    /// The last warning of the exchange, if it is new.
    pub fn news(&mut self) -> Option<String> {
        let excesses = self.machine.exchange_excesses();
        if excesses <= self.reported {
            return None;
        }
        self.reported = excesses;
        self.machine.exchange_warning()
    }

    /// Passes the inputs that were set to the machine.
    fn hand_over(&mut self) -> Result<(), Failure> {
        if std::mem::replace(&mut self.handed, true) {
            return Ok(());
        }
        for (input, poly) in Input::ALL.into_iter().zip(&self.pending.inputs) {
            if let Some(poly) = poly {
                self.machine.set_input(input, poly)?;
            }
        }
        Ok(())
    }

    /// Present values, in the order of the picks.
    pub fn read(&mut self, picks: &[Pick], into: &mut Vec<f64>) -> Result<(), Failure> {
        self.hand_over()?;
        for pick in picks {
            let value = match pick {
                Pick::Row(row) => self.value(*row)?,
                Pick::Wave(family, index) => self.wave(*family, *index)?,
            };
            into.push(value);
        }
        Ok(())
    }

    fn value(&mut self, row: usize) -> Result<f64, Failure> {
        let machine = &mut self.machine;
        Ok(match &VARIABLES[row].role {
            Role::Parameter(Parameter { slot, .. }) => slot.read(&self.pending.parameters),
            Role::Input(InputRow { input, .. }) => {
                let set = self.pending.inputs[*input as usize];
                set.map_or_else(|| machine.input(*input), |poly| poly[0])
            }
            // -0 becomes 0, since a force of -0 N would look like tension.
            Role::Output(output) => {
                if let Some(prepare) = output.prepare {
                    prepare(machine)?;
                }
                (output.value)(machine) + 0.0
            }
            Role::Truth(value) => f64::from(u8::from(value(machine))),
            Role::Choice(_, index) => index(machine) as f64 + 1.0,
        })
    }

    /// Time derivative of an output.
    pub fn rate(&mut self, row: usize) -> Result<Option<f64>, Failure> {
        self.hand_over()?;
        let Role::Output(output) = &VARIABLES[row].role else { return Ok(None) };
        Ok(Some((output.rate)(&mut self.machine) + 0.0))
    }

    fn wave(&mut self, family: usize, index: usize) -> Result<f64, Failure> {
        let (family, machine) = (&ALONG[family], &self.machine);
        let profile = self.profile.get_or_insert_with(|| machine.profile());
        let value = family.value(profile, index);
        value.ok_or_else(|| Failure::Refused(family.missing(index, machine.parameters())))
    }
}
