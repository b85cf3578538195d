//! Energy ledger of a run.

use super::Run;
use crate::law::{Rock, State};
use crate::linear::Real;
use crate::record::Energies;

impl<T: Real> Run<T> {
    pub(super) fn stored(&self) -> T {
        let parts = self.model.stored(self.mode, &self.memory, &self.place.state);
        parts.iter().fold(T::default(), |sum, &part| sum + part)
    }

    /// Gravity's work since `u = 0`, J.
    pub(super) fn fallen(&self, state: &State<T>) -> T {
        let pairs = self.model.weight.iter().zip(&state.u);
        pairs.fold(T::default(), |sum, (&w, &u)| sum + w * u)
    }

    /// Sums up the losses of a mode or tuning that ends.
    pub(super) fn leave(&mut self) {
        let [rock, viscous] = self.losses(&self.place.state);
        self.lost[0] = self.lost[0] + rock;
        self.lost[1] = self.lost[1] + viscous;
    }

    /// Energy dissipated on the loading line and in the dashpot since the mode or tuning began.
    pub(super) fn losses(&self, state: &State<T>) -> [T; 2] {
        let law = &self.model.scene.rock;
        let [from, psi] = self.entered;
        let one = T::from(1.0);
        let rock = match self.mode.rock {
            Rock::DFC | Rock::FC => {
                let to = state.u[self.model.tip];
                let factor =
                    T::from(0.5) * (one - one / T::from(law.ratio)) * T::from(law.stiffness);
                factor * (to - from) * (to + from - self.memory.ul - self.memory.ul)
            }
            _ => T::default(),
        };
        [rock, state.psi - psi]
    }

    pub(super) fn energies(&self) -> Energies<T> {
        let state = &self.place.state;
        let [rock, viscous] = self.losses(state);
        let stored = self.model.stored(self.mode, &self.memory, state);
        let mut sums = Energies {
            drive: self.place.works.drive,
            gravity: self.fallen(state) - self.start[1],
            feed: self.place.works.feed,
            stored,
            rock: self.lost[0] + rock,
            viscous: self.lost[1] + viscous,
            damping: T::default(),
            retuned: self.lost[2],
        };
        let held = stored.iter().fold(-self.start[0], |sum, &part| sum + part);
        let given = sums.drive + sums.gravity + sums.feed + sums.retuned;
        sums.damping = given - held - sums.rock - sums.viscous;
        sums
    }
}
