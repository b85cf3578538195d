//! Cache of decomposed systems, shared by scenes with equal parameters.
//!
//! A sweep over a load or an initial value needs the same systems in every run, and a decomposition
//! takes as long as many blows. So each system is decomposed once per process and cached. The same
//! numbers give the same bits, so results do not depend on the cache. Nothing waits for its lock,
//! which may never be released after a fork; a system that is not found is decomposed.

use crate::bodies::cache;
use crate::error::Error;
use crate::laws::mode::Mode;
use crate::laws::rock::Spring;
use crate::modal::spectrum::joined;
use crate::modal::system::passage::Passage;
use crate::modal::system::{Recipe, System};
use crate::scene::graph::Group;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, Weak};

/// Budget of the process, and of a scene's groups, bytes.
pub(crate) const BUDGET: usize = 1 << 27;
/// At least as many systems as a scene can have stay in the cache: on fine meshes they exceed the budget, and
/// a sweep would otherwise decompose them in every run. (Three bodies on 160 quintic spans each: 135 MB.)
const SCENE: usize = 18;

/// Every number of a recipe, bit for bit.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key(Vec<u64>);

impl Key {
    fn new(recipe: &Recipe, tip: Option<usize>) -> Self {
        let structure = &recipe.structure;
        let lists = recipe.loads.iter().chain(&recipe.functionals);
        let count = |n: usize| n as u64;
        let mut key = vec![
            structure.beta.to_bits(),
            count(structure.omega2.len()),
            count(structure.attachments.len()),
            count(structure.proportional.len()),
            tip.map_or(u64::MAX, count),
            u64::from(structure.sliding.is_some()),
        ];
        key.extend(structure.omega2.iter().map(|x| x.to_bits()));
        for a in structure.attachments.iter().chain(&structure.proportional) {
            key.extend([a.stiffness.to_bits(), a.viscosity.to_bits()]);
            key.extend(a.shape.iter().map(|x| x.to_bits()));
        }
        // Each list is as long as there are free modes.
        key.extend(lists.flatten().map(|x| x.to_bits()));
        Self(key)
    }
}

struct Cache {
    /// Bytes of cached systems that no scene may be using.
    budget: usize,
    known: BTreeMap<Key, Weak<System>>,
    /// The most recently used ones, oldest first.
    recent: VecDeque<Arc<System>>,
    bytes: usize,
}

static CACHE: Mutex<Cache> = Mutex::new(Cache::new(BUDGET));

impl Cache {
    const fn new(budget: usize) -> Self {
        Self { budget, known: BTreeMap::new(), recent: VecDeque::new(), bytes: 0 }
    }

    fn find(&self, key: &Key) -> Option<Arc<System>> {
        self.known.get(key)?.upgrade()
    }

    /// Adds a system, or makes it the newest, and drops the oldest ones beyond the budget.
    fn keep(&mut self, system: &Arc<System>) {
        let before = self.recent.len();
        self.recent.retain(|recent| !Arc::ptr_eq(recent, system));
        self.recent.push_back(system.clone());
        if self.recent.len() > before {
            self.bytes += system.bytes();
        }
        while self.bytes > self.budget && self.recent.len() > SCENE {
            let Some(oldest) = self.recent.pop_front() else { break };
            self.bytes -= oldest.bytes();
        }
    }

    fn add(&mut self, key: Key, system: Arc<System>) -> Arc<System> {
        // Another thread may have been faster.
        let system = self.find(&key).unwrap_or(system);
        self.known.retain(|_, known| known.strong_count() > 0);
        self.known.insert(key, Arc::downgrade(&system));
        self.keep(&system);
        system
    }
}

/// The system of a recipe, from the cache or decomposed now.
///
/// # Errors
///
/// As [`System::new`].
pub(crate) fn system(recipe: Recipe, tip: Option<usize>, mode: Mode) -> Result<Arc<System>, Error> {
    system_in(&CACHE, recipe, tip, mode)
}

