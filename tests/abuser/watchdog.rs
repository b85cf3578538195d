//! What ends a test whose call hangs.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

/// No single call may work longer, nor stand still so long.
const PATIENCE: Duration = Duration::from_secs(60);
/// How many times as slow a program is here, if it is.
pub const SLOWER: &str = "DTH_SLOWER";
/// What works has at least this part of a core, however many others want it.
const LEAST: u32 = 1000;

/// What one thread has worked since some instant, which does not depend on what else runs.
#[derive(Clone)]
pub struct Stopwatch {
    begun: Instant,
    /// Where the system tells it, and what it told.
    source: Option<(PathBuf, Duration)>,
}

impl Stopwatch {
    /// Of this thread, from now on.
    pub fn start() -> Self {
        let own = fs::read_link("/proc/thread-self").ok();
        let source = own.and_then(|own| {
            let stat = Path::new("/proc").join(own).join("stat");
            let worked = worked(&stat)?;
            Some((stat, worked))
        });
        Self { begun: Instant::now(), source }
    }

    /// The work; the time where the system does not tell it.
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

/// Ends the program if a call of this thread hangs: nothing else could.
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
                    // Not by a macro: what those print is kept until a test ends.
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
