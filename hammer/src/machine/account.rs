//! Works and losses that are owed, not paid.
//!
//! The sums of a stretch follow from the state at both its ends. That is kept, and the sums
//! are made when somebody asks for an energy, or when too much is kept. They are added in order
//! of time, each on its own, so that they are the same to the last bit whoever asked, and when.

use super::ledger::Ledger;
use super::owed::Owed;
use super::sums::Sums;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// Numbers that may be kept before they are worked off: 8 MB.
const MOST: usize = 1 << 20;

/// Something to be added to the sums.
enum Due {
    Stretch(Arc<Owed>, OnceLock<Sums>),
    Known(Sums),
}

/// A chain, so that a snapshot of the state costs nothing however much is owed.
struct Link {
    due: Due,
    before: Option<Arc<Link>>,
}

impl Link {
    fn sums(&self) -> &Sums {
        match &self.due {
            Due::Stretch(owed, sums) => sums.get_or_init(|| owed.sums()),
            Due::Known(sums) => sums,
        }
    }
}

/// One by one: a long chain must not be dropped by recursion.
impl Drop for Link {
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(mut link) = next.and_then(Arc::into_inner) {
            next = link.before.take();
        }
    }
}

/// The ledger up to the epoch: what is paid, and what is owed since. Stored, it is paid.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(from = "Ledger", into = "Ledger")]
pub(crate) struct Account {
    paid: Ledger,
    last: Option<Arc<Link>>,
    /// Numbers kept.
    kept: usize,
}

impl From<Ledger> for Account {
    fn from(paid: Ledger) -> Self {
        Self { paid, last: None, kept: 0 }
    }
}

impl From<Account> for Ledger {
    fn from(account: Account) -> Self {
        account.paid()
    }
}

/// As it is stored: a long chain must not be shown by recursion either.
impl fmt::Debug for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.paid().fmt(f)
    }
}

impl PartialEq for Account {
    fn eq(&self, other: &Self) -> bool {
        self.paid() == other.paid()
    }
}

impl Account {
    /// Keeps a stretch.
    pub fn owe(&mut self, owed: Arc<Owed>) {
        self.kept += owed.size();
        self.push(Due::Stretch(owed, OnceLock::new()));
    }

    /// Pays if much is owed, or `all` of it. What is worked off when an interrupt comes is kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn work_off(&mut self, all: bool) -> Result<(), Error> {
        if self.kept <= MOST && !all {
            return Ok(());
        }
        for link in self.links() {
            if let Due::Stretch(owed, _) = &link.due {
                owed.prepare()?;
            }
            link.sums();
            Error::if_interrupted()?;
        }
        self.settle();
        Ok(())
    }

    /// Adds what is known already.
    pub fn add(&mut self, sums: Sums) {
        self.push(Due::Known(sums));
    }

    fn push(&mut self, due: Due) {
        self.last = Some(Arc::new(Link { due, before: self.last.take() }));
    }

    /// What is owed, in order of time.
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

    /// The ledger with all that is owed.
    pub fn paid(&self) -> Ledger {
        let mut ledger = self.paid.clone();
        for link in self.links() {
            ledger.sums.add(link.sums());
        }
        ledger
    }

    /// Pays.
    pub fn settle(&mut self) {
        *self = self.paid().into();
    }
}