fn system_in(
    cache: &Mutex<Cache>,
    recipe: Recipe,
    tip: Option<usize>,
    mode: Mode,
) -> Result<Arc<System>, Error> {
    let key = Key::new(&recipe, tip);
    if let Ok(mut cache) = cache.try_lock()
        && let Some(system) = cache.find(&key)
    {
        cache.keep(&system);
        return Ok(system);
    }
    // Without the lock, which others may need meanwhile.
    let system = Arc::new(System::new(recipe, tip, mode)?);
    Ok(match cache.try_lock() {
        Ok(mut cache) => cache.add(key, system),
        Err(_) => system,
    })
}

/// Drops all systems and modes that no scene uses, so that a library that is unloaded leaves
/// nothing behind (except in a process that was forked while another thread held the lock).
pub fn forget() {
    cache::forget();
    joined::forget();
    if let Ok(mut cache) = CACHE.try_lock() {
        *cache = Cache::new(BUDGET);
    }
}

/// The systems of a scene's groups, each with the passages into it, made when first needed. A loose
/// string can have hundreds, so those not used for longest are dropped.
#[derive(Debug, Default)]
pub(crate) struct Systems(Mutex<Vec<Known>>);

#[derive(Clone, Debug)]
struct Known {
    group: Group,
    system: Arc<System>,
    /// From which groups; none where states are converted by the bodies' modes.
    passages: Vec<(Group, Option<Arc<Passage>>)>,
}

impl Clone for Systems {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.0.try_lock().map_or_else(|_| Vec::new(), |known| known.clone())))
    }
}

impl Systems {
    /// Reads what is known of a group, if anything is, which becomes the most recently used.
    fn read<T>(&self, group: Group, of: impl FnOnce(&mut Known) -> T) -> Option<T> {
        let mut known = self.0.try_lock().ok()?;
        let place = known.iter().rposition(|other| other.group == group)?;
        if place + 1 < known.len() {
            known[place..].rotate_left(1);
        }
        known.last_mut().map(of)
    }

    /// The system of a group: known, or made now.
    ///
    /// # Errors
    /// As `make`.
    pub(crate) fn system(
        &self,
        group: Group,
        make: impl FnOnce() -> Result<Arc<System>, Error>,
    ) -> Result<Arc<System>, Error> {
        if let Some(system) = self.read(group, |known| known.system.clone()) {
            return Ok(system);
        }
        let system = make()?;
        if let Ok(mut known) = self.0.try_lock() {
            known.push(Known { group, system: system.clone(), passages: Vec::new() });
            let bytes =
                |known: &[Known]| known.iter().map(|known| known.system.bytes()).sum::<usize>();
            while known.len() > SCENE && bytes(&known) > BUDGET {
                known.remove(0);
            }
        }
        Ok(system)
    }

    /// The passage from one group's system into another's, if there is one: known, or made now.
    ///
    /// # Errors
    /// As `make`.
    pub(crate) fn passage(
        &self,
        from: Group,
        to: Group,
        make: impl FnOnce() -> Result<Option<Arc<Passage>>, Error>,
    ) -> Result<Option<Arc<Passage>>, Error> {
        let known = self.read(to, |known| {
            let passage = known.passages.iter().find(|(other, _)| *other == from);
            passage.map(|(_, passage)| passage.clone())
        });
        if let Some(passage) = known.flatten() {
            return Ok(passage);
        }
        let passage = make()?;
        self.read(to, |known| known.passages.push((from, passage.clone())));
        Ok(passage)
    }

