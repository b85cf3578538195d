//! How fast transitions follow each other: a cascade without end is an error, not a hang.

use crate::error::{Error, WorkLimit};
use crate::laws::mode::Mode;
use crate::motion::Motion;
use crate::numerics::instant::Double;
use crate::search::TIME_RESOLUTION;
use serde::{Deserialize, Serialize};

/// Transitions at one instant beyond which a cascade is without end.
pub const MAX_SIMULTANEOUS: u32 = 100;
/// A run of this many transitions must take at least [`SHORTEST_SPACING`] each on average.
pub const MAX_BURST: u32 = 20_000;
/// Least mean spacing of transitions, radians of the fastest motion that mesh, contact and
/// rock can make: a contact that rattles opens and closes once in `2 pi`.
pub const SHORTEST_SPACING: f64 = 0.05;

/// Transitions counted at one instant, and since an instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZenoDetector {
    /// Transitions at the present instant.
    pub simultaneous: u32,
    /// Transitions since `burst_start`, up to [`MAX_BURST`].
    pub burst: u32,
    /// Where the present run of transitions began.
    pub burst_start: Double,
}

impl ZenoDetector {
    /// At the start `time`.
    pub(crate) fn new(time: f64) -> Self {
        Self { simultaneous: 0, burst: 0, burst_start: Double::new(time) }
    }

    /// True where a run would have ended before.
    pub(crate) fn is_overrun(&self) -> bool {
        self.simultaneous > MAX_SIMULTANEOUS || self.burst >= MAX_BURST
    }

    /// A transition at the epoch, `after` the one before it, s.
    ///
    /// # Errors
    /// [`Error::Overwork`] where [`MAX_BURST`] transitions took too short a time.
    pub(crate) fn count(&mut self, motion: &Motion, after: f64) -> Result<(), Error> {
        self.simultaneous = if after <= TIME_RESOLUTION { self.simultaneous + 1 } else { 0 };
        self.burst += 1;
        if self.burst < MAX_BURST {
            return Ok(());
        }
        let epoch = motion.state().epoch;
        let span = epoch.since(self.burst_start);
        if span * motion.model().fastest() < SHORTEST_SPACING * f64::from(MAX_BURST) {
            let (time, mode) = (epoch.value(), motion.mode());
            let (limit, suspect) = (WorkLimit::Transitions, motion.parameters().suspect());
            return Err(Error::Overwork { time, limit, mode, suspect });
        }
        (self.burst, self.burst_start) = (0, epoch);
        Ok(())
    }

    /// # Errors
    /// [`Error::Chattering`] where more than [`MAX_SIMULTANEOUS`] transitions chase one another at
    /// one instant; `from` is the mode left by the last.
    pub(crate) fn check_simultaneous(&self, motion: &Motion, from: Mode) -> Result<(), Error> {
        if self.simultaneous <= MAX_SIMULTANEOUS {
            return Ok(());
        }
        let (time, to) = (motion.state().epoch.value(), motion.mode());
        Err(Error::Chattering { time, transitions: self.simultaneous, from, to })
    }
}
