//! Who looks on while a machine advances.

use super::Machine;
use super::state::State;
use crate::physics::event::Event;
use crate::tangent::Tangents;

/// Sees every event before it happens and after, and may end the step there.
pub(crate) trait Witness {
    /// `event` is about to happen at `at` after the epoch.
    fn before(&mut self, machine: &Machine, at: f64, event: Event);
    /// It has happened, at the epoch; true ends the step here.
    fn after(&mut self, machine: &Machine) -> bool;
    /// Nothing happens, but the epoch is about to move by `at`.
    fn along(&mut self, machine: &Machine, at: f64);
}

impl Witness for () {
    fn before(&mut self, _: &Machine, _: f64, _: Event) {}

    fn after(&mut self, _: &Machine) -> bool {
        false
    }

    fn along(&mut self, _: &Machine, _: f64) {}
}

/// Keeps the state before the first event of a step.
pub(crate) struct Keeper<'a> {
    pub tangents: Option<&'a mut Tangents>,
    pub start: Option<State>,
}

impl Witness for Keeper<'_> {
    fn before(&mut self, machine: &Machine, at: f64, event: Event) {
        self.start.get_or_insert_with(|| machine.state());
        if let Some(tangents) = &mut self.tangents {
            tangents.before(machine, at, event);
        }
    }

    fn after(&mut self, machine: &Machine) -> bool {
        self.tangents.as_mut().is_some_and(|tangents| tangents.after(machine))
    }

    fn along(&mut self, machine: &Machine, at: f64) {
        self.start.get_or_insert_with(|| machine.state());
        if let Some(tangents) = &mut self.tangents {
            tangents.along(machine, at);
        }
    }
}
