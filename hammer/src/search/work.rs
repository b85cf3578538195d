//! The work of a search, and how much a communication step may spend.
//!
//! A step's budget is [`ALLOWANCE`] units plus [`RATE`] for each radian of the mesh's fastest
//! motion. The reference hammer (20 elements per bar) spends about 1e5 units a second, 1e-4 of its
//! budget. Chattering (a contact a million times too stiff, a corrupt state) could take minutes or
//! for ever; it ends with an error that names what chatters and the parameter that is out of
//! proportion.

use crate::error::{Error, WorkLimit};
use crate::laws::event::Event;
use crate::motion::Motion;
use std::cell::Cell;

/// Units that a step of any length may spend: some seconds on one core.
const ALLOWANCE: f64 = 1e7;
/// Additional units per radian of the mesh's fastest motion.
const RATE: f64 = 800.0;
/// Units between two polls of the interrupt: 0.1 ms, or 4 ms on the finest mesh.
const PAUSE: u64 = 500;
/// Units of a Taylor window, and of a transition: each takes about as long as so many evaluations.
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
    /// Counts one evaluation a tabulated step ahead.
    #[inline]
    pub(super) fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.samples += 1;
    }

    fn units(&self) -> u64 {
        self.evaluations + self.samples + self.scans + WINDOW * self.windows
    }
}

/// What can use up the work of a step.
const CAUSES: [WorkLimit; 6] = [
    WorkLimit::Contact,
    WorkLimit::Rock,
    WorkLimit::Drive,
    WorkLimit::Loads,
    WorkLimit::Chuck,
    WorkLimit::Joints,
];

/// Work that the present step may still spend.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    /// Total of units of [`Work`] and transitions at which the step ends.
    limit: u64,
    /// Units of [`Work`] at which the interrupt is polled.
    pause: Cell<u64>,
    /// Transitions of the contact, the rock and the drive, and new series for loads that vary.
    spent: [u64; CAUSES.len()],
}

impl Budget {
    /// Begins a step of length `span`, s.
    pub fn begin_step(&mut self, motion: &Motion, span: f64, work: &Work) {
        let most = ALLOWANCE + RATE * span * motion.model().fastest_wave;
        self.limit = work.units().saturating_add(most as u64).min(u64::MAX - 1);
        self.spent = [0; CAUSES.len()];
        self.pause.set(0);
    }

    /// Counts a transition; `None` where series are renewed because loads vary.
    pub fn count(&mut self, event: Option<Event>) {
        let cause = match event {
            Some(Event::Contact) => 0,
            Some(Event::Rock(_)) => 1,
            Some(Event::Relay(_) | Event::Port { .. } | Event::Level(_) | Event::Vent(_)) => 2,
            None => 3,
            Some(Event::Chuck(_)) => 4,
            Some(Event::Joint { .. }) => 5,
        };
        self.spent[cause] += TRANSITION;
        self.pause.set(self.pause.get().saturating_sub(TRANSITION));
    }

    /// Returns an error if the step may not go on beyond `time`, s.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`]; [`Error::Overwork`] if the budget is spent.
    #[inline]
    pub fn check(&self, motion: &Motion, work: &Work, time: f64) -> Result<(), Error> {
        if work.units() < self.pause.get() { Ok(()) } else { self.poll(motion, time, work.units()) }
    }

    #[cold]
    fn poll(&self, motion: &Motion, time: f64, units: u64) -> Result<(), Error> {
        Error::if_interrupted()?;
        let transitions: u64 = self.spent.iter().sum();
        if units + transitions > self.limit {
            return Err(self.refusal(motion, time));
        }
        self.pause.set((units + PAUSE).min(self.limit + 1 - transitions));
        Ok(())
    }

    fn refusal(&self, motion: &Motion, time: f64) -> Error {
        // Some of the work is that of the searches after transitions.
        let transitions: u64 = self.spent.iter().sum();
        let most = (0..CAUSES.len()).max_by_key(|&cause| self.spent[cause]);
        let is_busy = transitions as f64 > 0.01 * ALLOWANCE;
        let limit = most.filter(|_| is_busy).map_or(WorkLimit::Search, |cause| CAUSES[cause]);
        let suspect = motion.parameters().suspect();
        Error::Overwork { time, limit, mode: motion.mode(), suspect }
    }
}
