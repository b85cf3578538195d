//! The long run: the reference hammer, blow after blow.

use crate::monitor;
use hammer::{Error, InputValues, Machine, Parameters};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// What is looked at, at the start and at the end.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Mark {
    /// Blows so far.
    pub blows: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Last period, ms.
    pub period: f64,
    /// Tip rate over the last blow, mm/s.
    pub tip_rate: f64,
    /// Transitions so far.
    pub events: u64,
    /// Energy residual, J.
    pub residual: f64,
    /// Its bound, J.
    pub bound: f64,
    /// All the work done by the drive, J.
    pub work: f64,
    /// Hole depth, m.
    pub depth: f64,
    /// Resident memory, kB; 0 where the system does not tell.
    pub memory: u64,
}

/// The run.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Run {
    /// After a hundred blows.
    pub start: Mark,
    /// At the end.
    pub end: Mark,
    /// Blows asked for.
    pub asked: u64,
    /// Time given, minutes.
    pub minutes: f64,
    /// Time taken, s.
    pub seconds: f64,
}

impl Run {
    /// Whether residuals are within their bounds.
    pub fn holds(&self) -> bool {
        [self.start, self.end].iter().all(|m| m.residual.abs() <= m.bound)
    }
}

fn mark(m: &mut Machine) -> Mark {
    let (e, k, blow, counters) =
        (m.energies(), *m.kinematics(), m.blow().copied().unwrap_or_default(), m.counters());
    let (events, blows) = (counters.events, counters.blows);
    Mark {
        blows,
        time: m.time(),
        period: 1e3 * blow.period,
        tip_rate: 1e3 * blow.tip_rate,
        events,
        residual: e.residual,
        bound: monitor::long_bound(m.parameters(), events, blows, &e),
        work: e.drive + e.gravity + e.feed,
        depth: k.hole_depth,
        memory: memory(),
    }
}

fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmRSS:")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0)
}

/// Runs to `blows`, or for `minutes`; `tell` hears of the blows.
pub fn run(blows: u64, minutes: f64, tell: impl Fn(u64)) -> Result<Run, Error> {
    let begun = Instant::now();
    let given = Duration::from_secs_f64(60.0 * minutes);
    let mut m = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
    while m.counters().blows < blows.min(100) {
        m.advance(m.time() + 0.1)?;
    }
    let start = mark(&mut m);
    while m.counters().blows < blows && begun.elapsed() < given {
        m.advance(m.time() + 1.0)?;
        tell(m.counters().blows);
    }
    let end = mark(&mut m);
    Ok(Run { start, end, asked: blows, minutes, seconds: begun.elapsed().as_secs_f64() })
}
