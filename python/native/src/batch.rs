//! Many hammers on any number of threads, each simulated from its start to the same instant, or to its long-run
//! response.

use crate::failure::{Failure, refused};
use crate::interrupt::PAUSE;
use crate::machine::guarded;
use crate::response::{Asked, response_numbers, wanted_of};
use crate::scene::{scene_of, warnings};
use crate::session::Session;
use crate::table::{Pick, Selection};
use crate::turn::Turn;
use hammer::Scene;
use hammer::means::{Wanted, steady};
use hammer::{Interrupt, buried};
use pyo3::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Result of a run: its place in the table, values (none if it was refused), the reason of a refusal (otherwise
/// empty), and warnings.
type Outcome = (usize, Vec<f64>, String, Vec<String>);

/// Longest wait for results, s.
const LONGEST: f64 = 1e6;

/// The task for each hammer.
enum Job {
    /// A run up to an instant, and the values read there.
    Run(f64, Vec<Pick>),
    /// The long-run response.
    Steady(Wanted),
}

/// Data that the threads share.
struct Plan {
    scenes: Vec<(Scene, Vec<String>)>,
    job: Job,
    /// Blows so far of the response that reported last, and its [`Means::error_ratio`](hammer::means::Means::error_ratio).
    progress: Mutex<(usize, f64)>,
    /// The next scene that no thread has taken.
    next: AtomicUsize,
    interrupt: Interrupt,
}

impl Plan {
    /// Takes scenes until none is left or the batch is stopped.
    fn work(&self, done: &Sender<Outcome>) {
        loop {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some((scene, names)) = self.scenes.get(index) else { return };
            let (mut values, mut noted) = (Vec::new(), Vec::new());
            let run = || guarded(|| self.run(scene, names, &mut values, &mut noted));
            let result = self.interrupt.watch(run);
            // The interrupted run has no result.
            if self.interrupt.is_set() {
                return;
            }
            let refused = match result {
                Ok(()) => String::new(),
                Err(Failure::Refused(text)) => text,
                Err(Failure::Python(error)) => error.to_string(),
            };
            if done.send((index, values, refused, noted)).is_err() {
                return;
            }
        }
    }

    fn run(
        &self,
        scene: &Scene,
        names: &[String],
        values: &mut Vec<f64>,
        noted: &mut Vec<String>,
    ) -> Result<(), Failure> {
        noted.extend(warnings(scene, names, true));
        match &self.job {
            Job::Run(until, picks) => {
                let mut session = Session::new(scene, false)?;
                noted.extend(session.machine.warnings());
                session.machine.advance(*until)?;
                session.read(picks, values)?;
            }
            Job::Steady(wanted) => {
                noted.extend(scene.machine()?.warnings());
                let found = steady(scene, wanted, &mut |blows, error| {
                    *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = (blows, error);
                    true
                })?;
                let mean = &found.mean;
                noted.extend(buried(mean.rop(), mean.tip_rate(), mean.get("advance")));
                noted.extend(found.depends_on_its_start());
                values.extend(response_numbers(&found));
            }
        }
        Ok(())
    }
}

/// Defaults of the search for a long-run response.
#[pyfunction]
pub fn wanted() -> HashMap<&'static str, f64> {
    let Wanted { error, blows, limit, repeating, .. } = Wanted::default();
    let [blows, repeating] = [blows, repeating].map(|count| count as f64);
    [("error", error.rop()), ("blows", blows), ("limit", limit), ("repeating", repeating)].into()
}

/// Results that have arrived but were not taken yet.
struct Inbox {
    receiver: Receiver<Outcome>,
    rows: Vec<Outcome>,
    crew: Vec<JoinHandle<()>>,
}

/// Runs in progress, which are stopped when it is dropped.
#[pyclass(frozen, module = "dth_hammer._native")]
pub struct Batch {
    plan: Arc<Plan>,
    inbox: Turn<Inbox>,
}

#[pymethods]
impl Batch {
    /// Starts to run hammers, each given by numbers by name, on some threads.
    #[new]
    fn new(
        py: Python<'_>,
        scenes: Vec<Vec<(String, f64)>>,
        until: f64,
        selection: &Selection,
        threads: usize,
    ) -> PyResult<Self> {
        Self::begin(py, scenes, Job::Run(until, selection.picks.clone()), threads)
    }

    /// Starts to search long-run responses.
    #[staticmethod]
    fn steady(
        py: Python<'_>,
        scenes: Vec<Vec<(String, f64)>>,
        wanted: Asked,
        threads: usize,
    ) -> PyResult<Self> {
        let each = (threads / scenes.len().max(1)).max(1);
        let wanted = Wanted { threads: each, ..wanted_of(wanted)? };
        Self::begin(py, scenes, Job::Steady(wanted), threads)
    }

