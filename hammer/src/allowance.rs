//! The work that one call may do.
//!
//! It is counted in modal coordinates that are handled, never in time: whether a call is refused does
//! not depend on the processor, nor on what else that is doing. Decompositions are not counted, since
//! other scenes may have made them before; their number and size are limited by the table.

use std::cell::Cell;

/// Coordinates that a core handles in a second at most.
pub(crate) const PER_SECOND: u64 = 625_000_000;

thread_local! {
    /// Coordinates that the present call may still handle.
    static LEFT: Cell<Option<u64>> = const { Cell::new(None) };
}

/// Work that a call may do, in coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowance(u64);

impl Allowance {
    /// About so many seconds on one core.
    pub fn of_seconds(seconds: usize) -> Self {
        Self(PER_SECOND.saturating_mul(seconds as u64))
    }

    /// What the present call may still do.
    pub fn left() -> Self {
        Self(LEFT.get().unwrap_or(u64::MAX))
    }

    /// An equal part of it for each of so many pieces of work, in threads of their own perhaps.
    pub fn shared(self, pieces: usize) -> Self {
        Self(self.0 / pieces.max(1) as u64)
    }

    /// Does `work`, which may use this much, but no more than is left to a call that it is a part of;
    /// what it uses is taken from that.
    pub fn within<T>(self, work: impl FnOnce() -> T) -> T {
        let (outer, granted) = (LEFT.get(), self.0.min(Self::left().0));
        LEFT.set(Some(granted));
        let _after = After { outer, granted };
        work()
    }

    /// Takes so many coordinates from what is left; false if it was less. Outside any call there is
    /// no limit.
    pub fn spend(coordinates: u64) -> bool {
        let Some(left) = LEFT.get() else { return true };
        LEFT.set(Some(left.saturating_sub(coordinates)));
        coordinates <= left
    }
}

/// Charges the outer call with what the inner one used, also where that panics.
struct After {
    outer: Option<u64>,
    granted: u64,
}

impl Drop for After {
    fn drop(&mut self) {
        let used = self.granted - LEFT.get().unwrap_or_default();
        LEFT.set(self.outer.map(|left| left.saturating_sub(used)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_part_uses_is_taken_from_the_whole_and_is_no_more_than_that() {
        assert!(Allowance::spend(u64::MAX), "no call, no limit");
        Allowance(100).within(|| {
            assert!(Allowance(1000).within(|| Allowance::spend(30)));
            assert_eq!(Allowance::left().0, 70);
            assert_eq!(Allowance::left().shared(7).0, 10);
            assert!(!Allowance(10).within(|| Allowance::spend(11)), "its own limit");
            assert_eq!(Allowance::left().0, 60, "it used the ten that it had");
            assert!(!Allowance(1000).within(|| Allowance::spend(61)), "the whole's limit");
            assert!(!Allowance::spend(1));
        });
        assert!(Allowance::spend(u64::MAX), "the call is over");
    }
}
