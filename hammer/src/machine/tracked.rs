//! Access to what a machine tracks, for comparisons.

use super::Machine;
use crate::laws::event::Event;
use crate::modal::track::Track;
use crate::search::signal::Signal;

impl Machine {
    /// The tracks at the last event, and the signals tracked from there.
    #[doc(hidden)]
    pub fn tracked(&self) -> (Vec<Track>, Vec<(Event, Signal)>) {
        let tracks = 0..self.motion.tracks().len();
        (tracks.map(|i| self.motion.at_anchor(i)).collect(), self.search.tracked().collect())
    }
}