    /// Blows so far of the response that reported last, and its error over the one wanted.
    fn progress(&self) -> PyResult<(usize, f64)> {
        self.at_home()?;
        Ok(*self.plan.progress.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Waits for so many results, or for some seconds. Returns at most so many, and None after all have been taken.
    /// Ctrl-C is noticed, and results that have arrived meanwhile are kept.
    #[pyo3(signature = (most, seconds=None))]
    fn take(
        &self,
        py: Python<'_>,
        most: usize,
        seconds: Option<f64>,
    ) -> PyResult<Option<Vec<Outcome>>> {
        self.at_home()?;
        if let Some(wrong) = seconds.filter(|s| !(0.0..=LONGEST).contains(s)) {
            return Err(refused(format!("seconds = {wrong} must be 0 to {LONGEST}")));
        }
        let end = seconds.map(|s| Instant::now() + Duration::from_secs_f64(s));
        let most = most.max(1);
        loop {
            let mut turn = self.inbox.begin(py)?;
            let inbox = &mut *turn.object;
            let more = py.detach(|| inbox.rows.len() >= most || inbox.receive());
            let late = end.is_some_and(|end| Instant::now() >= end);
            let count = inbox.rows.len().min(most);
            if count == most || late || !more {
                let rows = inbox.rows.drain(..count).collect::<Vec<_>>();
                return Ok(Some(rows).filter(|rows| more || !rows.is_empty()));
            }
            drop(turn);
            py.check_signals()?;
        }
    }

    /// Ends the runs, and returns the results that have arrived.
    fn stop(&self, py: Python<'_>) -> PyResult<Vec<Outcome>> {
        self.at_home()?;
        self.plan.interrupt.set();
        let mut turn = self.inbox.begin(py)?;
        let inbox = &mut *turn.object;
        Ok(py.detach(|| inbox.end()))
    }
}

impl Batch {
    fn begin(
        py: Python<'_>,
        scenes: Vec<Vec<(String, f64)>>,
        job: Job,
        threads: usize,
    ) -> PyResult<Self> {
        let scene = |numbers: Vec<(String, f64)>| -> PyResult<(Scene, Vec<String>)> {
            let names = numbers.iter().map(|(name, _)| name.clone()).collect();
            Ok((scene_of(&numbers.into_iter().collect::<HashMap<_, _>>())?, names))
        };
        let plan = Arc::new(Plan {
            scenes: scenes.into_iter().map(scene).collect::<PyResult<_>>()?,
            job,
            progress: Mutex::new((0, f64::INFINITY)),
            next: AtomicUsize::new(0),
            interrupt: Interrupt::default(),
        });
        let (sender, receiver) = channel();
        let mut inbox = Inbox { receiver, rows: Vec::new(), crew: Vec::new() };
        for _ in 0..threads.min(plan.scenes.len()) {
            let (shared, sender) = (Arc::clone(&plan), sender.clone());
            let thread = Builder::new().name("hammer".into()).spawn(move || shared.work(&sender));
            match thread {
                Ok(thread) => inbox.crew.push(thread),
                Err(error) => {
                    plan.interrupt.set();
                    py.detach(|| inbox.end());
                    return Err(error.into());
                }
            }
        }
        Ok(Self { inbox: Turn::new(inbox), plan })
    }

    fn at_home(&self) -> PyResult<()> {
        if self.inbox.is_at_home() {
            return Ok(());
        }
        Err(Failure::refused(
            "this batch belongs to the process that began it, whose threads a forked process does \
             not have; begin another after the fork",
        )
        .into())
    }
}

impl Inbox {
    /// Waits a short time for one more result; false if there will be none.
    fn receive(&mut self) -> bool {
        match self.receiver.recv_timeout(PAUSE) {
            Ok(outcome) => self.rows.push(outcome),
            Err(RecvTimeoutError::Timeout) => (),
            Err(RecvTimeoutError::Disconnected) => return false,
        }
        true
    }

    /// Waits for the interrupted threads, and returns the results that were not taken.
    fn end(&mut self) -> Vec<Outcome> {
        for thread in self.crew.drain(..) {
            // The thread catches its own panics.
            let _ = thread.join();
        }
        self.rows.extend(self.receiver.try_iter());
        std::mem::take(&mut self.rows)
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        let at_home = self.inbox.is_at_home();
        let Some(inbox) = self.inbox.get_mut() else { return };
        if at_home {
            self.plan.interrupt.set();
            Python::attach(|py| py.detach(|| inbox.end()));
        } else {
            // In a forked process the threads do not exist, so they cannot be joined.
            inbox.crew.drain(..).for_each(std::mem::forget);
        }
    }
}
