//! The work of a search, and the limit of the work in a communication step.
//!
//! The unit of work is one evaluation of a guard.
//! A call's [`Allowance`] is counted in coordinates. A unit costs as many coordinates as the scene has, plus
//! [`BESIDE`]; the cost of air does not depend on the scene ([`AIR`]).
//! The reference hammer spends about 1e5 units per second of motion.
//!
//! Chattering could take minutes or never end, for example if a contact is a million times too stiff or a state is
//! corrupt. The limit turns it into an error that names what chatters and the parameter that is out of proportion.

use crate::allowance::Allowance;
use crate::error::{Error, WorkLimit};
use crate::laws::event::Event;
use crate::laws::mode::Tie;
use crate::motion::Motion;
use std::cell::Cell;

/// Constant part of a unit's cost, in coordinates.
const BESIDE: usize = 20;
/// Transitions are named as the cause if they make up at least this share of a step's work.
const BUSY: f64 = 0.01;
/// The barrier or the air is named as the cause if it makes up at least this share.
const MAJORITY: f64 = 0.5;
/// Number of units between two polls of the interrupt. This is 0.1 ms of work, or 4 ms on the finest mesh.
const PAUSE: u64 = 500;
/// Units that a Taylor window, a panel of the barrier's series, and a transition cost.
const WINDOW: u64 = 16;
const PANEL: u64 = 2;
const TRANSITION: u64 = 100;
/// Units that a passage of a port's edge costs, which changes no system, beside the air's next window.
const EDGE: u64 = 10;
/// Cost of the series of a window of air, in coordinates.
const AIR: u64 = 2_500;

/// The work that a search has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Number of evaluations of a guard or its bounds.
    pub evaluations: u64,
    /// Number of rotations of a track.
    pub samples: u64,
    /// Number of Taylor windows opened.
    pub windows: u64,
    /// Number of steps of the scans within windows.
    pub scans: u64,
    /// Units spent on the barrier's integrals.
    pub(super) barrier: u64,
    /// Number of series for the air in the chambers.
    air: u64,
}

impl Work {
    /// Counts one evaluation after a tabulated rotation.
    #[inline]
    pub(super) fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.samples += 1;
    }

    pub(crate) fn count_panels(&mut self, panels: u64) {
        self.barrier += PANEL * panels;
    }

    /// Counts the rotations and the series of a window of air or of a line.
    pub(crate) fn count_air(&mut self, [rotations, series]: [u64; 2]) {
        self.samples += rotations;
        self.air += series;
    }

    fn units(&self) -> u64 {
        self.evaluations + self.samples + self.scans + WINDOW * self.windows + self.barrier
    }
}

/// Possible causes of too much work, in the order of [`Budget::spent`].
fn causes() -> impl Iterator<Item = WorkLimit> {
    let others = [WorkLimit::Rock, WorkLimit::Drive, WorkLimit::Loads];
    others.into_iter().chain(Tie::all().map(WorkLimit::Tie))
}

/// The work of the present step. The call's [`Allowance`] is charged for it from time to time.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    /// [`Work`] at the start of the step.
    start: Work,
    /// Part of the cost of this step's [`Work`] and transitions that is already charged, in coordinates.
    pub paid: Cell<u64>,
    /// Cost of a unit, in coordinates.
    price: u64,
    /// Number of units of [`Work`] at which the interrupt is next polled.
    pause: Cell<u64>,
    /// Units spent on transitions of the rock, on those of the drive, on renewals of series under varying loads, and on
    /// the transitions of each tie.
    spent: [u64; 3 + Tie::COUNT],
}

impl Budget {
    pub fn begin_step(&mut self, motion: &Motion, work: &Work) {
        let coordinates: usize = motion.tracks.iter().map(|track| track.z.len()).sum();
        self.price = (coordinates + BESIDE) as u64;
        self.start = *work;
        self.paid.set(0);
        self.spent = Default::default();
        self.pause.set(0);
    }

    /// Counts a transition, or a renewal of series under varying loads if `event` is `None`.
    pub fn count(&mut self, event: Option<Event>) {
        let cause = match event {
            Some(Event::Rock(_)) => 0,
            Some(Event::Tie(tie, _)) => 3 + tie.index(),
            // All other events are those of the drive.
            Some(_) => 1,
            None => 2,
        };
        let is_edge = matches!(event, Some(Event::Port { .. } | Event::Opening { .. }));
        let cost = if is_edge { EDGE } else { TRANSITION };
        self.spent[cause] += cost;
        self.pause.set(self.pause.get().saturating_sub(cost));
    }

