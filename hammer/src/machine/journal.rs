//! Counters, and a journal of transitions.

use crate::laws::event::Event;
use crate::laws::mode::Mode;
use serde::{Deserialize, Serialize};

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Collisions (closings within `2 (T1 + T2)` of the last opening belong to one).
    pub contacts: u64,
    /// Blows: the first collisions of the piston's falls that are fast enough.
    pub blows: u64,
    /// Drilling cycles begun (entries into DFC).
    pub rock_cycles: u64,
    /// Mode transitions.
    pub events: u64,
    /// Changes of basis (work done by the integrator).
    pub basis_changes: u64,
    /// Evaluations of a guard.
    pub guard_evaluations: u64,
    /// Rotations of the modal state.
    pub samples: u64,
    /// Taylor windows opened by the search.
    pub windows: u64,
    /// Steps of scans within windows.
    #[serde(skip)]
    pub scans: u64,
}

impl Counters {
    /// True beyond `2^53`, which no run of centuries would reach.
    pub(crate) fn are_too_many(&self) -> bool {
        let Self { contacts, blows, rock_cycles, events, basis_changes, .. } = *self;
        let most = [contacts, blows, rock_cycles, events, basis_changes];
        most.into_iter().any(|count| count > 1 << 53)
    }
}

/// A transition in the journal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// When, s.
    pub time: f64,
    /// The instant less `time`, s.
    pub time_rest: f64,
    /// The event.
    pub event: Event,
    /// The mode entered.
    pub mode: Mode,
}