    /// Drops those of a spring at the tip, and the passages from them.
    pub(crate) fn forget(&mut self, spring: Spring) {
        if let Ok(known) = self.0.get_mut() {
            known.retain(|known| known.group.spring != Some(spring));
            for known in known {
                known.passages.retain(|(from, _)| from.spring != Some(spring));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::mode::RockMode;
    use crate::modal::structure::{Attachment, Structure};

    const MODE: Mode = Mode::starting(RockMode::Standstill);

    /// A bar of `modes` modes on a spring.
    fn spring(cache: &Mutex<Cache>, modes: usize, stiffness: f64) -> Arc<System> {
        let omega2: Vec<f64> = (0..modes).map(|i| (1e4 * i as f64).powi(2)).collect();
        let shape = vec![0.7; modes];
        let attachments = vec![Attachment { shape: &shape, stiffness, viscosity: 0.0 }];
        let structure = Structure { attachments, ..Structure::free(&omega2, 1e-8) };
        let loads = std::array::from_fn(|_| shape.clone());
        let recipe =
            Recipe { structure, loads, functionals: vec![shape.clone()], dampers: Vec::new() };
        system_in(cache, recipe, Some(0), MODE).expect("a spectrum")
    }

    /// Each test has its own cache: if another test held the lock, a system would be decomposed
    /// again.
    fn new_cache() -> Mutex<Cache> {
        Mutex::new(Cache::new(BUDGET))
    }

    #[test]
    fn equal_numbers_share_a_system_and_the_least_difference_does_not() {
        let cache = &new_cache();
        let one = spring(cache, 5, 3e8);
        assert!(Arc::ptr_eq(&one, &spring(cache, 5, 3e8)));
        assert!(!Arc::ptr_eq(&one, &spring(cache, 5, 3e8f64.next_up())));
        assert!(!Arc::ptr_eq(&one, &spring(cache, 6, 3e8)));
        let elsewhere = std::thread::scope(|scope| {
            scope.spawn(|| spring(cache, 5, 3e8)).join().expect("a thread")
        });
        assert!(Arc::ptr_eq(&one, &elsewhere));
    }

    #[test]
    fn what_is_kept_stays_within_the_budget_the_oldest_going_first() {
        let many = 0..=SCENE as u32 + 3;
        let systems: Vec<_> = many.map(|i| spring(&new_cache(), 4, 1e8 + f64::from(i))).collect();
        let (size, most) = (systems[0].bytes(), SCENE + 3);
        let mut cache = Cache::new(most * size);
        let held = |cache: &Cache| -> Vec<usize> {
            let place = |recent| systems.iter().position(|s| Arc::ptr_eq(s, recent));
            cache.recent.iter().filter_map(place).collect()
        };
        for i in (0..most).chain([0, most]) {
            cache.keep(&systems[i]);
        }
        // 0 has become the newest but one, and 1 has gone.
        assert_eq!(held(&cache), (2..most).chain([0, most]).collect::<Vec<_>>());
        assert_eq!(cache.bytes, most * size);
        let large = spring(&new_cache(), 60, 1e8);
        assert!(large.bytes() > cache.budget);
        cache.keep(&large);
        let last = (6..most).chain([0, most]).collect::<Vec<_>>();
        assert_eq!(held(&cache), last, "beyond the budget, what one scene can have");
        assert_eq!(cache.recent.len(), SCENE);
        assert_eq!(cache.bytes, (SCENE - 1) * size + large.bytes());
    }

    /// What a forked process does if another thread of its parent held the lock.
    #[test]
    fn a_scene_is_made_while_the_cache_is_locked() {
        let cache = &new_cache();
        let known = spring(cache, 7, 5e8);
        let locked = cache.lock().expect("a lock");
        let made = std::thread::scope(|scope| {
            let pair = || [spring(cache, 7, 5e8), spring(cache, 7, 5e8)];
            scope.spawn(pair).join().expect("two systems")
        });
        drop(locked);
        assert!(!Arc::ptr_eq(&made[0], &made[1]), "each is its own");
        let columns = [&known, &made[0]].map(|system| system.functionals[0].rows[0].clone());
        assert_eq!(columns[0], columns[1], "to the last bit");
        assert!(Arc::ptr_eq(&known, &spring(cache, 7, 5e8)), "found again");
    }
}
