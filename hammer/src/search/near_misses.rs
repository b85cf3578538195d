//! Near misses (grazing contacts): excursions of a guard that come near zero and turn back.

/// A guard this many resolutions from zero is near it.
pub(crate) const NEAR: f64 = 4.0;
/// A guard that comes as near as this many resolutions is counted as a near miss.
pub(crate) const NOTICED: f64 = 2.0;

/// Near misses of one guard so far, and where the search stands.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearMisses {
    /// Those that turned back: since when they were seen near zero, and when they were away again.
    turned: Vec<[f64; 2]>,
    now: Now,
}

/// Where the search stands; can be returned to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Now {
    turned: usize,
    /// Since when the guard is near zero.
    near: Option<f64>,
    /// True once the guard has been away from zero.
    away: bool,
}

impl NearMisses {
    /// The guard has this value at `t`, in resolutions.
    pub fn observe(&mut self, value: f64, t: f64) {
        if value < -NEAR {
            self.leave(t);
        } else if self.now.near.is_none() {
            self.now.near = Some(t);
        }
    }

    /// From `t` on the guard is away from zero: what was near has turned back.
    #[inline]
    pub fn leave(&mut self, t: f64) {
        if let Some(since) = self.now.near.take().filter(|_| self.now.away) {
            self.turned.push([since, t]);
            self.now.turned = self.turned.len();
        }
        self.now.away = true;
    }

    /// The guard has come to rest near zero: that is no excursion.
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

    /// Where the search stands.
    pub fn now(&self) -> Now {
        self.now
    }

    /// Forgets what was seen since.
    pub fn return_to(&mut self, now: Now) {
        self.turned.truncate(now.turned);
        self.now = now;
    }

    /// How many turned back up to `t`.
    pub fn turned(&self, t: f64) -> u64 {
        self.turned.iter().filter(|[_, back]| *back <= t).count() as u64
    }

    /// How many began up to `t`, one that is under way included.
    pub fn begun(&self, t: f64) -> u64 {
        let pending = self.now.near.filter(|_| self.now.away);
        let begun = self.turned.iter().map(|[since, _]| *since).chain(pending);
        begun.filter(|since| *since <= t).count() as u64
    }
}
