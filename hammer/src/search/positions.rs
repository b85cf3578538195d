//! Where the piston passes positions over the bit that somebody wants to hear of.
//!
//! Guards of their own are tracked on tracks of their own: what is found here ends a step, and
//! neither moves the epoch nor changes a bit of the motion.

use super::tracker::GuardTracker;
use super::work::Work;
use super::{re_arm, signal};
use crate::laws::event::{Direction, Displacement, Event, Guard, Quantity};
use crate::modal::track::Track;
use crate::motion::Motion;

/// The guards of all positions in the present mode.
#[derive(Debug)]
pub(crate) struct Positions {
    /// Each with its own tracks: it looks at them as far ahead as it likes.
    trackers: Vec<(GuardTracker, Vec<Track>)>,
}

impl Positions {
    /// Tracks from `from` after the epoch on where the piston leaves its side of each level: each
    /// is a position, m, and true where the piston is beyond it.
    pub fn start(motion: &Motion, levels: &[(f64, bool)], from: f64) -> Self {
        let mut tracks: Vec<Track> =
            (0..motion.tracks().len()).map(|index| motion.at_anchor(index)).collect();
        for track in &mut tracks {
            track.rotate_to(from);
        }
        let steady = motion.is_steady();
        let tracker = |&(level, beyond): &(f64, bool)| {
            let guard = Guard {
                quantity: Quantity::Displacement(Displacement::Relative),
                direction: if beyond { Direction::Falling } else { Direction::Rising },
                level,
                event: Event::Contact, // Never happens.
            };
            (GuardTracker::new(signal(motion, &guard, steady), from), tracks.clone())
        };
        Self { trackers: levels.iter().map(tracker).collect() }
    }

    /// The first passage up to `until` after the epoch, within the motion's reach: when, and of
    /// which level.
    ///
    /// # Errors
    /// What `check` says of the instant that it is known up to.
    pub fn first<E>(
        &mut self,
        motion: &Motion,
        until: f64,
        work: &mut Work,
        mut check: impl FnMut(&Work, f64) -> Result<(), E>,
    ) -> Result<Option<(f64, usize)>, E> {
        let mut first: Option<(f64, usize)> = None;
        for (index, (tracker, tracks)) in self.trackers.iter_mut().enumerate() {
            let end = first.map_or(until, |(at, _)| at);
            while tracker.root.is_none() && tracker.clear <= end {
                check(work, tracker.clear)?;
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

    /// Hears no more of a level: its guard was found at zero, and lies there within rounding.
    pub fn ignore(&mut self, index: usize) {
        let (tracker, _) = &mut self.trackers[index];
        (tracker.root, tracker.clear) = (None, f64::INFINITY);
    }
}
