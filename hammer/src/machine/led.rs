//! A machine led by a search of somebody else's, for comparisons: what it watches, and events
//! that happen where that search says.

use super::Machine;
use crate::error::Error;
use crate::laws::event::Event;
use crate::modal::track::Track;
use crate::search::signal::Signal;

impl Machine {
    /// The tracks at the last event, and what is tracked from there on.
    #[doc(hidden)]
    pub fn tracked(&self) -> (Vec<Track>, Vec<(Event, Signal)>) {
        let tracks = 0..self.motion.tracks().len();
        (tracks.map(|i| self.motion.at_anchor(i)).collect(), self.search.tracked().collect())
    }

    /// Where the viscous work reaches the energy barrier, if that is not after `until`; both
    /// after the last event, s.
    #[doc(hidden)]
    pub fn barrier_within(&mut self, until: f64) -> Option<f64> {
        self.search.barrier_within(&self.motion, until)
    }

    /// How long after the last event an instant is, s.
    #[doc(hidden)]
    pub fn until(&self, time: f64) -> f64 {
        self.motion.until(time)
    }

    /// An event happens at `at` after the last one, s.
    ///
    /// # Errors
    /// As [`Machine::advance`].
    #[doc(hidden)]
    pub fn lead(&mut self, at: f64, event: Event) -> Result<(), Error> {
        self.occur(at, event)
    }

    /// Nothing happens up to `time`, which is the present now.
    #[doc(hidden)]
    pub fn wait(&mut self, time: f64) {
        self.views = super::Views::default();
        self.motion.set_present(self.motion.until(time), time);
    }
}
