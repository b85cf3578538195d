//! The work of a search, and how much of it a communication step may take.
//!
//! A step's budget is [`ALLOWANCE`] units and [`RATE`] more for each radian of the mesh's fastest
//! motion. The reference hammer (20 elements a bar) takes 1e-4 of it: about 1e5 units a second. What
//! chatters, a contact a million times too stiff or a state that somebody has altered, would go on for
//! minutes or for ever; it ends with an error that says what chatters and which parameter is far off.

use crate::error::{Error, WorkLimit};
use crate::laws::event::Event;
use crate::motion::Motion;
use std::cell::Cell;

/// Units that a step of any length may take: some seconds on one core.
const ALLOWANCE: f64 = 1e7;
/// Units more per radian of the mesh's fastest motion.
const RATE: f64 = 800.0;
/// Units between two looks at an interrupt: a tenth of a millisecond, on the finest mesh four.
const PAUSE: u64 = 500;
/// Units of a Taylor window, and of a transition: about as long as so many evaluations.
const WINDOW: u64 = 16;
const TRANSITION: u64 = 100;

/// Work done by a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Evaluations of a guard or its bounds.
    pub evaluations: u64,
    /// Rotations of a track.
    pub samples: u64,
    /// Taylor windows opened.
    pub windows: u64,
    /// Steps of scans within windows.
    pub scans: u64,
}

impl Work {
    /// One evaluation a tabulated step ahead.
    #[inline]
    pub(super) fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.samples += 1;
    }

    fn units(&self) -> u64 {
        self.evaluations + self.samples + self.scans + WINDOW * self.windows
    }
}

/// What a step spends its work on.
const CAUSES: [WorkLimit; 4] =
    [WorkLimit::Contact, WorkLimit::Rock, WorkLimit::Drive, WorkLimit::Loads];

/// Work that the present step may still take.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    /// Units of [`Work`] and transitions that may be reached.
    limit: u64,
    /// Units at which an interrupt is looked for.
    pause: Cell<u64>,
    /// Transitions of the contact, the rock and the drive, and new series for loads that vary.
    spent: [u64; CAUSES.len()],
}

impl Budget {
    /// A step of length `span` (s) begins.
    pub fn begin_step(&mut self, motion: &Motion, span: f64, work: &Work) {
        let most = ALLOWANCE + RATE * span * motion.model().fastest_wave();
        self.limit = work.units().saturating_add(most as u64).min(u64::MAX - 1);
        self.spent = [0; CAUSES.len()];
        self.pause.set(0);
    }

    /// A transition happened; `None` where series are made anew because loads vary.
    pub fn count(&mut self, event: Option<Event>) {
        let cause = match event {
            Some(Event::Contact) => 0,
            Some(Event::Rock(_)) => 1,
            Some(Event::Relay(_) | Event::Port { .. } | Event::Level(_)) => 2,
            None => 3,
        };
        self.spent[cause] += TRANSITION;
    }

    /// Refuses to go on beyond `time`, s.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::Overwork`] where the budget is spent.
    #[inline]
    pub fn check(&self, motion: &Motion, work: &Work, time: f64) -> Result<(), Error> {
        let transitions: u64 = self.spent.iter().sum();
        let units = work.units() + transitions;
        if units < self.pause.get() { Ok(()) } else { self.look_up(motion, time, units) }
    }

    #[cold]
    fn look_up(&self, motion: &Motion, time: f64, units: u64) -> Result<(), Error> {
        Error::if_interrupted()?;
        if units > self.limit {
            return Err(self.refusal(motion, time));
        }
        self.pause.set((units + PAUSE).min(self.limit + 1));
        Ok(())
    }

    fn refusal(&self, motion: &Motion, time: f64) -> Error {
        // A transition is followed by a search, which takes some of the work too.
        let transitions: u64 = self.spent.iter().sum();
        let most = (0..CAUSES.len()).max_by_key(|&cause| self.spent[cause]);
        let is_busy = transitions as f64 > 0.01 * ALLOWANCE;
        let limit = most.filter(|_| is_busy).map_or(WorkLimit::Search, |cause| CAUSES[cause]);
        let suspect = motion.parameters().suspect();
        Error::Overwork { time, limit, mode: motion.mode(), suspect }
    }
}
