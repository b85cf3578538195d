//! Handles in place of pointers.
//!
//! What the host holds as `fmi2Component` or `fmi2FMUstate` is looked up at each call and
//! never followed. A handle that was freed, or never given out, is then found out, and two
//! threads at one instance wait for each other.
//!
//! Still it is an address: of a word of static memory that holds the handle itself, with
//! [`READABLE`] bytes that can be read. A host that looks behind a handle by mistake, or
//! passes it where a pointer to it belongs, does no harm and even gets what it meant.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// Number of instances that can live at one time.
pub const CAPACITY: usize = 1 << 14;
/// Bytes from a handle on that can be read.
pub const READABLE: usize = 64;

/// A handle comes again after this many others, so that a stale one is found out.
const HANDLES: usize = 1 << 20;
const PADDING: usize = READABLE / size_of::<usize>();

/// What handles point at. Zeros until used: no room in the file, none in memory.
struct Words([AtomicUsize; HANDLES + PADDING]);

impl Words {
    const fn new() -> Self {
        Self([const { AtomicUsize::new(0) }; HANDLES + PADDING])
    }

    /// Gives the word at `index` out: its own address, which it then holds.
    fn open(&self, index: usize) -> usize {
        let word = &self.0[index];
        let handle = word.as_ptr().expose_provenance();
        word.store(handle, Ordering::Relaxed);
        handle
    }

    /// The index of a word that a handle may be of.
    fn index(&self, handle: usize) -> Option<usize> {
        let offset = handle.checked_sub(self.0.as_ptr().addr())?;
        let index = offset / size_of::<usize>();
        (offset % size_of::<usize>() == 0 && index < HANDLES).then_some(index)
    }

    fn close(&self, handle: usize) {
        if let Some(index) = self.index(handle) {
            self.0[index].store(0, Ordering::Relaxed);
        }
    }
}

/// A place for one object; alone on its cache line, so threads do not slow one another.
#[repr(align(64))]
struct Place<T> {
    object: Mutex<Option<Owned<T>>>,
    /// How many objects there were.
    used: AtomicUsize,
}

/// An object and its handle. Boxed, so that an empty table is all zeros and takes no room
/// in the file.
type Owned<T> = Box<(usize, T)>;

/// A table of objects that live until they are removed.
///
/// It is all in static memory: unloading the library leaves nothing behind.
pub struct Table<T> {
    places: [Place<T>; CAPACITY],
    next: AtomicUsize,
    words: Words,
}

/// Access to one object of a [`Table`].
pub struct Held<'a, T> {
    object: MutexGuard<'a, Option<Owned<T>>>,
    words: &'a Words,
}

impl<T> Held<'_, T> {
    /// The object; `None` if it was removed.
    pub fn get(&mut self) -> Option<&mut T> {
        self.object.as_mut().map(|owned| &mut owned.1)
    }

    /// Removes the object.
    pub fn remove(&mut self) -> Option<T> {
        let (handle, object) = *self.object.take()?;
        self.words.close(handle);
        Some(object)
    }
}

impl<T> Table<T> {
    /// An empty table.
    pub const fn new() -> Self {
        let places =
            [const { Place { object: Mutex::new(None), used: AtomicUsize::new(0) } }; CAPACITY];
        Self { places, next: AtomicUsize::new(0), words: Words::new() }
    }

    /// Keeps an object under a new handle, never 0; `None` when the table is full.
    pub fn insert(&self, object: T) -> Option<usize> {
        let first = self.next.load(Ordering::Relaxed);
        for offset in 0..CAPACITY {
            let index = (first + offset) % CAPACITY;
            let mut place = match self.places[index].object.try_lock() {
                Ok(place) => place,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                // In use: not free.
                Err(TryLockError::WouldBlock) => continue,
            };
            if place.is_none() {
                let used = self.places[index].used.fetch_add(1, Ordering::Relaxed);
                let handle = self.words.open((used * CAPACITY + index) % HANDLES);
                *place = Some(Box::new((handle, object)));
                self.next.store(index + 1, Ordering::Relaxed);
                return Some(handle);
            }
        }
        None
    }

    /// Locks an object; `None` if the handle is of none that lives.
    pub fn hold(&self, handle: usize) -> Option<Held<'_, T>> {
        let place = &self.places[self.words.index(handle)? % CAPACITY];
        let object = place.object.lock().unwrap_or_else(PoisonError::into_inner);
        match &*object {
            Some(owned) if owned.0 == handle => Some(Held { object, words: &self.words }),
            _ => None,
        }
    }
}

/// A table of things that are only read.
pub struct Store<T> {
    things: Mutex<Things<T>>,
    words: Words,
}

struct Things<T> {
    map: BTreeMap<usize, Arc<T>>,
    next: usize,
}

impl<T> Store<T> {
    /// An empty registry.
    pub const fn new() -> Self {
        let things = Things { map: BTreeMap::new(), next: 0 };
        Self { things: Mutex::new(things), words: Words::new() }
    }

    fn things(&self) -> MutexGuard<'_, Things<T>> {
        self.things.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a thing under a new handle, never 0; `None` when it is full.
    pub fn insert(&self, thing: T) -> Option<usize> {
        let mut things = self.things();
        if things.map.len() == HANDLES {
            return None;
        }
        loop {
            let handle = self.words.open(things.next);
            things.next = (things.next + 1) % HANDLES;
            if let Entry::Vacant(place) = things.map.entry(handle) {
                place.insert(Arc::new(thing));
                return Some(handle);
            }
        }
    }

    /// Puts another thing under a handle in use; false if it is not in use.
    pub fn replace(&self, handle: usize, thing: T) -> bool {
        self.things().map.get_mut(&handle).map(|slot| *slot = Arc::new(thing)).is_some()
    }

    /// The thing under a handle.
    pub fn get(&self, handle: usize) -> Option<Arc<T>> {
        self.things().map.get(&handle).cloned()
    }

    /// Forgets a thing; false if there is none.
    pub fn remove(&self, handle: usize) -> bool {
        let mut things = self.things();
        let found = things.map.remove(&handle).is_some();
        if found {
            self.words.close(handle);
        }
        if things.map.is_empty() {
            // An emptied map may keep memory, which would outlive the library.
            things.map = BTreeMap::new();
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static TABLE: Table<u32> = Table::new();
    static STORE: Store<u32> = Store::new();

    #[test]
    fn a_stale_handle_hits_nothing_for_a_million_more() {
        let stale = [TABLE.insert(0).unwrap(), STORE.insert(0).unwrap()];
        TABLE.hold(stale[0]).unwrap().remove();
        STORE.remove(stale[1]);
        for _ in 0..1_000_000 {
            let [object, thing] = [TABLE.insert(1).unwrap(), STORE.insert(1).unwrap()];
            assert!(object != stale[0] && thing != stale[1]);
            TABLE.hold(object).unwrap().remove();
            assert!(STORE.remove(thing));
        }
        assert!(TABLE.hold(stale[0]).is_none());
        assert!(STORE.get(stale[1]).is_none());
    }

    #[test]
    fn what_is_near_a_handle_is_none() {
        static NEAR: Table<u32> = Table::new();
        let handle = NEAR.insert(7).unwrap();
        for wrong in [0, 1, handle - 8, handle + 1, handle + 8, usize::MAX] {
            assert!(NEAR.hold(wrong).is_none(), "{wrong}");
        }
        assert_eq!(NEAR.hold(handle).unwrap().get(), Some(&mut 7));
    }
}
