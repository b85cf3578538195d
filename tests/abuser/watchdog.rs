//! Ends a test whose call hangs.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

/// Longest work of a single call, and longest time without work.
const PATIENCE: Duration = Duration::from_secs(60);
/// Environment variable: how many times slower a program is here.
pub const SLOWER: &str = "DTH_SLOWER";
/// Least share of a core that a working thread has, however many others want it.
const LEAST: u32 = 1000;

/// Measures the work of one thread, which does not depend on what else runs.
#[derive(Clone)]
pub struct Stopwatch {
    begun: Instant,
    /// File in which the system reports it, and its start value.
    source: Option<(PathBuf, Duration)>,
}

impl Stopwatch {
    /// Starts for this thread.
    pub fn start() -> Self {
        let own = fs::read_link("/proc/thread-self").ok();
        let source = own.and_then(|own| {
            let stat = Path::new("/proc").join(own).join("stat");
            let worked = worked(&stat)?;
            Some((stat, worked))
        });
        Self { begun: Instant::now(), source }
    }

    /// The work; the clock time where the system does not report work.
    pub fn worked(&self) -> Duration {
        let source = self.source.as_ref();
        let since = source.and_then(|(stat, before)| worked(stat)?.checked_sub(*before));
        since.unwrap_or_else(|| self.begun.elapsed())
    }

    fn is_hanging(&self, patience: Duration) -> bool {
        let (worked, time) = (self.worked(), self.begun.elapsed());
        worked > patience || time > patience && worked < time / LEAST
    }
}

/// User and system time of a thread, in ticks of 10 ms.
fn worked(stat: &Path) -> Option<Duration> {
    let text = fs::read_to_string(stat).ok()?;
    let fields = text[text.rfind(')')?..].split(' ').skip(12).take(2);
    let ticks: u64 = fields.filter_map(|ticks| ticks.parse::<u64>().ok()).sum();
    Some(Duration::from_millis(10 * ticks))
}

/// Ends the program if a call of this thread hangs, since nothing else could end it.
pub struct Watchdog {
    present: Arc<Mutex<(Stopwatch, String)>>,
    done: Arc<AtomicBool>,
}

impl Watchdog {
    pub fn new() -> Self {
        let slower = std::env::var(SLOWER).ok().and_then(|times| times.parse().ok());
        let patience = PATIENCE * slower.unwrap_or(1);
        let present = Arc::new(Mutex::new((Stopwatch::start(), String::new())));
        let done = Arc::new(AtomicBool::new(false));
        let (watched, stop) = (present.clone(), done.clone());
        thread::spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_millis(200));
                let (since, call) = watched.lock().unwrap().clone();
                if since.is_hanging(patience) {
                    // Not by a macro, whose output would be kept until the test ends.
                    let _ = writeln!(io::stderr(), "this call hangs: {call}");
                    std::process::exit(101);
                }
            }
        });
        Self { present, done }
    }

    pub fn about_to(&self, call: String) {
        *self.present.lock().unwrap() = (Stopwatch::start(), call);
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
    }
}
