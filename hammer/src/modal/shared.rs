//! Cache of decomposed systems, shared by all scenes that need the same ones.
//!
//! A sweep over a load or an initial value needs the same systems in every run, and a decomposition takes as long as
//! many blows. Each system is therefore decomposed once per process and cached.
//! A cached system equals a new one to the last binary digit, so the cache does not affect results.

use crate::bodies::cache::{self, Recent};
use crate::error::Error;
use crate::laws::mode::Mode;
use crate::modal::spectrum::joined;
use crate::modal::system::{Recipe, System};
use std::sync::Arc;

/// Memory for the systems in this cache, and also for those of one scene's groups, bytes.
pub(crate) const BUDGET: usize = 1 << 27;
/// At least this many systems, as many as a scene can have, stay in the cache. On fine meshes they exceed the budget
/// (135 MB for three bodies on 160 quintic spans each). If they were dropped, a sweep would decompose them in every
/// run.
pub(crate) const SCENE: usize = 18;

/// All numbers of a recipe, exactly, after a hash in which most keys differ.
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
        // All lists have the same length, the number of free modes, so equal keys mean equal lists.
        key.extend(lists.flatten().map(|x| x.to_bits()));
        // This is the hash FNV-1a, by words instead of bytes.
        let fold = |hash: u64, word: &u64| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        Self(key.iter().fold(0xcbf2_9ce4_8422_2325, fold), key)
    }
}

static CACHE: Recent<Key, Arc<System>> = Recent::new(BUDGET, SCENE, |system| system.bytes());

/// The system of a recipe, from the cache or decomposed now.
///
/// # Errors
///
/// Those of [`System::new`].
pub(crate) fn system(recipe: Recipe, tip: Option<usize>, mode: Mode) -> Result<Arc<System>, Error> {
    CACHE.find(Key::new(&recipe, tip), |_| System::new(recipe, tip, mode).map(Arc::new))
}

/// Empties the caches of systems and modes, so that a library leaves nothing behind when it is unloaded. (If a process
/// was forked while another thread held a cache's lock, that cache cannot be emptied.)
pub fn forget() {
    cache::forget();
    joined::forget();
    CACHE.forget();
}
