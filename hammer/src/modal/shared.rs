//! Cache of decomposed systems, shared by scenes with equal parameters.
//!
//! A sweep over a load or an initial value needs the same systems in every run, and a decomposition takes as long as
//! many blows. So each system is decomposed once per process and cached. The same numbers give the same bits, so
//! results do not depend on the cache.

use crate::bodies::cache::{self, Recent};
use crate::error::Error;
use crate::laws::mode::Mode;
use crate::laws::rock::Spring;
use crate::modal::spectrum::joined;
use crate::modal::system::passage::Passage;
use crate::modal::system::{Recipe, System};
use crate::scene::graph::Group;
use std::sync::{Arc, Mutex};

/// Budget of the process, and of a scene's groups, bytes.
pub(crate) const BUDGET: usize = 1 << 27;
/// At least as many systems as a scene can have stay in the cache: on fine meshes they exceed the budget, and
/// a sweep would otherwise decompose them in every run. (Three bodies on 160 quintic spans each: 135 MB.)
const SCENE: usize = 18;

/// Every number of a recipe, bit for bit; before them a hash, by which most keys differ.
#[derive(Debug, PartialEq)]
struct Key(u64, Vec<u64>);

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
        // All lists have one length, the number of free modes, so that equal keys are equal list by list.
        key.extend(lists.flatten().map(|x| x.to_bits()));
        // FNV-1a, by words instead of bytes.
        let fold = |hash: u64, word: &u64| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        Self(key.iter().fold(0xcbf2_9ce4_8422_2325, fold), key)
    }
}

static CACHE: Recent<Key, System> = Recent::new(BUDGET, SCENE, System::bytes);

/// The system of a recipe, from the cache or decomposed now.
///
/// # Errors
///
/// As [`System::new`].
pub(crate) fn system(recipe: Recipe, tip: Option<usize>, mode: Mode) -> Result<Arc<System>, Error> {
    system_in(&CACHE, recipe, tip, mode)
}

fn system_in(
    cache: &Recent<Key, System>,
    recipe: Recipe,
    tip: Option<usize>,
    mode: Mode,
) -> Result<Arc<System>, Error> {
    cache.find(Key::new(&recipe, tip), |_| System::new(recipe, tip, mode))
}

/// Drops all systems and modes that no scene uses, so that a library that is unloaded leaves nothing behind (except in
/// a process that was forked while another thread held the lock).
pub fn forget() {
    cache::forget();
    joined::forget();
    CACHE.forget();
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
    /// Reads a group's entry, if there is one, and marks it as the most recently used.
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

    /// Drops the systems of a spring at the tip, and the passages from them.
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
    fn spring(cache: &Recent<Key, System>, modes: usize, stiffness: f64) -> Arc<System> {
        let omega2: Vec<f64> = (0..modes).map(|i| (1e4 * i as f64).powi(2)).collect();
        let shape = vec![0.7; modes];
        let attachments = vec![Attachment { shape: &shape, stiffness, viscosity: 0.0 }];
        let structure = Structure { attachments, ..Structure::free(&omega2, 1e-8) };
        let loads = std::array::from_fn(|_| shape.clone());
        let recipe =
            Recipe { structure, loads, functionals: vec![shape.clone()], dampers: Vec::new() };
        system_in(cache, recipe, Some(0), MODE).expect("a spectrum")
    }

    #[test]
    fn equal_numbers_share_a_system_and_the_least_difference_does_not() {
        // A cache of its own: if another test held the lock, a system would be decomposed again.
        let cache = &Recent::new(BUDGET, SCENE, System::bytes);
        let one = spring(cache, 5, 3e8);
        assert!(Arc::ptr_eq(&one, &spring(cache, 5, 3e8)));
        assert!(!Arc::ptr_eq(&one, &spring(cache, 5, 3e8f64.next_up())));
        assert!(!Arc::ptr_eq(&one, &spring(cache, 6, 3e8)));
        let elsewhere = std::thread::scope(|scope| {
            scope.spawn(|| spring(cache, 5, 3e8)).join().expect("a thread")
        });
        assert!(Arc::ptr_eq(&one, &elsewhere));
    }
}
