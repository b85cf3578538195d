//! The work that one call may do.
//!
//! Work is counted in processed modal coordinates, not in time. Whether a call is refused therefore does not depend on
//! the processor or its load. Decompositions are not counted, since another scene may have cached them. The table of
//! parameters limits their number and size.

use std::cell::Cell;

/// Largest number of coordinates that a core processes in a second.
pub(crate) const PER_SECOND: u64 = 625_000_000;

thread_local! {
    /// Coordinates that the present call may still process.
    static LEFT: Cell<Option<u64>> = const { Cell::new(None) };
}

/// The work that a call may do, in coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowance(u64);

impl Allowance {
    /// An allowance for about this many seconds on one core.
    pub fn of_seconds(seconds: usize) -> Self {
        Self(PER_SECOND.saturating_mul(seconds as u64))
    }

    /// The work that the present call may still do.
    pub fn left() -> Self {
        Self(LEFT.get().unwrap_or(u64::MAX))
    }

    /// An equal share for each of this many pieces of work, which may run on other threads.
    pub fn shared(self, pieces: usize) -> Self {
        Self(self.0 / pieces.max(1) as u64)
    }

    /// Does `work` with this allowance, or with that of the enclosing call if less is left of that. The work is charged
    /// to the enclosing call.
    pub fn within<T>(self, work: impl FnOnce() -> T) -> T {
        let (outer, granted) = (LEFT.get(), self.0.min(Self::left().0));
        LEFT.set(Some(granted));
        let _charge = Charge { outer, granted };
        work()
    }

    /// Takes coordinates from the present call's allowance. Returns false if fewer are left. Outside any call there is
    /// no limit.
    pub fn spend(coordinates: u64) -> bool {
        let Some(left) = LEFT.get() else { return true };
        LEFT.set(Some(left.saturating_sub(coordinates)));
        coordinates <= left
    }
}

/// Charges the work of an inner call to the outer one when it is dropped, even after a panic.
struct Charge {
    outer: Option<u64>,
    granted: u64,
}

impl Drop for Charge {
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
