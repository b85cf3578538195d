//! The start of a step, kept for who asks later what an input did to it.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::state::State;
use crate::machine::{Machine, Observer};
use crate::tangent::follow::Tangents;

/// [`Machine::advance`], with the tangents if there are any; returns the state at the start of
/// the step if an event moved it. Without one, the state is only looked at.
///
/// # Errors
/// Those of [`Machine::advance`].
pub fn advance_from(
    machine: &mut Machine,
    to: f64,
    mut tangents: Option<&mut Tangents>,
) -> Result<Option<Box<State>>, Error> {
    if let Some(tangents) = &mut tangents {
        tangents.begin_step(machine);
    }
    let mut keeper = Keeper { tangents, start: None };
    machine.advance_before(to, &mut keeper)?;
    Ok(keeper.start)
}

/// Keeps the state before the first event of a step.
struct Keeper<'a> {
    tangents: Option<&'a mut Tangents>,
    /// Boxed: most steps have none, and need not move its room about.
    start: Option<Box<State>>,
}

impl Observer for Keeper<'_> {
    fn before(&mut self, machine: &Machine, at: f64, event: Event) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
        if let Some(tangents) = &mut self.tangents {
            tangents.before(machine, at, event);
        }
    }

    fn after(&mut self, machine: &Machine) -> bool {
        self.tangents.as_mut().is_some_and(|tangents| tangents.after(machine))
    }

    fn along(&mut self, machine: &Machine, at: f64) {
        self.start.get_or_insert_with(|| Box::new(machine.state()));
        if let Some(tangents) = &mut self.tangents {
            tangents.along(machine, at);
        }
    }
}
