//! The dynamic state of a scene: all that a restart needs, and nothing that can be made again.

use super::blows::Progress;
use super::journal::Counters;
use super::ledger::Ledger;
use super::pace::Pace;
use super::peaks::Peaks;
use crate::motion::state::MotionState;
use crate::physics::parameters::Parameters;
use serde::{Deserialize, Serialize};

/// Dynamic state of a scene: to be kept, serialised and [restored](crate::Machine::restore).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Parameters, with the tunables as they are now.
    pub(crate) parameters: Parameters,
    /// The motion at the last event.
    pub(crate) motion: MotionState,
    /// Sums up to there.
    pub(crate) ledger: Ledger,
    /// Counters, but for the search's work.
    pub(crate) counters: Counters,
    /// The story of the blows.
    pub(crate) blows: Progress,
    /// Peaks of the present step before the last event.
    pub(crate) peaks: Peaks,
    /// Start of the present step after the last event, s (0 if before).
    pub(crate) step_start: f64,
    /// How fast transitions follow each other.
    pub(crate) pace: Pace,
}

impl State {
    /// Parameters, with the tunables as they were.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The same without what belongs to the host's communication step: two runs that were
    /// sliced differently are equal in this.
    #[must_use]
    pub fn without_step(mut self) -> Self {
        (self.peaks, self.step_start) = (Peaks::default(), 0.0);
        self
    }

    /// The same at another look since the last event, at `time`, s: nothing has moved the
    /// state between the two.
    #[must_use]
    pub fn looked_at(&self, time: f64) -> Self {
        let mut state = self.clone();
        state.motion.now = state.motion.epoch.until(time);
        state.motion.time = time;
        state
    }
}
