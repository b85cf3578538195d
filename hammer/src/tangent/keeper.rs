//! The start of a step, kept for who asks later what an input did to it.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::state::State;
use crate::machine::stops::{Stop, Stopper, Stops};
use crate::machine::{Machine, Observer};
use crate::tangent::follow::Tangents;

/// [`Machine::advance`], with the tangents if there are any; returns the state at the start of
/// the step if an event moved it (without one, the state is only looked at), and where `stops`
/// ended the step before `to`, why.
///
/// # Errors
/// Those of [`Machine::advance`].
pub fn advance_from(
    machine: &mut Machine,
    to: f64,
    mut tangents: Option<&mut Tangents>,
    stops: Option<&mut Stops>,
) -> Result<(Option<Box<State>>, Stop), Error> {
    if let Some(tangents) = &mut tangents {
        tangents.begin_step(machine);
    }
    let stopper = stops.map(|stops| Stopper::new(machine, stops));
    let mut keeper = Keeper { tangents, start: None, stopper };
    machine.advance_before(to, &mut keeper)?;
    let stop = keeper.stopper.map_or(Stop::default(), |stopper| stopper.end(machine));
    Ok((keeper.start, stop))
}

/// Keeps the state before the first event of a step.
struct Keeper<'a> {
    tangents: Option<&'a mut Tangents>,
    /// Boxed: most steps have none, and need not move its room about.
    start: Option<Box<State>>,
    stopper: Option<Stopper<'a>>,
}

impl Observer for Keeper<'_> {
    fn before(&mut self, machine: &Machine, at: f64, event: Event) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
        if let Some(tangents) = &mut self.tangents {
            tangents.before(machine, at, event);
        }
    }

    fn after(&mut self, machine: &Machine) -> bool {
        let ends = self.tangents.as_mut().is_some_and(|tangents| tangents.after(machine));
        self.stopper.as_mut().is_some_and(|stopper| stopper.after(machine)) || ends
    }

    fn along(&mut self, machine: &Machine, at: f64) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
        if let Some(tangents) = &mut self.tangents {
            tangents.along(machine, at);
        }
        if let Some(stopper) = &mut self.stopper {
            stopper.restart();
        }
    }

    fn stops_before(&mut self, machine: &mut Machine, until: f64, to: f64) -> Result<bool, Error> {
        match &mut self.stopper {
            Some(stopper) => stopper.stops_before(machine, until, to),
            None => Ok(false),
        }
    }
}
