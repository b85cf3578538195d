//! Counters, and a journal of transitions.

use super::Machine;
use crate::laws::event::Event;
use crate::laws::mode::Mode;
use serde::{Deserialize, Serialize};

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Counters {
    /// Collisions. Closings within `2 (T1 + T2)` of the last opening belong to the same collision.
    pub contacts: u64,
    /// Blows. The first collision in each fall of the piston is a blow if it is fast enough.
    pub blows: u64,
    /// Drilling cycles that have begun (entries into DFC).
    pub rock_cycles: u64,
    /// Mode transitions.
    pub events: u64,
    /// Changes of the modal basis (a measure of the integrator's work).
    pub basis_changes: u64,
    /// Evaluations of a guard.
    pub guard_evaluations: u64,
    /// Rotations of the modal state to another instant.
    pub samples: u64,
    /// Taylor windows opened by the search.
    pub windows: u64,
    /// Steps of the scans within these windows.
    #[serde(skip)]
    pub scans: u64,
}

impl Counters {
    /// True if a count is above `2^53`, which no run of centuries would reach.
    pub(crate) fn are_too_many(&self) -> bool {
        let Self { contacts, blows, rock_cycles, events, basis_changes, .. } = *self;
        let counts = [contacts, blows, rock_cycles, events, basis_changes];
        counts.into_iter().any(|count| count > 1 << 53)
    }
}

/// A transition in the journal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Record {
    /// The instant of the transition, s.
    pub time: f64,
    /// The exact instant minus `time`, which is rounded, s.
    pub time_rest: f64,
    /// The event.
    pub event: Event,
    /// The mode that the transition leads to.
    pub mode: Mode,
}

impl Machine {
    /// Starts or stops recording a journal of transitions.
    pub fn keep_journal(&mut self, keep: bool) {
        self.journal = keep.then(Vec::new);
    }

    /// The transitions since the last call.
    pub fn take_journal(&mut self) -> Vec<Record> {
        self.journal.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Replaces the journal that is recorded, if any.
    pub(crate) fn exchange_journal(&mut self, other: Option<Vec<Record>>) -> Option<Vec<Record>> {
        std::mem::replace(&mut self.journal, other)
    }
}
