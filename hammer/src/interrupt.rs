//! Interrupts, which end long work. Another thread sets them, or a function that is called every few milliseconds.

use std::cell::RefCell;
use std::fmt;
use std::mem::ManuallyDrop;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Returns true if the work must end.
type Question = Box<dyn Fn() -> bool + Send + Sync>;

/// Interval at which a thread that waits for others calls the function.
const PAUSE: Duration = Duration::from_millis(5);

#[derive(Default)]
struct Inner {
    set: AtomicBool,
    question: Option<Question>,
}

/// An interrupt, which ends the work of the engine that it [watches](Self::watch).
///
/// While the interrupt is set, watched work returns [`Error::Cancelled`](crate::Error::Cancelled) within milliseconds,
/// and so does any new watched work, until the interrupt is [cleared](Self::clear).
/// Only a call of the dense eigenvalue solver runs to its end, which takes 0.08 s on one core for a body of 400
/// splines.
/// Clones share one state.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<Inner>);

impl Interrupt {
    /// An interrupt that is also set as soon as `question` returns true. The working thread calls `question` every few
    /// milliseconds, except during calls of the dense solver (see [`Self`]).
    pub fn asking(question: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(Inner { set: AtomicBool::new(false), question: Some(Box::new(question)) }))
    }

    /// Ends all watched work.
    pub fn set(&self) {
        self.0.set.store(true, Ordering::Relaxed);
    }

    /// Allows work again.
    pub fn clear(&self) {
        self.0.set.store(false, Ordering::Relaxed);
    }

    /// True from [`Self::set`], or from the moment when the function returns true, until [`Self::clear`].
    pub fn is_set(&self) -> bool {
        if !self.0.set.load(Ordering::Relaxed) && self.0.question.as_ref().is_some_and(|ask| ask())
        {
            self.set();
        }
        self.0.set.load(Ordering::Relaxed)
    }

    /// The interrupt that watches this thread's work. If there is none, the result is an interrupt that nobody sets.
    pub fn present() -> Self {
        copy().unwrap_or_default()
    }

    /// Does `work` while this interrupt watches it: the steps, decompositions, derivatives and searches for a cycle
    /// that run in this thread.
    pub fn watch<T>(&self, work: impl FnOnce() -> T) -> T {
        let _previous = Previous(exchange(Some(self.clone())));
        work()
    }
}

impl fmt::Debug for Interrupt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Interrupt").field(&self.0.set).finish()
    }
}

thread_local! {
    /// The interrupt that watches this thread's work. It is always removed before the thread ends, and not dropped at
    /// its end, because a library can be unloaded while threads that have used it still exist.
    static PRESENT: RefCell<ManuallyDrop<Option<Interrupt>>> =
        const { RefCell::new(ManuallyDrop::new(None)) };
}

fn exchange(other: Option<Interrupt>) -> Option<Interrupt> {
    ManuallyDrop::into_inner(PRESENT.replace(ManuallyDrop::new(other)))
}

/// The previous interrupt of this thread, which is restored when this is dropped.
struct Previous(Option<Interrupt>);

impl Drop for Previous {
    fn drop(&mut self) {
        exchange(self.0.take());
    }
}

/// A copy of this thread's interrupt. It is copied because nothing may be borrowed while the function is called, which
/// may itself use the engine.
fn copy() -> Option<Interrupt> {
    PRESENT.with_borrow(|present| Option::clone(present))
}

/// True if this thread's work must end.
pub(crate) fn is_set() -> bool {
    let plain = PRESENT.with_borrow(|present| match present.as_ref() {
        Some(present) if present.0.question.is_some() => None,
        present => Some(present.is_some_and(Interrupt::is_set)),
    });
    plain.unwrap_or_else(|| copy().is_some_and(|interrupt| interrupt.is_set()))
}

/// Does `work` on each part, on this many threads, and returns the results in the order of the parts.
///
/// This thread's interrupt watches the threads. Meanwhile this thread calls the interrupt's function, since it may be
/// the only one that can: Python handles signals only in its main thread. With one thread, or if no thread can be
/// started, this thread does the work itself.
///
/// # Panics
/// If `work` panics.
pub fn in_threads<P: Send, T: Send>(
    parts: Vec<P>,
    threads: usize,
    work: impl Fn(P) -> T + Sync,
) -> Vec<T> {
    let threads = threads.min(parts.len());
    if threads < 2 {
        return parts.into_iter().map(work).collect();
    }
    let interrupt = Interrupt::present();
    let mut results: Vec<_> = parts.iter().map(|_| None).collect();
    let queue = Mutex::new(parts.into_iter().enumerate());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work_off = |results: Sender<(usize, T)>| {
        while let Some((k, part)) = next() {
            // Sending cannot fail, because the receiver waits for all results.
            let _ = results.send((k, work(part)));
        }
    };
    thread::scope(|scope| {
        let (sender, receiver) = channel();
        let (interrupt, work_off) = (&interrupt, &work_off);
        let thread = |_| {
            let sender = sender.clone();
            let watched = move || interrupt.watch(|| work_off(sender));
            thread::Builder::new().spawn_scoped(scope, watched).ok()
        };
        let workers: Vec<_> = (0..threads).map_while(thread).collect();
        if workers.is_empty() {
            work_off(sender);
        } else {
            drop(sender);
        }
        loop {
            match receiver.recv_timeout(PAUSE) {
                Ok((k, result)) => results[k] = Some(result),
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            interrupt.is_set();
        }
        for worker in workers {
            worker.join().unwrap_or_else(|panic| resume_unwind(panic));
        }
    });
    results.into_iter().flatten().collect()
}
