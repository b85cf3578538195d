//! A cache of limited size, used for the free modes of body shapes and other results.
//!
//! A dense solver takes O(N^3) operations. The runs of a sweep over a load have the same bodies, and piston and bit
//! often have the same shape. The modes of a shape are therefore computed once per process and cached. A cached result
//! equals a new one to the last binary digit, so the cache does not affect results.

use crate::bodies::pencil::{self, Pairs};
use crate::bodies::spline::Basis;
use crate::quantities::sections::Sections;
use std::sync::{Arc, Mutex};

/// The shape on which the modes depend: the sections, the degree of the splines and the number of spans.
pub type Shape = (Sections, usize, usize);

/// Number of shapes in the cache, enough for several scenes with two bodies each.
const CAPACITY: usize = 16;

static MODES: Recent<Shape, Arc<Pairs>> = Recent::new(CAPACITY, 1, |_| 1);

/// The modes of a shape in its basis; `None` if they cannot be computed to working accuracy.
pub fn modes(shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    MODES.find(shape, |shape| pencil::solve(&shape.0, basis).map(Arc::new).ok_or(())).ok()
}

/// Empties the cache, so that a library leaves nothing behind when it is unloaded.
pub fn forget() {
    MODES.forget();
}

/// A cache of the values of the most recently used keys.
#[derive(Debug)]
pub(crate) struct Recent<K, T> {
    /// Keys and values, least recently used first.
    known: Mutex<Vec<(K, T)>>,
    /// If the total size exceeds `most`, the oldest values are dropped, but at least `least` values stay.
    most: usize,
    least: usize,
    size: fn(&T) -> usize,
}

impl<K: PartialEq, T: Clone> Recent<K, T> {
    pub(crate) const fn new(most: usize, least: usize, size: fn(&T) -> usize) -> Self {
        Self { known: Mutex::new(Vec::new()), most, least, size }
    }

    /// The value of a key: from the cache, or else from `make`.
    ///
    /// # Errors
    /// Those of `make`.
    pub(crate) fn find<E>(&self, key: K, make: impl FnOnce(&K) -> Result<T, E>) -> Result<T, E> {
        // This never waits for the lock, because after a fork nobody may ever release it.
        if let Some(value) =
            self.known.try_lock().ok().and_then(|mut known| renew(&mut known, &key))
        {
            return Ok(value);
        }
        // The lock is not held while the value is made, since other threads may need it.
        let value = make(&key)?;
        let Ok(mut known) = self.known.try_lock() else { return Ok(value) };
        // Another thread may have made the same value meanwhile.
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

    /// Drops the values of all keys for which `stays` is false.
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

/// The cached value of a key, which becomes the most recently used one.
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

    /// True if a number was cached already. Afterwards it is cached.
    fn was_cached(known: &Recent<usize, usize>, key: usize) -> bool {
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
        let cache = Recent::new(10, 1, |size: &usize| *size);
        let with_one = |key| was_cached(&cache, key);
        assert!([4, 5, 4].map(with_one) == [false, false, true]);
        // 4 was used after 5, so 5 is dropped to make room for 6.
        assert!([6, 4, 5].map(with_one) == [false, true, false]);
        assert!([20, 20, 4].map(with_one) == [false, true, false]);
        assert_eq!(cache.find(7, |_| Err(0)), Err(0));
        let cache = Recent::new(10, 2, |size: &usize| *size);
        let cached = [20, 30, 20, 30, 1, 20].map(|key| was_cached(&cache, key));
        assert!(cached == [false, false, true, true, false, false], "{cached:?}");
    }

    /// A locked cache is not waited for. After a fork, the lock of another thread of the parent is never released.
    #[test]
    fn what_is_locked_is_not_waited_for() {
        let cache = Recent::new(10, 1, |size: &usize| *size);
        assert!(!was_cached(&cache, 4));
        let lock = cache.known.lock().expect("a lock");
        let cached = std::thread::scope(|scope| {
            scope.spawn(|| [4, 4].map(|key| was_cached(&cache, key))).join().expect("two values")
        });
        drop(lock);
        assert!(cached == [false, false] && was_cached(&cache, 4), "each is its own; found again");
    }
}
