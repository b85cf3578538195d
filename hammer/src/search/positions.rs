//! The instants at which the piston passes given positions over the bit.
//!
//! These guards have their own tracks. A passage ends a step, but it neither moves the epoch nor
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
    /// Each guard with its own tracks, since proofs proceed at different steps.
    trackers: Vec<(GuardTracker, Vec<Track>)>,
}

impl Positions {
    /// Tracks, from `from` after the epoch, where the piston crosses each level. A level is a position, m, and
    /// whether the piston is beyond it.
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
                event: Event::CLOSING, // Never happens.
            };
            (GuardTracker::new(signal(motion, &guard), from), tracks.clone())
        };
        Self { trackers: levels.iter().map(tracker).collect() }
    }

    /// The first passage up to `until` after the epoch, within the motion's reach: its time and level. `search` is
    /// that of the motion's events, whose work is limited.
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

    /// Ignores a level from now on, since its guard lies at zero within rounding.
    pub fn ignore(&mut self, index: usize) {
        let (tracker, _) = &mut self.trackers[index];
        (tracker.root, tracker.clear) = (None, f64::INFINITY);
    }
}
