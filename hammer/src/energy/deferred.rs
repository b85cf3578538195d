//! The deferred ledger: works and losses are integrated only when an energy is read.
//!
//! The integrals over an interval follow from the states at its two ends. These states are stored until an energy is
//! read, or until they take too much memory. The integrals are then added one by one in order of time, so that reading
//! an energy never changes a later value, not even in the last binary digit.

use super::interval::{self, Forms, Interval, Sums};
use super::ledger::Ledger;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// An interval whose integrals are not yet added to the ledger. Each interval refers to the one before it, so that a
/// snapshot shares this linked list instead of copying it.
pub(crate) struct Deferred {
    pub interval: Interval,
    sums: OnceLock<Sums>,
    /// Sums between the previous interval and this one that were known immediately.
    known: Vec<Sums>,
    before: Option<Arc<Deferred>>,
}

impl Deferred {
    /// The integrals over the interval. `forms` are the damping forms at the end of the previous interval.
    fn sums<'a>(&'a self, forms: &mut Forms<'a>) -> &'a Sums {
        self.sums.get_or_init(|| self.interval.sums(forms))
    }
}

/// Drops the list in a loop, since recursion would overflow the stack on a long one.
impl Drop for Deferred {
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(mut deferred) = next {
            next = Arc::get_mut(&mut deferred).and_then(|deferred| deferred.before.take());
        }
    }
}

/// The ledger up to the epoch: an evaluated part and a pending one. Serialising it evaluates it.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(from = "Ledger", into = "Ledger")]
pub(crate) struct DeferredLedger {
    evaluated: Ledger,
    last: Option<Arc<Deferred>>,
    /// Sums after the last interval that were known immediately.
    known: Vec<Sums>,
    /// How many numbers are stored.
    pub size: usize,
}

impl From<Ledger> for DeferredLedger {
    fn from(evaluated: Ledger) -> Self {
        Self { evaluated, ..Self::default() }
    }
}

impl From<DeferredLedger> for Ledger {
    fn from(deferred: DeferredLedger) -> Self {
        deferred.evaluated()
    }
}

/// Shows this interval without those before it.
impl fmt::Debug for Deferred {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.interval.fmt(f)
    }
}

/// Shows the evaluated ledger. Showing the list by recursion would overflow the stack.
impl fmt::Debug for DeferredLedger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.evaluated().fmt(f)
    }
}

impl PartialEq for DeferredLedger {
    fn eq(&self, other: &Self) -> bool {
        self.evaluated() == other.evaluated()
    }
}

impl DeferredLedger {
    /// Adds an interval that is not yet integrated. `make` constructs it in place, because it is too large to move.
    pub fn defer(&mut self, make: impl FnOnce() -> Interval) -> &Arc<Deferred> {
        let (known, before) = (std::mem::take(&mut self.known), self.last.take());
        let deferred = Deferred { interval: make(), sums: OnceLock::new(), known, before };
        let last = self.last.insert(Arc::new(deferred));
        self.size += last.interval.size();
        last
    }

    /// Evaluates all pending integrals if they take too much memory. Finished integrals survive an interrupt.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn work_off(&mut self) -> Result<(), Error> {
        if self.size <= interval::storable() {
            return Ok(());
        }
        self.prepare()?;
        self.settle();
        Ok(())
    }

    /// Computes all pending integrals. Finished integrals survive an interrupt.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare(&self) -> Result<(), Error> {
        let mut forms = Forms::default();
        for pending in self.pending() {
            pending.interval.prepare()?;
            pending.sums(&mut forms);
            Error::if_interrupted()?;
        }
        Ok(())
    }

    /// Adds integrals that are known already.
    pub fn add(&mut self, sums: Sums) {
        self.known.push(sums);
    }

    /// The pending intervals in order of time.
    fn pending(&self) -> Vec<&Deferred> {
        let backwards = std::iter::successors(self.last.as_deref(), |it| it.before.as_deref());
        let mut list: Vec<_> = backwards.collect();
        list.reverse();
        list
    }

    /// The ledger with all pending integrals added.
    pub fn evaluated(&self) -> Ledger {
        let (mut ledger, mut forms) = (self.evaluated.clone(), Forms::default());
        for pending in self.pending() {
            pending.known.iter().for_each(|sums| ledger.sums.add(sums));
            ledger.sums.add(pending.sums(&mut forms));
        }
        self.known.iter().for_each(|sums| ledger.sums.add(sums));
        ledger
    }

    /// Evaluates all pending integrals, so that none is left.
    pub fn settle(&mut self) {
        *self = self.evaluated().into();
    }
}
