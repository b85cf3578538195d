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

type Cache = VecDeque<(Shape, Arc<Pairs>)>;

static CACHE: Mutex<Cache> = Mutex::new(VecDeque::new());

/// The modes of a shape in its basis; `None` if they cannot be computed to working accuracy.
pub fn modes(shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    modes_in(&CACHE, shape, basis)
}

fn modes_in(cache: &Mutex<Cache>, shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    // Never waits for the lock: after a fork it may never be released.
    let cached = cache.try_lock().ok().and_then(|mut cache| {
        let place = cache.iter().position(|(cached, _)| *cached == shape)?;
        cache.remove(place).map(|(_, pairs)| pairs)
    });
    // Computed without the lock, which others may need meanwhile.
    let pairs = match cached {
        Some(pairs) => pairs,
        None => Arc::new(pencil::solve(&shape.0, basis)?),
    };
    if let Ok(mut cache) = cache.try_lock() {
        cache.retain(|(known, _)| *known != shape);
        cache.push_back((shape, pairs.clone()));
        while cache.len() > CAPACITY {
            cache.pop_front();
        }
    }
    Some(pairs)
}

/// Empties the cache: a library that is unloaded leaves nothing behind.
pub fn forget() {
    if let Ok(mut cache) = CACHE.try_lock() {
        *cache = VecDeque::new();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::sections::Segment;

    #[test]
    fn equal_shapes_share_their_modes_and_the_least_difference_does_not() {
        // A cache of its own, because other tests use the process's.
        let cache = Mutex::new(Cache::new());
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
}
