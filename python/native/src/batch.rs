//! Many hammers on as many threads as one likes, each from its start to the same instant.

use crate::failure::Failure;
use crate::machine::guarded;
use crate::scene::{doubts, scene_of};
use crate::session::Session;
use crate::table::{Pick, Selection};
use crate::watch::PAUSE;
use hammer::Interrupt;
use hammer::sensitivity::Scene;
use pyo3::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// What a run gives: its place in the table, values (none if it was refused), why it was refused
/// (empty if it was not), and what is doubtful in it.
type Outcome = (usize, Vec<f64>, String, Vec<String>);

/// What the threads share.
struct Plan {
    scenes: Vec<(Scene, Vec<String>)>,
    until: f64,
    picks: Vec<Pick>,
    /// The first that no thread has taken.
    next: AtomicUsize,
    interrupt: Interrupt,
}

impl Plan {
    /// Takes scene after scene, until there is none or the batch is stopped.
    fn work(&self, done: &Sender<Outcome>) {
        loop {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some((scene, names)) = self.scenes.get(index) else { return };
            let (mut values, mut told) = (Vec::with_capacity(self.picks.len()), Vec::new());
            let run = || guarded(|| self.run(scene, names, &mut values, &mut told));
            let result = self.interrupt.watch(run);
            // The run that was under way has no result.
            if self.interrupt.is_set() {
                return;
            }
            let refused = match result {
                Ok(()) => String::new(),
                Err(Failure::Refused(text)) => text,
                Err(Failure::Python(error)) => error.to_string(),
            };
            if done.send((index, values, refused, told)).is_err() {
                return;
            }
        }
    }

    fn run(
        &self,
        scene: &Scene,
        names: &[String],
        values: &mut Vec<f64>,
        told: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let mut session = Session::new(scene, false)?;
        told.extend(session.machine.warnings());
        told.extend(doubts(scene, names));
        session.machine.advance(self.until)?;
        session.read(&self.picks, values)
    }
}

/// What has come and was not taken yet.
struct Inbox {
    receiver: Receiver<Outcome>,
    rows: Vec<Outcome>,
    crew: Vec<JoinHandle<()>>,
}

/// Runs under way; stopped when it is dropped.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Batch {
    plan: Arc<Plan>,
    inbox: Mutex<Inbox>,
}

#[pymethods]
impl Batch {
    /// Begins to run hammers, each made from numbers by name, on some threads.
    #[new]
    fn new(
        py: Python<'_>,
        scenes: Vec<Vec<(String, f64)>>,
        until: f64,
        selection: &Selection,
        threads: usize,
    ) -> PyResult<Self> {
        let scene = |numbers: Vec<(String, f64)>| -> PyResult<(Scene, Vec<String>)> {
            let names = numbers.iter().map(|(name, _)| name.clone()).collect();
            Ok((scene_of(&numbers.into_iter().collect::<HashMap<_, _>>())?, names))
        };
        let plan = Arc::new(Plan {
            scenes: scenes.into_iter().map(scene).collect::<PyResult<_>>()?,
            until,
            picks: selection.picks.clone(),
            next: AtomicUsize::new(0),
            interrupt: Interrupt::default(),
        });
        let (sender, receiver) = channel();
        let batch = Self {
            inbox: Mutex::new(Inbox { receiver, rows: Vec::new(), crew: Vec::new() }),
            plan: Arc::clone(&plan),
        };
        for _ in 0..threads.min(plan.scenes.len()) {
            let (plan, sender) = (Arc::clone(&plan), sender.clone());
            let thread = Builder::new().name("hammer".into()).spawn(move || plan.work(&sender));
            match thread {
                Ok(thread) => batch.inbox(|inbox| inbox.crew.push(thread)),
                Err(error) => {
                    batch.stop(py);
                    return Err(error.into());
                }
            }
        }
        Ok(batch)
    }

    /// Waits for results: for as many, or for some seconds and then for the first one. No more
    /// than as many come, and none when all runs were taken. Ctrl-C is heard, and what has come meanwhile is not lost.
    #[pyo3(signature = (most, seconds=None))]
    fn take(&self, py: Python<'_>, most: usize, seconds: Option<f64>) -> PyResult<Vec<Outcome>> {
        let end = seconds.map(|s| Instant::now() + Duration::from_secs_f64(s.clamp(0.0, 1e6)));
        loop {
            let late = end.is_some_and(|end| Instant::now() >= end);
            let full = py.detach(|| {
                self.inbox(|inbox| {
                    let enough = if late { 1 } else { most.max(1) };
                    inbox.rows.len() >= enough || !inbox.receive()
                })
            });
            if full {
                return Ok(self.inbox(|inbox| {
                    let count = inbox.rows.len().min(most.max(1));
                    inbox.rows.drain(..count).collect()
                }));
            }
            py.check_signals()?;
        }
    }

    /// Ends the runs under way; what had come before.
    fn stop(&self, py: Python<'_>) -> Vec<Outcome> {
        py.detach(|| self.end())
    }
}

impl Batch {
    fn inbox<T>(&self, work: impl FnOnce(&mut Inbox) -> T) -> T {
        work(&mut self.inbox.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn end(&self) -> Vec<Outcome> {
        self.plan.interrupt.set();
        self.inbox(|inbox| {
            for thread in inbox.crew.drain(..) {
                // It catches what panics on the way.
                let _ = thread.join();
            }
            inbox.rows.extend(inbox.receiver.try_iter());
            std::mem::take(&mut inbox.rows)
        })
    }
}

impl Inbox {
    /// Waits a little for one more; false if no more will come.
    fn receive(&mut self) -> bool {
        match self.receiver.recv_timeout(PAUSE) {
            Ok(outcome) => self.rows.push(outcome),
            Err(RecvTimeoutError::Timeout) => (),
            Err(RecvTimeoutError::Disconnected) => return false,
        }
        true
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        Python::attach(|py| py.detach(|| self.end()));
    }
}
