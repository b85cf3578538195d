//! Handles instead of pointers.
//!
//! The handle that a host holds as `fmi2Component` or `fmi2FMUstate` is looked up in a table at each call and never
//! dereferenced. A freed or invented handle is therefore detected, and two threads that use one instance wait for
//! each other.
//!
//! A handle is nevertheless a valid address: that of a word of static memory which contains the handle itself, with
//! [`READABLE`] readable bytes. A host that dereferences a handle by mistake, or passes it instead of a pointer to
//! it, does no harm, and even gets what it meant.
//!
//! A process may fork while another of its threads holds a lock here. In the child that lock is never released, and
//! nothing waits for it (see [`Table::hold`]).

use std::process;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// Number of instances that can live at one time.
pub const CAPACITY: usize = 1 << 14;
/// Number of states that can be held at one time.
pub const STATES: usize = 1 << 17;
/// Number of readable bytes from a handle on.
pub const READABLE: usize = 64;

/// A handle is reused only after this many others, so that a stale one is detected.
const HANDLES: usize = 1 << 20;
const PADDING: usize = READABLE / size_of::<usize>();

/// The memory that handles point at. It is zero until used, and so takes no space in the file.
struct Words([AtomicUsize; HANDLES + PADDING]);

impl Words {
    const fn new() -> Self {
        Self([const { AtomicUsize::new(0) }; HANDLES + PADDING])
    }

    /// Opens the word at `index`: writes its own address into it, and returns that.
    fn open(&self, index: usize) -> usize {
        let word = &self.0[index];
        let handle = word.as_ptr().expose_provenance();
        word.store(handle, Ordering::Relaxed);
        handle
    }

    /// The index of the word that a handle points at, if any.
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

/// A place for one object, on its own cache line so that threads do not slow one another.
#[repr(align(64))]
struct Place<T, A> {
    object: Mutex<Option<Owned<T>>>,
    /// Number of objects so far.
    used: AtomicUsize,
    /// Data that can be read while the object is locked, with its handle. Locked only briefly.
    aside: Mutex<Option<(usize, A)>>,
    /// The process that created the object.
    process: AtomicU32,
}

/// An object and its handle. Boxed, so that an empty table is all zeros and takes no space in the
/// file.
type Owned<T> = Box<(usize, T)>;

/// A table of objects that live until they are removed.
///
/// It is all in static memory: unloading the library leaves nothing behind.
pub struct Table<T, A, const N: usize> {
    places: [Place<T, A>; N],
    next: AtomicUsize,
    words: Words,
}

/// The id of this process; 0 in a browser, which has neither processes nor forks.
fn this_process() -> u32 {
    if cfg!(target_family = "wasm") { 0 } else { process::id() }
}

/// Access to one object of a [`Table`].
pub struct Held<'a, T, A> {
    object: MutexGuard<'a, Option<Owned<T>>>,
    aside: &'a Mutex<Option<(usize, A)>>,
    words: &'a Words,
}

impl<T, A> Held<'_, T, A> {
    /// The object; `None` if it was removed.
    pub fn get(&mut self) -> Option<&mut T> {
        self.object.as_mut().map(|owned| &mut owned.1)
    }

    /// Removes the object, and the data stored beside it.
    pub fn remove(&mut self) -> Option<T> {
        let (handle, object) = *self.object.take()?;
        self.words.close(handle);
        // If another thread is copying it, it stays until the next object in this place replaces it.
        if let Ok(mut aside) = self.aside.try_lock() {
            *aside = None;
        }
        Some(object)
    }
}

impl<T, A> Place<T, A> {
    const fn empty() -> Self {
        Self {
            object: Mutex::new(None),
            used: AtomicUsize::new(0),
            aside: Mutex::new(None),
            process: AtomicU32::new(0),
        }
    }

    /// Locks it; `None` if it is locked already.
    fn try_lock(&self) -> Option<MutexGuard<'_, Option<Owned<T>>>> {
        match self.object.try_lock() {
            Ok(object) => Some(object),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

impl<T, A: Clone, const N: usize> Table<T, A, N> {
    /// An empty table.
    pub const fn new() -> Self {
        let places = [const { Place::empty() }; N];
        Self { places, next: AtomicUsize::new(0), words: Words::new() }
    }

    /// Stores an object under a new handle, never 0; `None` if the table is full.
    pub fn insert(&self, object: T, aside: A) -> Option<usize> {
        let first = self.next.load(Ordering::Relaxed);
        for offset in 0..N {
            let index = (first + offset) % N;
            // A locked place is in use, not free.
            let Some(mut place) = self.places[index].try_lock() else { continue };
            if place.is_none() {
                let used = self.places[index].used.fetch_add(1, Ordering::Relaxed);
                let handle = self.words.open((used * N + index) % HANDLES);
                self.places[index].process.store(this_process(), Ordering::Relaxed);
                *place = Some(Box::new((handle, object)));
                if let Ok(mut place) = self.places[index].aside.try_lock() {
                    *place = Some((handle, aside));
                }
                self.next.store(index + 1, Ordering::Relaxed);
                return Some(handle);
            }
        }
        None
    }

    /// The data stored beside an object, which may be locked.
    pub fn aside(&self, handle: usize) -> Option<A> {
        let place = &self.places[self.words.index(handle)? % N];
        let aside = place.aside.try_lock().ok()?;
        aside.as_ref().filter(|(owner, _)| *owner == handle).map(|(_, aside)| aside.clone())
    }

    /// Locks an object when no other thread holds it. `None` if no live object has the handle, or
    /// if the object is locked and was inherited by a fork, because its holder may exist only in
    /// the parent.
    pub fn hold(&self, handle: usize) -> Option<Held<'_, T, A>> {
        let place = &self.places[self.words.index(handle)? % N];
        let object = match place.try_lock() {
            Some(object) => object,
            None if place.process.load(Ordering::Relaxed) != this_process() => return None,
            None => place.object.lock().unwrap_or_else(PoisonError::into_inner),
        };
        match &*object {
            Some(owned) if owned.0 == handle => {
                Some(Held { object, aside: &place.aside, words: &self.words })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stale_handle_hits_nothing_for_a_million_more() {
        static TABLE: Table<u32, (), CAPACITY> = Table::new();
        let stale = TABLE.insert(0, ()).unwrap();
        TABLE.hold(stale).unwrap().remove();
        for _ in 0..1_000_000 {
            let object = TABLE.insert(1, ()).unwrap();
            assert_ne!(object, stale);
            TABLE.hold(object).unwrap().remove();
        }
        assert!(TABLE.hold(stale).is_none());
    }

    #[test]
    fn a_full_table_takes_no_more() {
        static FULL: Table<u32, (), 4> = Table::new();
        let handles = [(); 4].map(|()| FULL.insert(0, ()).unwrap());
        assert_eq!(FULL.insert(0, ()), None);
        FULL.hold(handles[2]).unwrap().remove();
        assert!(FULL.insert(0, ()).is_some());
    }

    #[test]
    fn what_is_near_a_handle_is_none() {
        static NEAR: Table<u32, (), CAPACITY> = Table::new();
        let handle = NEAR.insert(7, ()).unwrap();
        for wrong in [0, 1, handle - 8, handle + 1, handle + 8, usize::MAX] {
            assert!(NEAR.hold(wrong).is_none(), "{wrong}");
        }
        assert_eq!(NEAR.hold(handle).unwrap().get(), Some(&mut 7));
    }
}
