//! A cache with a budget, used for the free modes of body shapes among others.
//!
//! A dense solver takes O(N^3), a sweep over a load has the same bodies in every run, and piston and bit often have
//! the same shape. The modes of a shape are therefore computed once per process and cached. The same numbers give the
//! same bits, so results do not depend on the cache.

use crate::bodies::pencil::{self, Pairs};
use crate::bodies::spline::Basis;
use crate::quantities::sections::Sections;
use std::sync::{Arc, Mutex};

/// Sections, degree of the splines, spans.
pub type Shape = (Sections, usize, usize);

/// Number of shapes in the cache, most recently used: those of some scenes, with two bodies each.
const CAPACITY: usize = 16;

static MODES: Recent<Shape, Arc<Pairs>> = Recent::new(CAPACITY, 1, |_| 1);

/// The modes of a shape in its basis; `None` if they cannot be computed to working accuracy.
pub fn modes(shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    MODES.find(shape, |shape| pencil::solve(&shape.0, basis).map(Arc::new).ok_or(())).ok()
}

/// Empties the cache, so that a library that is unloaded leaves nothing behind.
pub fn forget() {
    MODES.forget();
}

/// Values of the most recently used keys.
#[derive(Debug)]
pub(crate) struct Recent<K, T> {
    /// Keys and values, the oldest first.
    known: Mutex<Vec<(K, T)>>,
    /// Total size beyond which the oldest values are dropped, and the number of values that always stay.
    most: usize,
    least: usize,
    size: fn(&T) -> usize,
}

impl<K: PartialEq, T: Clone> Recent<K, T> {
    pub(crate) const fn new(most: usize, least: usize, size: fn(&T) -> usize) -> Self {
        Self { known: Mutex::new(Vec::new()), most, least, size }
    }

    /// The value of a key: cached, or made now.
    ///
    /// # Errors
    /// As `make`.
    pub(crate) fn find<E>(&self, key: K, make: impl FnOnce(&K) -> Result<T, E>) -> Result<T, E> {
        // Never waits for the lock: after a fork it may never be released.
        if let Some(value) =
            self.known.try_lock().ok().and_then(|mut known| renew(&mut known, &key))
        {
            return Ok(value);
        }
        // Made without the lock, which other threads may need meanwhile.
        let value = make(&key)?;
        let Ok(mut known) = self.known.try_lock() else { return Ok(value) };
        // Another thread may have made it meanwhile.
        if let Some(value) = renew(&mut known, &key) {
            return Ok(value);
        }
        known.push((key, value.clone()));
        let total =
            |known: &[(K, T)]| known.iter().map(|(_, value)| (self.size)(value)).sum::<usize>();
        while known.len() > self.least && total(&known) > self.most {
            known.remove(0);
        }
        Ok(value)
    }

    /// Drops the values of the other keys.
    pub(crate) fn retain(&mut self, stays: impl Fn(&K) -> bool) {
        if let Ok(known) = self.known.get_mut() {
            known.retain(|(key, _)| stays(key));
        }
    }

    pub(crate) fn forget(&self) {
        if let Ok(mut known) = self.known.try_lock() {
            *known = Vec::new();
        }
    }
}

/// The cached value of a key, which becomes the newest.
fn renew<K: PartialEq, T: Clone>(known: &mut [(K, T)], key: &K) -> Option<T> {
    let place = known.iter().rposition(|(other, _)| other == key)?;
    known[place..].rotate_left(1);
    known.last().map(|(_, value)| value.clone())
}

impl<K: Clone, T: Clone> Clone for Recent<K, T> {
    fn clone(&self) -> Self {
        let known = self.known.try_lock().map_or_else(|_| Vec::new(), |known| known.clone());
        Self { known: Mutex::new(known), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a number was cached; it is cached now.
    fn held(known: &Recent<usize, usize>, key: usize) -> bool {
        let mut made = false;
        let make = |key: &usize| {
            made = true;
            Ok::<_, ()>(*key)
        };
        assert_eq!(known.find(key, make), Ok(key));
        !made
    }

    #[test]
    fn the_oldest_go_until_the_rest_fit_but_the_least_number_stays() {
        let known = Recent::new(10, 1, |size: &usize| *size);
        let held_of_one = |key| held(&known, key);
        assert!([4, 5, 4].map(held_of_one) == [false, false, true]);
        // 4 is newer than 5, so it is 5 that makes room for 6.
        assert!([6, 4, 5].map(held_of_one) == [false, true, false]);
        assert!([20, 20, 4].map(held_of_one) == [false, true, false]);
        assert_eq!(known.find(7, |_| Err(0)), Err(0));
        let known = Recent::new(10, 2, |size: &usize| *size);
        let found = [20, 30, 20, 30, 1, 20].map(|key| held(&known, key));
        assert!(found == [false, false, true, true, false, false], "{found:?}");
    }

    /// A locked cache is not waited for. After a fork, the lock of another thread of the parent is never released.
    #[test]
    fn what_is_locked_is_not_waited_for() {
        let known = Recent::new(10, 1, |size: &usize| *size);
        assert!(!held(&known, 4));
        let locked = known.known.lock().expect("a lock");
        let made = std::thread::scope(|scope| {
            scope.spawn(|| [4, 4].map(|key| held(&known, key))).join().expect("two values")
        });
        drop(locked);
        assert!(made == [false, false] && held(&known, 4), "each is its own; found again");
    }
}
