//! Zeno detection: an endless sequence of transitions causes an error instead of an endless loop.

use crate::error::{Error, WorkLimit};
use crate::laws::mode::Mode;
use crate::motion::Motion;
use crate::numerics::instant::Double;
use crate::search::TIME_RESOLUTION;
use serde::{Deserialize, Serialize};

/// More transitions at one instant than this are Zeno behaviour.
pub const MAX_SIMULTANEOUS: u32 = 100;
/// A run of this many transitions must take at least [`SHORTEST_SPACING`] each on average.
pub const MAX_BURST: u32 = 20_000;
/// Least mean spacing of transitions, in radians of the fastest oscillation that mesh, contact and rock can make. A
/// chattering contact opens and closes once in `2 pi`.
pub const SHORTEST_SPACING: f64 = 0.05;

/// Counts of the transitions at one instant and in a run of transitions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZenoDetector {
    /// Transitions at the present instant.
    pub simultaneous: u32,
    /// Transitions since `burst_start`, up to [`MAX_BURST`].
    pub burst: u32,
    /// Start of the present run of transitions.
    pub burst_start: Double,
}

impl ZenoDetector {
    /// A detector that starts at `time`.
    pub(crate) fn new(time: f64) -> Self {
        Self { simultaneous: 0, burst: 0, burst_start: Double::new(time) }
    }

    /// True for counts that no running machine has, because it would already have raised an error.
    pub(crate) fn is_overrun(&self) -> bool {
        self.simultaneous > MAX_SIMULTANEOUS || self.burst >= MAX_BURST
    }

    /// Counts a transition at the epoch, which comes `after` seconds after the previous one.
    ///
    /// # Errors
    ///
    /// [`Error::Overwork`] if [`MAX_BURST`] transitions took too short a time.
    pub(crate) fn count(&mut self, motion: &Motion, after: f64) -> Result<(), Error> {
        self.simultaneous = if after <= TIME_RESOLUTION { self.simultaneous + 1 } else { 0 };
        self.burst += 1;
        if self.burst < MAX_BURST {
            return Ok(());
        }
        let epoch = motion.state.epoch;
        let span = epoch.since(self.burst_start);
        if span * motion.model.fastest() < SHORTEST_SPACING * f64::from(MAX_BURST) {
            let (time, mode) = (epoch.value(), motion.mode());
            let (limit, suspect) = (WorkLimit::Transitions, motion.parameters().suspect());
            return Err(Error::Overwork { time, limit, mode, suspect, work_limit: None });
        }
        (self.burst, self.burst_start) = (0, epoch);
        Ok(())
    }

    /// Checks the number of transitions at one instant. `from` is the mode before the last of them.
    ///
    /// # Errors
    ///
    /// [`Error::Chattering`] after more than [`MAX_SIMULTANEOUS`] transitions at one instant.
    pub(crate) fn check_simultaneous(&self, motion: &Motion, from: Mode) -> Result<(), Error> {
        if self.simultaneous <= MAX_SIMULTANEOUS {
            return Ok(());
        }
        let (time, to) = (motion.state.epoch.value(), motion.mode());
        Err(Error::Chattering { time, transitions: self.simultaneous, from, to })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::model::Model;
    use crate::quantities::inputs::Inputs;
    use crate::quantities::parameters::{InputValues, Parameters};

    /// First all transitions come at one instant, then within nine tenths and eleven tenths of the least time allowed
    /// for their number.
    #[test]
    fn a_long_run_of_transitions_is_an_error_where_it_took_too_short_a_time() {
        let model = Model::new(&Parameters::default()).expect("a model");
        let inputs = Inputs::constant(&InputValues::default());
        let motion = Motion::new(model, inputs, 0.0).expect("a scene");
        let shortest = SHORTEST_SPACING * f64::from(MAX_BURST) / motion.model.fastest();
        for (part, is_short) in [(0.0, true), (0.9, true), (1.1, false)] {
            let mut detector = ZenoDetector::new(-part * shortest);
            for count in 1..MAX_BURST {
                assert_eq!(detector.count(&motion, 0.0), Ok(()));
                assert_eq!((detector.simultaneous, detector.burst), (count, count));
                assert_eq!(detector.is_overrun(), count > MAX_SIMULTANEOUS);
                let result = detector.check_simultaneous(&motion, motion.mode());
                assert_eq!(result.is_err(), count > MAX_SIMULTANEOUS);
            }
            let last = detector.count(&motion, 2.0 * TIME_RESOLUTION);
            assert_eq!(detector.simultaneous, 0);
            if is_short {
                let Err(Error::Overwork { limit, .. }) = last else { panic!("{last:?}") };
                assert_eq!(limit, WorkLimit::Transitions);
                assert!(detector.is_overrun());
            } else {
                assert_eq!((last, detector.burst), (Ok(()), 0));
                assert_eq!(detector.burst_start, motion.state.epoch);
            }
        }
    }
}