    /// Returns an error if the step may not continue beyond `time` (s).
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`]; [`Error::Overwork`] if the call's [`Allowance`] is spent.
    #[inline]
    pub fn check(&self, motion: &Motion, work: &Work, time: f64) -> Result<(), Error> {
        if work.units() < self.pause.get() { Ok(()) } else { self.poll(motion, time, work) }
    }

    #[cold]
    fn poll(&self, motion: &Motion, time: f64, work: &Work) -> Result<(), Error> {
        Error::if_interrupted()?;
        if !self.pay(work) {
            return Err(self.refusal(motion, time, work, self.paid.get()));
        }
        self.pause.set(work.units() + PAUSE);
        Ok(())
    }

    /// Charges the allowance for all work that is not yet charged. Returns false if the allowance is too small.
    pub fn pay(&self, work: &Work) -> bool {
        let units = work.units() - self.start.units() + self.transitions();
        let cost = self.price.saturating_mul(units).saturating_add(self.of_air(work));
        let due = cost.saturating_sub(self.paid.replace(cost));
        Allowance::spend(due)
    }

    /// Cost of the air's series, in coordinates.
    fn of_air(&self, work: &Work) -> u64 {
        AIR.saturating_mul(work.air - self.start.air)
    }

    fn transitions(&self) -> u64 {
        self.spent.iter().sum()
    }

    fn refusal(&self, motion: &Motion, time: f64, work: &Work, done: u64) -> Error {
        // Transitions are named even if their share is small, because much of the other work is the searches that
        // follow them.
        let largest = causes().zip(self.spent).max_by_key(|(_, spent)| *spent);
        let is_busy = (self.price * self.transitions()) as f64 > BUSY * done as f64;
        let limit = largest.filter(|_| is_busy).map_or(WorkLimit::Search, |(cause, _)| cause);
        let barrier = self.price.saturating_mul(work.barrier - self.start.barrier);
        // If air drives the piston, the renewed series are those of its windows.
        let [_, _, renewed, ..] = self.spent;
        let renewed = motion.air().map_or(0, |_| self.price.saturating_mul(renewed));
        let air = self.of_air(work).saturating_add(renewed);
        let mut others = [(WorkLimit::Barrier, barrier), (WorkLimit::Air, air)].into_iter();
        let main = others.find(|(_, spent)| *spent as f64 > MAJORITY * done as f64);
        let limit = main.map_or(limit, |(cause, _)| cause);
        let limit = match (limit, motion.air()) {
            (WorkLimit::Loads, Some(_)) => WorkLimit::Air,
            (limit, _) => limit,
        };
        let parameters = motion.parameters();
        let (suspect, work_limit) = (parameters.suspect(), Some(parameters.work_limit));
        Error::Overwork { time, limit, mode: motion.mode(), suspect, work_limit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::model::Model;
    use crate::quantities::inputs::Inputs;
    use crate::quantities::parameters::{InputValues, Parameters};

    fn motion() -> Motion {
        let model = Model::new(&Parameters::default()).expect("a model");
        let inputs = Inputs::constant(&InputValues::default());
        Motion::new(model, inputs, 0.0).expect("a scene")
    }

    /// Checks a step whose search has spent `work` against a new allowance of one second.
    fn checked(budget: &Budget, work: &Work) -> Result<(), WorkLimit> {
        let result = Allowance::of_seconds(1).within(|| budget.check(&motion(), work, 0.0));
        result.map_err(|error| match error {
            Error::Overwork { limit, .. } => limit,
            other => panic!("{other}"),
        })
    }

    /// `1 << 40` units exceed the allowance of a second.
    #[test]
    fn every_kind_of_work_is_paid_for_and_the_most_is_named() {
        let (many, none) = (1 << 40, Work::default());
        for (work, cause) in [
            (Work { evaluations: many, ..none }, WorkLimit::Search),
            (Work { barrier: many, evaluations: many / 2, ..none }, WorkLimit::Barrier),
            (Work { barrier: many, evaluations: 2 * many, ..none }, WorkLimit::Search),
            (Work { windows: many, scans: many, ..none }, WorkLimit::Search),
        ] {
            let mut budget = Budget::default();
            budget.begin_step(&motion(), &none);
            assert_eq!(checked(&budget, &work), Err(cause));
            // Work before the step does not count, and no work is charged twice.
            budget.begin_step(&motion(), &work);
            assert_eq!(checked(&budget, &work), Ok(()));
        }
    }

    /// Transitions count, and are named as the cause if they make up at least 1 % of the work.
    #[test]
    fn transitions_are_paid_for_and_named_by_their_cause() {
        use crate::laws::event::RockEvent;
        use crate::laws::mode::Relay;
        for (event, cause) in [
            (Some(Event::Rock(RockEvent::Touch)), WorkLimit::Rock),
            (Some(Event::Relay(Relay::Return)), WorkLimit::Drive),
            (None, WorkLimit::Loads),
            (Some(Event::CLOSING), WorkLimit::Tie(Tie::Contact)),
        ] {
            let mut budget = Budget::default();
            budget.begin_step(&motion(), &Work::default());
            for _ in 0..1 << 20 {
                budget.count(event);
            }
            let transitions = budget.transitions();
            assert_eq!(transitions, TRANSITION << 20);
            for (share, cause) in [(90, cause), (110, WorkLimit::Search)] {
                let work = Work { evaluations: share * transitions, ..Work::default() };
                assert_eq!(checked(&budget, &work), Err(cause), "{event:?}");
                budget.paid.set(0);
                budget.pause.set(0);
            }
        }
    }

    #[test]
    fn each_count_is_in_the_units_of_work() {
        let mut work = Work::default();
        work.count_evaluation();
        work.count_panels(3);
        work.count_air([5, 7]);
        let expected =
            Work { evaluations: 1, samples: 6, barrier: 3 * PANEL, air: 7, ..Work::default() };
        assert_eq!(work, expected);
        (work.windows, work.scans) = (11, 13);
        assert_eq!(work.units(), 1 + 6 + 13 + 3 * PANEL + 11 * WINDOW);
        assert_eq!(Budget::default().of_air(&work), 7 * AIR);
    }
}
