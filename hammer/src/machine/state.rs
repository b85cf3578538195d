//! The dynamic state of a scene: everything that a restart needs and cannot recompute.

use super::blows::Progress;
use super::deferred::DeferredLedger;
use super::journal::Counters;
use super::peaks::Searched;
use super::zeno::ZenoDetector;
use crate::air::Air;
use crate::error::{CorruptState, Error};
use crate::modal::graph::Group;
use crate::motion::state::{Anchor, MotionState};
use crate::numerics::instant::Double;
use crate::quantities::inputs::Input;
use crate::quantities::parameters::{Parameters, Source};
use serde::{Deserialize, Serialize};

/// Dynamic state of a scene, to be stored, serialised and [restored](crate::Machine::restore).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Parameters, with the present values of the tunables.
    pub(crate) parameters: Parameters,
    /// The motion at the last event.
    pub(crate) motion: MotionState,
    /// Sums up to the last event.
    pub(crate) ledger: DeferredLedger,
    /// Counters, but for the search's work.
    pub(crate) counters: Counters,
    /// Blows and collisions so far.
    pub(crate) blows: Progress,
    /// Peaks of the present step before the last event.
    pub(crate) peaks: Searched,
    /// Start of the present step after the last event, s (0 if before).
    pub(crate) step_start: f64,
    /// Spacing of recent transitions.
    pub(crate) zeno: ZenoDetector,
}

impl State {
    /// Parameters, with the tunables as they were then.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Value of an input then.
    pub(crate) fn input(&self, input: Input) -> f64 {
        self.motion.inputs.of(input).at(self.motion.now)
    }

    /// The state without what depends on the host's communication steps: equal for runs that were
    /// sliced differently.
    #[must_use]
    pub fn without_step(mut self) -> Self {
        (self.peaks, self.step_start) = (Searched::default(), 0.0);
        self.blows.step.clear();
        self
    }

    /// The state as it was at another instant `time` (s) since the last event, which needs no
    /// motion.
    #[must_use]
    pub fn looked_at(&self, time: f64) -> Self {
        let mut state = self.clone();
        state.motion.now = state.motion.epoch.until(time);
        state.motion.time = time;
        state
    }
}

/// Relative rounding by which the host's time may differ from the event's.
const TIME_ROUNDING: f64 = 1e-12;

impl State {
    /// Refuses a corrupt state. Its bytes may come from anywhere, and reading them must not start
    /// an endless search.
    ///
    /// # Errors
    /// [`Error::Corrupt`].
    pub(crate) fn check(&self) -> Result<(), Error> {
        let refuse = |what| Err(Error::Corrupt { what });
        let motion = &self.motion;
        if !motion.is_finite() || !self.step_start.is_finite() {
            return refuse(CorruptState::NotFinite);
        }
        let lag = motion.epoch.until(motion.time) - motion.now;
        // Some instants are stored rounded.
        let rounding = TIME_ROUNDING * (1.0 + motion.time.abs());
        let later = |instant: Double| motion.epoch.until(instant.value()) > rounding;
        if self.blows.instants().chain([self.zeno.burst_start]).any(later) {
            return refuse(CorruptState::Times);
        }
        if motion.now < 0.0 || lag.abs() > rounding {
            return refuse(CorruptState::Times);
        }
        if !(0.0..=motion.now).contains(&self.step_start) {
            return refuse(CorruptState::Step);
        }
        // Only a piston that flies alone is left where it was.
        let elsewhere = |anchor: &Anchor| anchor.at != 0.0 && anchor.group != Group::PISTON;
        if motion.anchors.iter().any(|anchor| anchor.at > 0.0 || elsewhere(anchor)) {
            return refuse(CorruptState::Ahead);
        }
        let strange = |anchor: &Anchor| {
            anchor.driven.slow.iter().any(|(coordinate, _)| *coordinate >= anchor.z.len())
        };
        if motion.anchors.iter().any(strange) {
            return refuse(CorruptState::Coordinates);
        }
        // A series belongs to varying loads, and is renewed where it ends.
        let still = motion.loads.iter().all(|load| load.is_constant());
        let ended = |reach: f64| still || reach <= 0.0 || reach < motion.now;
        if motion.anchors.iter().any(|anchor| anchor.driven.reach.is_some_and(ended)) {
            return refuse(CorruptState::Series);
        }
        if !motion.gas.iter().all(|gas| gas.is_sound(motion.now)) {
            return refuse(CorruptState::Chambers);
        }
        let is_air = self.parameters.drive.source == Source::Air;
        let sound = |air: &Air| {
            air.window.is_none() == air.vented.is_some()
                && (motion.mode.vented && !air.shut) == air.vented.is_some()
                && air.is_sound(motion.now)
        };
        if motion.air.is_some() != is_air || !motion.air.as_deref().is_none_or(sound) {
            return refuse(CorruptState::Chambers);
        }
        if self.blows.step.len() > super::blows::MAX_STEP_BLOWS {
            return refuse(CorruptState::Blows);
        }
        if self.counters.are_too_many() || self.zeno.is_overrun() {
            return refuse(CorruptState::Counts);
        }
        Ok(())
    }
}
