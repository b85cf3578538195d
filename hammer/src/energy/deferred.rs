//! The deferred ledger: works and losses are integrated only when an energy is read.
//!
//! The integrals over a stretch follow from the state at both its ends. These states are stored,
//! and integrated on demand or when they take too much memory. The integrals are added one by one
//! in order of time, so that reading an energy changes no bit of a later one.

use super::ledger::Ledger;
use super::pending::{self, Forms, PendingIntegrals};
use super::sums::Sums;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// Something to be added to the sums.
enum Term {
    Pending(Arc<PendingIntegrals>, OnceLock<Sums>),
    Known(Sums),
}

/// A linked list, so that a snapshot shares it instead of copying it.
struct Link {
    term: Term,
    before: Option<Arc<Link>>,
}

impl Link {
    /// What is to be added; `forms` are those at the end of the stretch before.
    fn sums<'a>(&'a self, forms: &mut Forms<'a>) -> &'a Sums {
        match &self.term {
            Term::Pending(pending, sums) => sums.get_or_init(|| pending.sums(forms)),
            Term::Known(sums) => sums,
        }
    }
}

/// A loop: recursion would overflow the stack on a long list.
impl Drop for Link {
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(mut link) = next.and_then(Arc::into_inner) {
            next = link.before.take();
        }
    }
}

/// The ledger up to the epoch: what is evaluated, and what is pending. It is serialised evaluated.
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

/// As it is serialised: a long list must not be printed by recursion either.
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
    /// Adds a stretch, not yet integrated.
    pub fn defer(&mut self, pending: Arc<PendingIntegrals>) {
        self.size += pending.size();
        self.push(Term::Pending(pending, OnceLock::new()));
    }

    /// Evaluates if much is pending, or `all` of it. What is integrated when an interrupt comes is kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn work_off(&mut self, all: bool) -> Result<(), Error> {
        if self.size <= pending::allowance() && !all {
            return Ok(());
        }
        self.prepare()?;
        self.settle();
        Ok(())
    }

    /// Integrates all that is pending. What is integrated when an interrupt comes is kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn prepare(&self) -> Result<(), Error> {
        let mut forms = Forms::default();
        for link in self.links() {
            if let Term::Pending(pending, _) = &link.term {
                pending.prepare()?;
            }
            link.sums(&mut forms);
            Error::if_interrupted()?;
        }
        Ok(())
    }

    /// Adds integrals that are known already.
    pub fn add(&mut self, sums: Sums) {
        self.push(Term::Known(sums));
    }

    fn push(&mut self, term: Term) {
        self.last = Some(Arc::new(Link { term, before: self.last.take() }));
    }

    /// What is to be added, in order of time.
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
