//! Cache of the free modes of body shapes.
//!
//! A dense solver takes O(N^3), a sweep over a load has the same bodies in every run, and piston
//! and bit often have one shape. So the modes of a shape are computed once per process and cached.
//! The same numbers give the same bits, so results do not depend on the cache.

use crate::bodies::pencil::{self, Pairs};
use crate::bodies::spline::Basis;
use crate::quantities::sections::Sections;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Sections, degree of the splines, spans.
pub type Shape = (Sections, usize, usize);

/// Shapes in the cache, the most recently used ones: those of some scenes, with two bodies each.
const CAPACITY: usize = 16;

static MODES: Recent<Shape, Pairs> = Recent::new(CAPACITY, |_| 1);

/// The modes of a shape in its basis; `None` if they cannot be computed to working accuracy.
pub fn modes(shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    modes_in(&MODES, shape, basis)
}

fn modes_in(known: &Recent<Shape, Pairs>, shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    known.find(shape, |shape| pencil::solve(&shape.0, basis))
}

/// Empties the cache: a library that is unloaded leaves nothing behind.
pub fn forget() {
    MODES.forget();
}

/// What was made of the most recently used keys.
pub(crate) struct Recent<K, T> {
    known: Mutex<VecDeque<(K, Arc<T>)>>,
    /// Of how large values together the oldest go, but for the last.
    most: usize,
    size: fn(&T) -> usize,
}

impl<K: PartialEq, T> Recent<K, T> {
    pub(crate) const fn new(most: usize, size: fn(&T) -> usize) -> Self {
        Self { known: Mutex::new(VecDeque::new()), most, size }
    }

    /// That of a key: known, or made now; none if it cannot be made.
    pub(crate) fn find(&self, key: K, make: impl FnOnce(&K) -> Option<T>) -> Option<Arc<T>> {
        // Never waits for the lock: after a fork it may never be released.
        let found = self.known.try_lock().ok().and_then(|mut known| {
            let place = known.iter().position(|(other, _)| *other == key)?;
            known.remove(place).map(|(_, value)| value)
        });
        // Made without the lock, which others may need meanwhile.
        let value = match found {
            Some(value) => value,
            None => Arc::new(make(&key)?),
        };
        if let Ok(mut known) = self.known.try_lock() {
            known.retain(|(other, _)| *other != key);
            known.push_back((key, value.clone()));
            let mut size: usize = known.iter().map(|(_, value)| (self.size)(value)).sum();
            while size > self.most && known.len() > 1 {
                size -= known.pop_front().map_or(0, |(_, oldest)| (self.size)(&oldest));
            }
        }
        Some(value)
    }

    pub(crate) fn forget(&self) {
        if let Ok(mut known) = self.known.try_lock() {
            *known = VecDeque::new();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::sections::Segment;

    #[test]
    fn equal_shapes_share_their_modes_and_the_least_difference_does_not() {
        // A cache of its own, because other tests use the process's.
        let cache = Recent::new(CAPACITY, |_| 1);
        let modes_of = |area: f64, degree: usize| {
            let part = |area| Segment { length: 0.2, area };
            let sections = Sections::new(&[part(area), part(3e-3)]).expect("two sections");
            let basis = Basis::new(&sections, degree, 6);
            let pairs = modes_in(&cache, (sections, degree, 6), &basis).expect("modes");
            assert_eq!(*pairs, pencil::solve(&sections, &basis).expect("modes"));
            pairs
        };
        let one = modes_of(2e-3, 2);
        assert!(Arc::ptr_eq(&one, &modes_of(2e-3, 2)));
        assert!(!Arc::ptr_eq(&one, &modes_of(2e-3f64.next_up(), 2)));
        assert!(!Arc::ptr_eq(&one, &modes_of(2e-3, 3)));
        for i in 0..2 * CAPACITY {
            modes_of(1e-3 + 1e-5 * i as f64, 2);
        }
        assert!(!Arc::ptr_eq(&one, &modes_of(2e-3, 2)), "the oldest goes first");
    }

    #[test]
    fn the_oldest_go_until_the_rest_fit_but_the_last_stays() {
        let known = Recent::new(10, |size: &usize| *size);
        let held = |key: usize| {
            let mut made = false;
            let make = |key: &usize| {
                made = true;
                Some(*key)
            };
            assert_eq!(known.find(key, make).as_deref(), Some(&key));
            !made
        };
        assert!([4, 5, 4].map(held) == [false, false, true]);
        // Beside 4, which is newer than 5, there is room for 6.
        assert!([6, 4, 5].map(held) == [false, true, false]);
        assert!([20, 20, 4].map(held) == [false, true, false]);
        assert_eq!(known.find(7, |_| None), None);
    }
}
