//! A step that can be stopped early.

use super::{Machine, Observer};
use crate::error::Error;
use crate::laws::event::Event;

/// Asks after every event whether the step may go on.
struct Asking<F> {
    goes_on: F,
    stopped: bool,
}

impl<F: FnMut() -> bool> Observer for Asking<F> {
    fn after(&mut self, _: &Machine, _: Event) -> bool {
        self.stopped = !(self.goes_on)();
        self.stopped
    }
}

impl Machine {
    /// [`Self::advance`] that asks `goes_on` after every event and ends there if it says no. True
    /// if `to` was reached.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn advance_while(&mut self, to: f64, goes_on: impl FnMut() -> bool) -> Result<bool, Error> {
        let mut asking = Asking { goes_on, stopped: false };
        self.advance_observed(to, &mut asking)?;
        Ok(!asking.stopped)
    }
}
