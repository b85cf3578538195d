//! Free modes that bodies of equal shape share.
//!
//! A dense solver takes O(N^3), and a sweep over a load has the same bodies in every run; piston
//! and bit are often one shape. So modes are made once per process and kept for the next body of
//! the very same sections; as the same numbers make the same bits, nobody can tell.

use crate::quantities::sections::Sections;
use crate::bodies::pencil::{self, Pairs};
use crate::bodies::spline::Basis;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Sections, degree of the splines, spans.
pub type Shape = (Sections, usize, usize);

/// Shapes that are kept, the last ones asked for: those of some scenes, each of two bodies.
const CAPACITY: usize = 16;

type Cache = VecDeque<(Shape, Arc<Pairs>)>;

static CACHE: Mutex<Cache> = Mutex::new(VecDeque::new());

/// The modes of a shape in its basis; `None` if they cannot be found to working accuracy.
pub fn modes(shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    modes_in(&CACHE, shape, basis)
}

fn modes_in(cache: &Mutex<Cache>, shape: Shape, basis: &Basis) -> Option<Arc<Pairs>> {
    // Nobody waits: after a fork the lock may never be released.
    let known = cache.try_lock().ok().and_then(|mut cache| {
        let place = cache.iter().position(|(known, _)| *known == shape)?;
        cache.remove(place).map(|(_, pairs)| pairs)
    });
    // Not under the lock: others may find theirs meanwhile.
    let pairs = match known {
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

/// Lets go of all modes: a library that is unloaded leaves nothing behind.
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
        // Its own: other tests fill the process's meanwhile.
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
