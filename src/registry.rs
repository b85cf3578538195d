//! Handles instead of pointers.
//!
//! The handle that a host holds as `fmi2Component` or `fmi2FMUstate` is looked up in a table at each call and never
//! dereferenced. A freed or invented handle is therefore detected, and two threads that use one instance wait for
//! each other.
//!
//! A handle is nevertheless a valid address: that of a word of static memory which contains the handle itself, followed
//! by readable memory up to [`READABLE`] bytes. A host that dereferences a handle by mistake, or passes it instead of a
//! pointer to it, does no harm, and even reads the right value.
//!
//! A signal handler may call while its own thread holds an object. The call is refused, because waiting would never
//! end. For this purpose a slot records the thread that holds it before it is locked, in one atomic operation.
//!
//! A process may fork while another of its threads holds a lock here. In the child that lock is never released, and
//! nothing waits for it (see [`Table::hold`]).

use std::process;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

/// Number of instances that can live at one time.
pub const CAPACITY: usize = 1 << 14;
/// Number of states that can be held at one time.
pub const STATES: usize = 1 << 17;
/// Number of readable bytes from a handle on.
pub const READABLE: usize = 64;

/// A handle is reused only after this many others, so that a stale one is detected.
const HANDLES: usize = 1 << 20;
const PADDING: usize = READABLE / size_of::<usize>();

/// The memory to which handles point. It is zero until used, and so takes no space in the file.
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

    /// The index of the word to which a handle points, if any.
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

/// A slot for one object, on its own cache line so that threads do not slow one another.
#[repr(align(64))]
struct Place<T, A> {
    /// The thread that holds the object, from [`this_thread`]; 0 if none does.
    holder: AtomicUsize,
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
/// It is entirely in static memory, so that unloading the library leaves nothing behind.
pub struct Table<T, A, const N: usize> {
    places: [Place<T, A>; N],
    next: AtomicUsize,
    words: Words,
}

/// The id of this process; 0 in a browser, which has neither processes nor forks.
fn this_process() -> u32 {
    if cfg!(target_family = "wasm") { 0 } else { process::id() }
}

/// A number that no other living thread has; never 0.
fn this_thread() -> usize {
    thread_local!(static MARK: u8 = const { 0 });
    MARK.with(|mark| std::ptr::from_ref(mark).addr())
}

/// The object of a slot, locked by this thread.
struct Locked<'a, T> {
    // Dropped in this order: a handler in between finds the slot held by its own thread, and does not wait.
    object: MutexGuard<'a, Option<Owned<T>>>,
    _release: Release<'a>,
}

/// Releases a slot that a thread holds.
struct Release<'a>(&'a AtomicUsize);

impl Drop for Release<'_> {
    fn drop(&mut self) {
        self.0.store(0, Ordering::Release);
    }
}

/// Access to one object of a [`Table`].
pub struct Held<'a, T, A> {
    locked: Locked<'a, T>,
    aside: &'a Mutex<Option<(usize, A)>>,
    words: &'a Words,
}

impl<T, A> Held<'_, T, A> {
    /// The object; `None` if it was removed.
    pub fn get(&mut self) -> Option<&mut T> {
        self.locked.object.as_mut().map(|owned| &mut owned.1)
    }

    /// Removes the object, and the data stored beside it.
    pub fn remove(&mut self) -> Option<T> {
        let (handle, object) = *self.locked.object.take()?;
        self.words.close(handle);
        // If another thread is copying it, it stays until the next object in this slot replaces it.
        if let Ok(mut aside) = self.aside.try_lock() {
            *aside = None;
        }
        Some(object)
    }
}

impl<T, A> Place<T, A> {
    const fn empty() -> Self {
        Self {
            holder: AtomicUsize::new(0),
            object: Mutex::new(None),
            used: AtomicUsize::new(0),
            aside: Mutex::new(None),
            process: AtomicU32::new(0),
        }
    }

    /// Locks the slot, or returns the thread that holds it.
    fn try_lock(&self) -> Result<Locked<'_, T>, usize> {
        let ours = this_thread();
        self.holder.compare_exchange(0, ours, Ordering::Acquire, Ordering::Relaxed)?;
        // The thread that held it last unlocked it before it gave it up.
        let object = self.object.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(Locked { object, _release: Release(&self.holder) })
    }

    /// Waits until the thread that holds the slot has unlocked it.
    fn wait(&self) {
        drop(self.object.lock());
        thread::yield_now();
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
            // A locked slot is in use, not free.
            let Ok(mut place) = self.places[index].try_lock() else { continue };
            if place.object.is_none() {
                let used = self.places[index].used.fetch_add(1, Ordering::Relaxed);
                let handle = self.words.open((used * N + index) % HANDLES);
                self.places[index].process.store(this_process(), Ordering::Relaxed);
                *place.object = Some(Box::new((handle, object)));
                if let Ok(mut beside) = self.places[index].aside.try_lock() {
                    *beside = Some((handle, aside));
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

    /// Locks an object when no other thread holds it. `None` if no live object has the handle, if this thread holds
    /// it already (the caller is a signal's handler), or if the object is locked and was inherited by a fork, because
    /// its holder may exist only in the parent.
    pub fn hold(&self, handle: usize) -> Option<Held<'_, T, A>> {
        let place = &self.places[self.words.index(handle)? % N];
        let locked = loop {
            match place.try_lock() {
                Ok(locked) => break locked,
                Err(holder) if holder == this_thread() => return None,
                Err(_) if place.process.load(Ordering::Relaxed) != this_process() => return None,
                Err(_) => place.wait(),
            }
        };
        let owned = locked.object.as_ref().is_some_and(|owned| owned.0 == handle);
        owned.then_some(Held { locked, aside: &place.aside, words: &self.words })
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
    fn a_thread_that_holds_an_object_is_refused_it_and_another_waits() {
        static HELD: Table<u32, (), 4> = Table::new();
        let handle = HELD.insert(1, ()).unwrap();
        let mut held = HELD.hold(handle).unwrap();
        assert!(HELD.hold(handle).is_none());
        let other = thread::spawn(move || *HELD.hold(handle).unwrap().get().unwrap());
        *held.get().unwrap() = 2;
        drop(held);
        assert_eq!(other.join().unwrap(), 2);
        assert_eq!(HELD.hold(handle).unwrap().get(), Some(&mut 2));
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
