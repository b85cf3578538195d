//! The search for the instants at which the piston passes given positions over the bit.
//!
//! The guards of this search have tracks of their own. A passage may end a step, but it neither moves the epoch nor
//! changes the motion.

use super::tracker::GuardTracker;
use super::work::Work;
use super::{Search, re_arm, signal};
use crate::error::Error;
use crate::laws::event::{Direction, Displacement, Event, Guard};
use crate::modal::track::Track;
use crate::motion::Motion;

/// The guards of all positions in the present mode.
#[derive(Debug)]
pub(crate) struct Positions {
    /// Each guard with its own tracks, because the proofs advance in different steps.
    trackers: Vec<(GuardTracker, Vec<Track>)>,
}

impl Positions {
    /// A search that starts at `from` after the epoch. Each level is a position (m), and a flag that is true if the
    /// piston is beyond it at the start.
    pub fn start(motion: &Motion, levels: &[(f64, bool)], from: f64) -> Self {
        let mut tracks: Vec<Track> =
            (0..motion.tracks.len()).map(|index| motion.at_anchor(index)).collect();
        for track in &mut tracks {
            track.rotate_to(from);
        }
        let tracker = |&(level, beyond): &(f64, bool)| {
            let guard = Guard {
                displacement: Displacement::Relative,
                order: 0,
                direction: if beyond { Direction::Falling } else { Direction::Rising },
                level,
                event: Event::CLOSING, // A placeholder: a passage triggers no event.
            };
            (GuardTracker::new(signal(motion, &guard), from), tracks.clone())
        };
        Self { trackers: levels.iter().map(tracker).collect() }
    }

    /// The time of the first passage up to `until` after the epoch, and the index of its level. `until` must be within
    /// the motion's reach. `search` is the search for events; both share one limit of work.
    ///
    /// # Errors
    /// [`Error::Overwork`], [`Error::Cancelled`].
    pub fn first(
        &mut self,
        (search, motion): (&Search, &Motion),
        until: f64,
        work: &mut Work,
    ) -> Result<Option<(f64, usize)>, Error> {
        let mut first: Option<(f64, usize)> = None;
        for (index, (tracker, tracks)) in self.trackers.iter_mut().enumerate() {
            let end = first.map_or(until, |(at, _)| at);
            while tracker.root.is_none() && tracker.clear <= end {
                search.check_beside(motion, work, tracker.clear)?;
                tracker.limit(f64::INFINITY, end);
                tracker.extend(tracks, work);
                if let Some(value) = tracker.beyond
                    && tracker.root.is_some()
                {
                    re_arm(motion, tracker, value);
                }
            }
            if let Some(at) = tracker.root.filter(|at| *at <= end) {
                first = Some((at, index));
            }
        }
        Ok(first)
    }

    /// Ignores a level from now on. This is meant for a guard that stays at zero within rounding.
    pub fn ignore(&mut self, index: usize) {
        let (tracker, _) = &mut self.trackers[index];
        (tracker.root, tracker.clear) = (None, f64::INFINITY);
    }
}
