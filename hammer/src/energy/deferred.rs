//! The deferred ledger: works and losses are integrated only when an energy is read.
//!
//! The integrals over an interval follow from the states at its two ends. These are stored until an energy is read,
//! or until they take too much memory. The integrals are then added one by one in order of time, so that reading an
//! energy changes no bit of a later one.

use super::interval::{self, Forms, Interval, Sums};
use super::ledger::Ledger;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// Contributions to the sums: a linked list, so that a snapshot shares it instead of copying it.
struct Link {
    /// None if the sums are known.
    interval: Option<Arc<Interval>>,
    sums: OnceLock<Sums>,
    before: Option<Arc<Link>>,
}

impl Link {
    /// The contribution. `forms` are those at the end of the previous interval.
    fn sums<'a>(&'a self, forms: &mut Forms<'a>) -> &'a Sums {
        let interval = self.interval.as_ref();
        self.sums.get_or_init(|| interval.map(|it| it.sums(forms)).unwrap_or_default())
    }
}

/// Drops in a loop, since recursion would overflow the stack on a long list.
impl Drop for Link {
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(mut link) = next.and_then(Arc::into_inner) {
            next = link.before.take();
        }
    }
}

/// The ledger up to the epoch: an evaluated part and a pending one. It is serialised evaluated.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(from = "Ledger", into = "Ledger")]
pub(crate) struct DeferredLedger {
    evaluated: Ledger,
    last: Option<Arc<Link>>,
    /// Numbers stored.
    pub size: usize,
}

impl From<Ledger> for DeferredLedger {
    fn from(evaluated: Ledger) -> Self {
        Self { evaluated, last: None, size: 0 }
    }
}

impl From<DeferredLedger> for Ledger {
    fn from(deferred: DeferredLedger) -> Self {
        deferred.evaluated()
    }
}

/// As serialised. Recursion would overflow the stack here too.
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
    /// Adds an interval, not yet integrated.
    pub fn defer(&mut self, interval: Arc<Interval>) {
        self.size += interval.size();
        self.push(Some(interval), OnceLock::new());
    }

    /// Evaluates everything pending if it is much. Integrals that are finished survive an interrupt.
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

    /// Integrates everything pending. Integrals that are finished survive an interrupt.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare(&self) -> Result<(), Error> {
        let mut forms = Forms::default();
        for link in self.links() {
            if let Some(interval) = &link.interval {
                interval.prepare()?;
            }
            link.sums(&mut forms);
            Error::if_interrupted()?;
        }
        Ok(())
    }

    /// Adds known integrals.
    pub fn add(&mut self, sums: Sums) {
        self.push(None, sums.into());
    }

    fn push(&mut self, interval: Option<Arc<Interval>>, sums: OnceLock<Sums>) {
        self.last = Some(Arc::new(Link { interval, sums, before: self.last.take() }));
    }

    /// The contributions in order of time.
    fn links(&self) -> Vec<&Link> {
        let mut links = Vec::new();
        let mut link = self.last.as_deref();
        while let Some(this) = link {
            links.push(this);
            link = this.before.as_deref();
        }
        links.reverse();
        links
    }

    /// The ledger with all pending integrals added.
    pub fn evaluated(&self) -> Ledger {
        let (mut ledger, mut forms) = (self.evaluated.clone(), Forms::default());
        for link in self.links() {
            ledger.sums.add(link.sums(&mut forms));
        }
        ledger
    }

    /// Evaluates all pending integrals.
    pub fn settle(&mut self) {
        *self = self.evaluated().into();
    }
}
