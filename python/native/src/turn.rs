//! Who uses an object, and who waits for it.
//!
//! One call at a time uses an object. A call that finds it in use
//! * waits, if another thread uses it, and hears signals meanwhile;
//! * is refused, if its own thread does: it comes from a signal's handler, or from a function that
//!   the engine calls, and would wait for itself;
//! * is refused, if the thread that used it was left behind by a fork.

use crate::failure::Failure;
use crate::interrupt::PAUSE;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How often a call that waits looks again: from the shortest time to the longest.
const LOOKS: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(1)];

/// Forks that led to this process.
static FORKS: AtomicU32 = AtomicU32::new(0);
/// Threads so far that used an object.
static THREADS: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// This thread's number, from 1; a forked process begins with the one of the thread that forked.
    static NUMBER: u32 = THREADS.fetch_add(1, Ordering::Relaxed) + 1;
}

/// Tells objects in use from those that a fork has left behind; Python calls it in the child.
#[pyfunction]
pub fn forked() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// This thread of this process.
fn present() -> u64 {
    (u64::from(FORKS.load(Ordering::Relaxed)) << 32) | u64::from(NUMBER.with(|number| *number))
}

/// An object that one call at a time uses.
pub struct Turn<T> {
    inner: Mutex<T>,
    /// True after a panic.
    broken: AtomicBool,
    /// Who uses it, if anybody.
    user: AtomicU64,
    /// Forks that led to the process that made it.
    forks: u32,
}

/// The object while it is used.
pub struct Use<'a, T> {
    pub object: MutexGuard<'a, T>,
    turn: &'a Turn<T>,
}

impl<T: Send> Use<'_, T> {
    /// Work on it, for any thread to do: a panic is a failure, and the last thing that is done to it.
    pub fn attempt<R>(
        &mut self,
        work: impl FnOnce(&mut T) -> Result<R, Failure> + Send,
    ) -> impl FnOnce() -> Result<R, Failure> + Send {
        let (object, broken) = (&mut *self.object, &self.turn.broken);
        move || {
            catch_unwind(AssertUnwindSafe(|| work(object))).unwrap_or_else(|payload| {
                broken.store(true, Ordering::Relaxed);
                Err(Failure::of_panic(&*payload))
            })
        }
    }
}

impl<T> Drop for Use<'_, T> {
    fn drop(&mut self) {
        self.turn.user.store(0, Ordering::Relaxed);
    }
}

impl<T: Send> Turn<T> {
    pub fn new(object: T) -> Self {
        let forks = FORKS.load(Ordering::Relaxed);
        let (broken, user) = (AtomicBool::new(false), AtomicU64::new(0));
        Self { inner: Mutex::new(object), broken, user, forks }
    }

    /// Whether this is the process that made it; threads of it are in no other.
    pub fn is_at_home(&self) -> bool {
        self.forks == FORKS.load(Ordering::Relaxed)
    }

    /// The object itself, of which there is no other user.
    pub fn get_mut(&mut self) -> Option<&mut T> {
        self.inner.get_mut().ok()
    }

    /// Begins to use it, if nobody does.
    ///
    /// # Errors
    /// An earlier call has panicked.
    pub fn free(&self) -> Result<Option<Use<'_, T>>, Failure> {
        let Ok(object) = self.inner.try_lock() else { return Ok(None) };
        if self.broken.load(Ordering::Relaxed) {
            return Err(Failure::broken());
        }
        self.user.store(present(), Ordering::Relaxed);
        Ok(Some(Use { object, turn: self }))
    }

    /// Begins to use it, once nobody does.
    ///
    /// # Errors
    /// It would wait for ever, a signal's handler raised, or an earlier call has panicked.
    pub fn begin(&self, py: Python<'_>) -> Result<Use<'_, T>, Failure> {
        let (mut look, mut asked) = (LOOKS[0], Instant::now());
        loop {
            if let Some(begun) = self.free()? {
                return Ok(begun);
            }
            let (user, own) = (self.user.load(Ordering::Relaxed), present());
            if user == own {
                return Err(Failure::refused(
                    "busy: this thread is using the same object already, and a signal's handler or \
                     a callback cannot use it in between; catch this error there, and the call goes on; \
                     read or do what is wanted after it",
                ));
            }
            if user != 0 && user >> 32 != own >> 32 {
                return Err(Failure::refused(
                    "busy: a thread used this object while the process was forked, and the forked \
                     process does not have that thread; make the object after the fork",
                ));
            }
            py.detach(|| sleep(look));
            look = (2 * look).min(LOOKS[1]);
            if asked.elapsed() >= PAUSE {
                py.check_signals().map_err(Failure::Python)?;
                asked = Instant::now();
            }
        }
    }
}
