//! Completes a blow's record with works, largest forces and the rebound.

use super::Machine;
use super::blows::{Account, Blow, MAX_STEP_BLOWS, Progress};
use crate::energy::deferred::DeferredLedger;
use crate::energy::interval::Sums;
use crate::energy::ledger::Energies;
use crate::energy::peaks::PeakSearch;
use crate::error::Error;
use crate::motion::Motion;
use serde::{Deserialize, Serialize};

/// Observer that completes the record of each blow at its instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Recorder {
    rebound_speed: f64,
    /// Largest forces since the last blow.
    pub peaks: PeakSearch,
    /// Sums up to the last blow.
    before: Sums,
    /// True from a blow until its record is complete.
    due: bool,
    /// Blows that were not taken yet, at most [`MAX_STEP_BLOWS`], if they are collected.
    pub collected: Option<Vec<Blow>>,
}

impl Recorder {
    /// A recorder that starts now. `sums` are the sums up to now.
    pub fn new(motion: &Motion, sums: Sums) -> Self {
        let mut peaks = PeakSearch::default();
        peaks.begin_step(motion);
        Self { rebound_speed: 0.0, peaks, before: sums, due: false, collected: None }
    }

    /// Records that the contact opens at the epoch.
    pub fn note_opening(&mut self, motion: &Motion) {
        let [_, velocity] = motion.piston_in_hole(0.0);
        self.rebound_speed = -velocity;
    }

    /// Records that there is a blow at the epoch. The record is completed after the transition, because that takes time
    /// and may fail.
    pub fn note_blow(&mut self) {
        self.due = true;
    }

    /// Completes the record of a blow at the epoch. If an interrupt ends it, the next call starts again.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::Overwork`] if the forces ring too long between two blows.
    pub fn complete(
        &mut self,
        motion: &Motion,
        ledger: &mut DeferredLedger,
        blows: &mut Progress,
    ) -> Result<(), Error> {
        if !self.due {
            return Ok(());
        }
        ledger.prepare()?;
        let searched = self.peaks.recorded();
        Error::if_interrupted()?;
        let peaks = searched.outcome(motion)?;
        ledger.settle();
        let sums = ledger.evaluated().sums;
        let [now, before] = [&sums, &self.before].map(Energies::of_sums);
        blows.note_account(Account {
            rebound_speed: self.rebound_speed,
            peaks,
            drive: now.drive - before.drive,
            gravity: now.gravity - before.gravity,
            feed: now.feed - before.feed,
            rock_dissipated: now.rock_dissipated - before.rock_dissipated,
            viscous: now.viscous - before.viscous,
            damping: now.damping - before.damping,
        });
        let collected = self.collected.iter_mut().filter(|list| list.len() < MAX_STEP_BLOWS);
        collected.for_each(|list| list.push(blows.last));
        (self.peaks, self.before, self.due) = (PeakSearch::default(), sums, false);
        Ok(())
    }
}

impl Machine {
    /// From now on, records forces, works and the rebound of each blow ([`Blow::account`]). They are then integrated at
    /// each blow, and not only when they are read.
    pub fn record_blows(&mut self) {
        if self.history.recorder.is_none() {
            let ledger = self.history.ledger.evaluated();
            let sums = ledger.sums_now(&self.motion, &self.motion.present());
            self.history.recorder = Some(Recorder::new(&self.motion, sums));
        }
    }

    /// Returns the blows since the last call, over any number of steps. The first call starts recording and collecting
    /// them. A restored state has its own list.
    pub fn take_blows(&mut self) -> Vec<Blow> {
        self.record_blows();
        let recorder = self.history.recorder.as_mut();
        let list = recorder.map(|recorder| recorder.collected.get_or_insert_default());
        list.map(std::mem::take).unwrap_or_default()
    }
}
