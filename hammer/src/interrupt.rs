//! Interrupts: another thread, or a question that is asked now and then, ends long work.

use std::cell::RefCell;
use std::fmt;
use std::mem::ManuallyDrop;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// True if the work is to end.
type Question = Box<dyn Fn() -> bool + Send + Sync>;

/// How often a thread that waits for others asks the question.
const PAUSE: Duration = Duration::from_millis(5);

#[derive(Default)]
struct Inner {
    set: AtomicBool,
    question: Option<Question>,
}

/// Ends work of the engine that is [watched](Self::watch).
///
/// While the interrupt is set, watched work returns [`Error::Cancelled`](crate::Error::Cancelled) within
/// milliseconds, and so does any new watched work, until it is [cleared](Self::clear). Only a call of the dense
/// eigenvalue solver runs to its end: 0.08 s of one core for a body of 400 splines. Clones share one state.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<Inner>);

impl Interrupt {
    /// An interrupt that is also set as soon as `question` returns true. The question is asked every few
    /// milliseconds, except during the dense solver's calls ([`Self`]), in the thread that works.
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

    /// True from [`Self::set`] or the question's answer on, until [`Self::clear`].
    pub fn is_set(&self) -> bool {
        if !self.0.set.load(Ordering::Relaxed) && self.0.question.as_ref().is_some_and(|ask| ask())
        {
            self.set();
        }
        self.0.set.load(Ordering::Relaxed)
    }

    /// The interrupt that watches this thread's work, or one that is never set.
    pub fn present() -> Self {
        copy().unwrap_or_default()
    }

    /// Does `work` while this interrupt watches it: steps, decompositions, derivatives and the search for a cycle, as
    /// far as they run in this thread.
    pub fn watch<T>(&self, work: impl FnOnce() -> T) -> T {
        let _before = Before(exchange(Some(self.clone())));
        work()
    }
}

impl fmt::Debug for Interrupt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Interrupt").field(&self.0.set).finish()
    }
}

thread_local! {
    /// The interrupt that watches this thread's work. It is never dropped at the end of a thread, and always taken
    /// out before: a library can be unloaded while threads that have used it live on.
    static PRESENT: RefCell<ManuallyDrop<Option<Interrupt>>> =
        const { RefCell::new(ManuallyDrop::new(None)) };
}

fn exchange(other: Option<Interrupt>) -> Option<Interrupt> {
    ManuallyDrop::into_inner(PRESENT.replace(ManuallyDrop::new(other)))
}

/// The previous interrupt of this thread, which is restored.
struct Before(Option<Interrupt>);

impl Drop for Before {
    fn drop(&mut self) {
        exchange(self.0.take());
    }
}

/// A copy, since a question may itself do work of the engine, and nothing must be borrowed meanwhile.
fn copy() -> Option<Interrupt> {
    PRESENT.with_borrow(|present| Option::clone(present))
}

/// True if this thread's work must end.
pub(crate) fn is_set() -> bool {
    copy().is_some_and(|interrupt| interrupt.is_set())
}

/// Does `work` on each part, on so many threads, and returns the results in the order of the parts.
///
/// The threads are watched by this thread's interrupt. This thread asks the question meanwhile, since it may be the
/// only one that can: Python handles signals in its main thread only. With one thread, or if none can be started,
/// this thread works itself.
///
/// # Panics
/// If `work` does.
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
    let labour = |done: Sender<(usize, T)>| {
        while let Some((k, part)) = next() {
            // It is received, since the receiver waits for all results.
            let _ = done.send((k, work(part)));
        }
    };
    thread::scope(|scope| {
        let (sender, receiver) = channel();
        let (interrupt, labour) = (&interrupt, &labour);
        let thread = |_| {
            let sender = sender.clone();
            let listening = move || interrupt.watch(|| labour(sender));
            thread::Builder::new().spawn_scoped(scope, listening).ok()
        };
        let crew: Vec<_> = (0..threads).map_while(thread).collect();
        if crew.is_empty() {
            labour(sender);
        } else {
            drop(sender);
        }
        loop {
            match receiver.recv_timeout(PAUSE) {
                Ok((k, done)) => results[k] = Some(done),
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            interrupt.is_set();
        }
        for worker in crew {
            worker.join().unwrap_or_else(|panic| resume_unwind(panic));
        }
    });
    results.into_iter().flatten().collect()
}
