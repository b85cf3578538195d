//! The dynamic state of a scene: all that a restart needs, and nothing that can be made again.

use super::blows::Blows;
use super::journal::Counters;
use super::ledger::Ledger;
use super::pace::Pace;
use super::peaks::Peaks;
use crate::motion::state::MotionState;
use crate::physics::parameters::Parameters;
use serde::{Deserialize, Serialize};

/// Dynamic state of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Parameters, with the tunables as they are now.
    pub parameters: Parameters,
    /// The motion at the last event.
    pub motion: MotionState,
    /// Sums up to there.
    pub ledger: Ledger,
    /// Counters, but for the search's work.
    pub counters: Counters,
    /// The story of the blows.
    pub blows: Blows,
    /// Peaks of the present step before the last event.
    pub peaks: Peaks,
    /// Start of the present step after the last event, s (0 if before).
    pub step_start: f64,
    /// How fast transitions follow each other.
    pub pace: Pace,
}
