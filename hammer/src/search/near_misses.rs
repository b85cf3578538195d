//! Near misses (grazing contacts): a guard comes close to zero and turns back.

/// A guard within this many resolutions of zero is near it.
pub(crate) const NEAR: f64 = 4.0;
/// A guard that comes within this many resolutions of zero counts as a near miss.
pub(crate) const NOTICED: f64 = 2.0;

/// Near misses of one guard so far, and the state of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearMisses {
    /// Completed near misses: when each came near zero, and when it was away again.
    turned: Vec<[f64; 2]>,
    now: Now,
}

/// The state of the search, which can be restored.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Now {
    turned: usize,
    /// Since when the guard is near zero.
    near: Option<f64>,
    /// True once the guard has been away from zero.
    away: bool,
}

impl NearMisses {
    /// Reports the guard's value at `t`, in resolutions.
    pub fn observe(&mut self, value: f64, t: f64) {
        if value < -NEAR {
            self.leave(t);
        } else if self.now.near.is_none() {
            self.now.near = Some(t);
        }
    }

    /// From `t` on the guard is away from zero: a near miss is complete.
    #[inline]
    pub fn leave(&mut self, t: f64) {
        if let Some(since) = self.now.near.take().filter(|_| self.now.away) {
            self.turned.push([since, t]);
            self.now.turned = self.turned.len();
        }
        self.now.away = true;
    }

    /// The guard has come to rest near zero, which is no near miss.
    pub fn rest(&mut self) {
        self.now.near = None;
    }

    /// True while the guard is near zero.
    pub fn is_near(&self) -> bool {
        self.now.near.is_some()
    }

    /// True once the guard has been away from zero.
    pub fn was_away(&self) -> bool {
        self.now.away
    }

    /// The state of the search.
    pub fn now(&self) -> Now {
        self.now
    }

    /// Restores a state of the search.
    pub fn return_to(&mut self, now: Now) {
        self.turned.truncate(now.turned);
        self.now = now;
    }

    /// Near misses completed by `t`.
    pub fn turned(&self, t: f64) -> u64 {
        self.turned.iter().filter(|[_, back]| *back <= t).count() as u64
    }

    /// Near misses begun by `t`.
    pub fn begun(&self, t: f64) -> u64 {
        let pending = self.now.near.filter(|_| self.now.away);
        let begun = self.turned.iter().map(|[since, _]| *since).chain(pending);
        begun.filter(|since| *since <= t).count() as u64
    }
}
