//! Handles in place of pointers.
//!
//! What the host holds as `fmi2Component` or `fmi2FMUstate` is a number, looked
//! up at each call. A pointer that was freed, or never given out, is then found
//! out instead of followed, and two threads at one instance wait for each other.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// Number of instances that can live at one time.
pub const CAPACITY: usize = 1 << 14;

/// Never the same twice, so that a stale handle cannot hit a later object.
static SERIAL: AtomicUsize = AtomicUsize::new(1);

/// A place for one object; alone on its cache line, so threads do not slow one another.
#[repr(align(64))]
struct Place<T>(Mutex<Option<Owned<T>>>);

/// An object and its handle. Boxed, so that an empty table is all zeros and takes no room
/// in the file.
type Owned<T> = Box<(usize, T)>;

/// A table of objects that live until they are removed.
///
/// It is all in static memory: unloading the library leaves nothing behind.
pub struct Table<T> {
    places: [Place<T>; CAPACITY],
    next: AtomicUsize,
}

/// Access to one object of a [`Table`].
pub struct Held<'a, T>(MutexGuard<'a, Option<Owned<T>>>);

impl<T> Held<'_, T> {
    /// The object; `None` if it was removed.
    pub fn get(&mut self) -> Option<&mut T> {
        self.0.as_mut().map(|owned| &mut owned.1)
    }

    /// Removes the object.
    pub fn remove(&mut self) -> Option<T> {
        self.0.take().map(|owned| owned.1)
    }
}

impl<T> Table<T> {
    /// An empty table.
    pub const fn new() -> Self {
        let places = [const { Place(Mutex::new(None)) }; CAPACITY];
        Self { places, next: AtomicUsize::new(0) }
    }

    /// Keeps an object under a new handle, never 0; `None` when the table is full.
    pub fn insert(&self, object: T) -> Option<usize> {
        let first = self.next.load(Ordering::Relaxed);
        for offset in 0..CAPACITY {
            let index = (first + offset) % CAPACITY;
            let mut place = match self.places[index].0.try_lock() {
                Ok(place) => place,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                // In use: not free.
                Err(TryLockError::WouldBlock) => continue,
            };
            if place.is_none() {
                let handle = SERIAL.fetch_add(1, Ordering::Relaxed) * CAPACITY + index;
                *place = Some(Box::new((handle, object)));
                self.next.store(index + 1, Ordering::Relaxed);
                return Some(handle);
            }
        }
        None
    }

    /// Locks an object; `None` if the handle is of none that lives.
    pub fn hold(&self, handle: usize) -> Option<Held<'_, T>> {
        let place = &self.places[handle % CAPACITY];
        let place = place.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*place {
            Some(owned) if owned.0 == handle => Some(Held(place)),
            _ => None,
        }
    }
}

/// A table of things that are only read, of which there may be any number.
pub struct Shelf<T>(Mutex<BTreeMap<usize, Arc<T>>>);

impl<T> Shelf<T> {
    /// An empty shelf.
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    fn map(&self) -> MutexGuard<'_, BTreeMap<usize, Arc<T>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a thing under a new handle, never 0.
    pub fn insert(&self, thing: T) -> usize {
        let handle = SERIAL.fetch_add(1, Ordering::Relaxed) * CAPACITY;
        self.map().insert(handle, Arc::new(thing));
        handle
    }

    /// Puts another thing under a handle in use; false if it is not in use.
    pub fn replace(&self, handle: usize, thing: T) -> bool {
        self.map().get_mut(&handle).map(|slot| *slot = Arc::new(thing)).is_some()
    }

    /// The thing under a handle.
    pub fn get(&self, handle: usize) -> Option<Arc<T>> {
        self.map().get(&handle).cloned()
    }

    /// Forgets a thing; false if there is none.
    pub fn remove(&self, handle: usize) -> bool {
        let mut map = self.map();
        let found = map.remove(&handle).is_some();
        if map.is_empty() {
            // An emptied map may keep memory, which would outlive the library.
            *map = BTreeMap::new();
        }
        found
    }
}
