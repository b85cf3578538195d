//! Derivatives over one communication step by a constant added to inputs.

use crate::error::Error;
use crate::machine::state::State;
use crate::machine::{Machine, Observer};
use crate::quantities::inputs::Input;
use crate::sensitivity::argument::Argument;
use crate::sensitivity::differences::{Derivative, differentiate};
use crate::sensitivity::sample::Sample;

/// Keeps the state before the first event of a step.
#[derive(Default)]
struct StartKeeper {
    /// Boxed: most steps have no event, and need not make room for it.
    start: Option<Box<State>>,
}

impl Observer for StartKeeper {
    fn before(&mut self, machine: &Machine) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
    }
}

impl Machine {
    /// [`Machine::advance`]; returns the state at the start of the step if an event moved it
    /// since. Otherwise it is [`State::looked_at`] that instant.
    ///
    /// # Errors
    /// Those of [`Machine::advance`].
    pub fn advance_keeping_start(&mut self, to: f64) -> Result<Option<Box<State>>, Error> {
        let mut keeper = StartKeeper::default();
        self.advance_observed(to, &mut keeper)?;
        Ok(keeper.start)
    }
}

/// Between events the motion is linear in an input, and steps may be longer by this.
const LINEAR: f64 = 100.0;

/// Derivatives of what `read` gives at the present by a constant added to each input from
/// `start` on, a step's start. The machine is left as it was.
///
/// # Errors
/// Those of [`Machine::restore`] and [`Machine::advance`].
pub fn over_step(
    machine: &mut Machine,
    start: &State,
    inputs: &[Input],
    read: &dyn Fn(&mut Machine) -> Vec<f64>,
) -> Result<Vec<Derivative>, Error> {
    let (present, end) = (machine.state(), machine.time());
    let journal = machine.exchange_journal(Some(Vec::new()));
    let mut run = |shift: Option<(Input, f64)>| {
        machine.restore(start)?;
        machine.take_journal();
        if let Some((input, by)) = shift {
            machine.add_to_input(input, by)?;
        }
        machine.advance(end)?;
        let values = read(machine);
        Ok(Sample { values, events: machine.take_journal(), passed: Vec::new() })
    };
    let mut derivatives = || {
        let base = run(None)?;
        let mut by = |input: &Input| {
            let value = present.input(*input).abs();
            let usual = Argument::named(input.name()).map_or(1.0, Argument::nominal);
            let scale = LINEAR * value.max(usual);
            differentiate(&base, scale, &mut |h| run(Some((*input, h))).map(Some))
        };
        inputs.iter().map(|input| by(input)).collect()
    };
    let found = derivatives();
    machine.restore(&present)?;
    machine.exchange_journal(journal);
    found
}
