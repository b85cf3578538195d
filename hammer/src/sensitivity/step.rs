//! Derivatives of a communication step with respect to constants that are added to inputs.

use crate::allowance::Allowance;
use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::state::State;
use crate::machine::stops::{Stop, Stopper, Stops};
use crate::machine::{Machine, Observer};
use crate::quantities::inputs::Input;
use crate::sensitivity::argument::Argument;
use crate::sensitivity::differences::{Derivative, Scale, differentiate, sharpen};
use crate::sensitivity::sample::Sample;

/// An observer that records the state before the first event of a step, and may end the step at a stop.
struct StartRecorder<'a> {
    /// Boxed, because most steps have no event.
    start: Option<Box<State>>,
    stopper: Option<Stopper<'a>>,
}

impl Observer for StartRecorder<'_> {
    fn before(&mut self, machine: &Machine) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
        if let Some(stopper) = &mut self.stopper {
            stopper.restart();
        }
    }

    fn after(&mut self, machine: &Machine, _: Event) -> bool {
        self.stopper.as_mut().is_some_and(|stopper| stopper.after(machine))
    }

    fn may_stop(&self) -> bool {
        self.stopper.is_some()
    }

    fn stops_before(&mut self, machine: &mut Machine, until: f64, to: f64) -> Result<bool, Error> {
        match &mut self.stopper {
            Some(stopper) => stopper.stops_before(machine, until, to),
            None => Ok(false),
        }
    }
}

impl Machine {
    /// Advances as [`Machine::advance`] does. Returns the state before the first event of the step, if there was one.
    /// Otherwise the machine's state still includes the start of the step (see [`State::looked_at`]). Also returns why
    /// `stops` ended the step before `to`, if they did.
    ///
    /// # Errors
    /// Those of [`Machine::advance`].
    pub fn advance_keeping_start(
        &mut self,
        to: f64,
        stops: Option<&mut Stops>,
    ) -> Result<(Option<Box<State>>, Stop), Error> {
        let stopper = stops.map(|stops| Stopper::new(self, stops));
        let mut recorder = StartRecorder { start: None, stopper };
        self.advance_observed(to, &mut recorder)?;
        let stop = recorder.stopper.map_or(Stop::default(), |stopper| stopper.end(self));
        Ok((recorder.start, stop))
    }
}

/// The steps of an input are larger by this factor, since between events the motion is linear in an input.
const LINEAR: f64 = 100.0;

/// Derivatives of the numbers that `read` returns at the present instant. Each is with respect to a constant that is
/// added to one input from the start of the step on, at which the state was `start`. The machine is unchanged
/// afterwards.
///
/// # Errors
/// Those of [`Machine::restore`] and [`Machine::advance`].
pub fn over_step(
    machine: &mut Machine,
    start: &State,
    inputs: &[Input],
    read: &dyn Fn(&mut Machine) -> Vec<f64>,
) -> Result<Vec<Derivative>, Error> {
    let Some(first) = inputs.first() else { return Ok(Vec::new()) };
    let (present, end) = (machine.state(), machine.time());
    let mut start = start.clone();
    let noise = sharpen(&mut start.parameters);
    let journal = machine.exchange_journal(Some(Vec::new()));
    let mut run = |input: Input, by: f64| {
        machine.restore(&start)?;
        machine.take_journal();
        machine.add_to_input(input, by)?;
        machine.advance(end)?;
        let values = read(machine);
        Ok(Sample { values, events: machine.take_journal(), passed: Vec::new() })
    };
    let derivatives = || {
        // This run also starts from `start`, so that its windows of air begin at the same instants as in the others.
        let base = run(*first, 0.0)?;
        let derivative = |input: &Input| {
            let value = present.input(*input).abs();
            let usual = Argument::named(input.name()).map_or(1.0, Argument::nominal);
            let scale = Scale { size: LINEAR * value.max(usual), noise };
            differentiate(&base, scale, &mut |h| run(*input, h).map(Some))
        };
        inputs.iter().map(derivative).collect()
    };
    let derivatives = Allowance::of_seconds(present.parameters.work_limit).within(derivatives);
    machine.restore(&present)?;
    machine.exchange_journal(journal);
    derivatives
}
