//! A sample: the numbers and events of a run, of which differences are taken.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::Machine;
use crate::machine::journal::Record;
use std::fmt;

/// Numbers that were read from a run, and the run's events.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// The numbers that were read.
    pub values: Vec<f64>,
    /// The events in order of time.
    pub events: Vec<Record>,
    /// Number of events before each instant at which the run was read. It is not compared if it is empty.
    pub passed: Vec<usize>,
}

/// The first difference of two sequences of events.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Two events are in the opposite order.
    Exchanged(Event, Event),
    /// An event is missing.
    Vanishes(Event),
    /// There is a new event.
    Appears(Event),
    /// An event is replaced by another.
    Replaced(Event, Event),
    /// An event moves across an instant at which the run is read.
    AtInstant(Event),
}

impl Sample {
    /// Advances a machine to each of `instants` in turn and reads it there.
    ///
    /// # Errors
    /// Those of [`Machine::advance`].
    pub fn of_run(
        machine: &mut Machine,
        instants: &[f64],
        read: &dyn Fn(&mut Machine) -> Vec<f64>,
    ) -> Result<Self, Error> {
        machine.keep_journal(true);
        let mut sample = Self::default();
        for instant in instants {
            machine.advance(*instant)?;
            sample.values.extend(read(machine));
            sample.events.extend(machine.take_journal());
            sample.passed.push(sample.events.len());
        }
        machine.keep_journal(false);
        Ok(sample)
    }

    /// True if both runs had the same events in the same order.
    pub(crate) fn agrees(&self, other: &Self) -> bool {
        self.change(other).is_none()
    }

    /// The first difference between these events and those of another run; `None` if there is none.
    pub fn change(&self, other: &Self) -> Option<Change> {
        let (ours, theirs) = (&self.events, &other.events);
        let differs = |k: &usize| ours.get(*k).map(|r| r.event) != theirs.get(*k).map(|r| r.event);
        let Some(first) = (0..ours.len().max(theirs.len())).find(differs) else {
            let difference = self.passed.iter().zip(&other.passed).find(|(a, b)| a != b);
            let (a, b) = difference?;
            return ours.get(*a.min(b)).map(|r| Change::AtInstant(r.event));
        };
        let event = |list: &[Record], k: usize| list.get(k).map(|r| r.event);
        let [old, next] = [event(ours, first), event(ours, first + 1)];
        let [new, after] = [event(theirs, first), event(theirs, first + 1)];
        Some(match (old, new) {
            (Some(old), Some(new)) if next == Some(new) && after == Some(old) => {
                Change::Exchanged(old, new)
            }
            (Some(old), _) if ours.len() > theirs.len() => Change::Vanishes(old),
            (_, Some(new)) if ours.len() < theirs.len() => Change::Appears(new),
            (Some(old), Some(new)) => Change::Replaced(old, new),
            (Some(old), None) => Change::Vanishes(old),
            (None, Some(new)) => Change::Appears(new),
            (None, None) => return None,
        })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Exchanged(a, b) => write!(f, "{a} and {b} change places"),
            Self::Vanishes(event) => write!(f, "{event} vanishes"),
            Self::Appears(event) => write!(f, "{event} appears"),
            Self::Replaced(old, new) => write!(f, "{new} takes the place of {old}"),
            Self::AtInstant(event) => {
                write!(f, "{event} crosses an instant at which outputs are read")
            }
        }
    }
}
