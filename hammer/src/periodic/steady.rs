//! The long-run response of a hammer, whether it repeats or not.
//!
//! A cycle that attracts is solved ([`find`]) and has no error. Where none does, blows are simulated:
//! they form a correlated series. The transient is cut where the standard error of what is left is
//! the smallest (MSER); the rest falls into batches, whose sums are as good as independent:
//!
//! ```text
//! rate R = sum of advances P / sum of periods T,      error^2 = sum over B batches of (P_b - R T_b)^2
//!                                                               / (B (B - 1) mean(T_b)^2)
//! ```
//!
//! (the delta method), and of the others alike with the count of blows for `T`.

use crate::error::Error;
use crate::machine::Machine;
use crate::periodic::error::CycleError;
use crate::periodic::find::{Cycle, Search, find};
use crate::sensitivity::Scene;

/// What a hammer does in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It repeats after so many returns of its drive.
    Cycle(usize),
    /// It does not repeat.
    Irregular,
    /// It comes to rest, or strikes no blow.
    Stalled,
}

/// Numbers of a blow, averaged; or their errors, or spreads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Averages {
    /// Rate of penetration, m/s: advance over time.
    pub rop: f64,
    /// From blow to blow, s.
    pub period: f64,
    /// Advance of the hole from blow to blow, m.
    pub penetration: f64,
    /// Speed at impact, m/s.
    pub speed: f64,
    /// Energy of impact, J.
    pub energy: f64,
}

/// A long-run response.
#[derive(Clone, Debug)]
pub struct Steady {
    /// What it does.
    pub kind: Kind,
    /// Means over blows.
    pub mean: Averages,
    /// Standard errors of these; 0 of a cycle.
    pub error: Averages,
    /// Standard deviations from blow to blow.
    pub spread: Averages,
    /// Blows that the means are of.
    pub blows: usize,
    /// True if the error asked for was reached.
    pub reached: bool,
    /// The cycle, if it is one.
    pub cycle: Option<Cycle>,
}

/// How a long-run response is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Largest standard error of the rate of penetration, over the rate.
    pub error: f64,
    /// Most blows simulated.
    pub blows: usize,
    /// Without a blow for so long it is stalled, s.
    pub limit: f64,
    /// Cycles are sought that close after so many returns at most; 0: none.
    pub returns: usize,
}

impl Default for Wanted {
    fn default() -> Self {
        Self { error: 0.01, blows: 20_000, limit: 10.0, returns: 2 }
    }
}

/// Blows before a cycle is sought, and least number that means are made of.
const SETTLED: usize = 40;
const FEWEST: usize = 200;
const BATCHES: usize = 20;
/// A step of the simulation, s.
const STEP: f64 = 0.05;
/// A cycle's rate must be that of the last blows to this part: it is where the motion goes.
const NEAR: f64 = 0.01;

/// Period, advance, speed and energy of a blow.
type Numbers = [f64; 4];

/// The long-run response of a scene. `progress` hears of the number of blows and the error so far,
/// over the rate, and ends the search by false.
///
/// # Errors
/// Those of the scene and of the engine.
pub fn steady(
    scene: &Scene,
    wanted: &Wanted,
    progress: &mut dyn FnMut(usize, f64) -> bool,
) -> Result<Steady, Error> {
    let mut machine = scene.machine()?;
    let (mut list, mut next): (Vec<Numbers>, usize) = (Vec::new(), SETTLED);
    loop {
        if !strike(&mut machine, &mut list, next, wanted.limit)? {
            let none = Averages::default();
            let (mean, error, spread) = (none, none, none);
            let kind = Kind::Stalled;
            return Ok(Steady { kind, mean, error, spread, blows: 0, reached: true, cycle: None });
        }
        if next == SETTLED
            && let Some(found) = attracting(scene, wanted, &list)?
        {
            return Ok(found);
        }
        let settled = &list[transient(&list)..];
        let error = rate_error(settled);
        let reached = settled.len() >= FEWEST && error <= wanted.error;
        if reached || !progress(list.len(), error) || list.len() >= wanted.blows {
            return Ok(irregular(settled, reached));
        }
        next = (list.len() + list.len() / 4).max(FEWEST).min(wanted.blows);
    }
}

/// Simulates up to a number of blows; false if there are no more.
fn strike(
    machine: &mut Machine,
    list: &mut Vec<Numbers>,
    count: usize,
    limit: f64,
) -> Result<bool, Error> {
    let mut last = machine.time();
    while list.len() < count {
        machine.advance(machine.time() + STEP)?;
        // The first blow has no period.
        let whole = machine.step_blows().iter().filter(|blow| blow.period > 0.0);
        list.extend(whole.map(|b| [b.period, b.penetration, b.speed, b.energy]));
        if !machine.step_blows().is_empty() {
            last = machine.time();
        }
        if machine.stalled() || machine.time() - last > limit {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The cycle that attracts, if the blows so far are near one that is stable.
fn attracting(scene: &Scene, wanted: &Wanted, list: &[Numbers]) -> Result<Option<Steady>, Error> {
    let recent = &list[list.len() - SETTLED / 4..];
    let observed = ratio(recent, |b| b[1], |b| b[0]);
    for returns in 1..=wanted.returns {
        let search = Search { returns, settle: SETTLED, steps: 12, ..Search::default() };
        let cycle = match find(scene, &search, &[]) {
            Ok(cycle) => cycle,
            Err(CycleError::Engine(error)) => return Err(error),
            Err(_) => continue,
        };
        let near = (cycle.response.rop - observed).abs() <= NEAR * observed.abs();
        if !near || !cycle.is_stable() || cycle.response.strikes.is_empty() {
            continue;
        }
        let response = &cycle.response;
        let blows = response.strikes.len();
        let each = |total: f64| total / blows as f64;
        let sum = |f: fn(&crate::periodic::Strike) -> f64| response.strikes.iter().map(f).sum();
        let mean = Averages {
            rop: response.rop,
            period: each(response.period),
            penetration: each(response.advance),
            speed: each(sum(|s| s.speed)),
            energy: each(sum(|s| s.energy)),
        };
        let (error, kind) = (Averages::default(), Kind::Cycle(returns));
        let spread = spread(recent);
        let cycle = Some(cycle);
        return Ok(Some(Steady { kind, mean, error, spread, blows, reached: true, cycle }));
    }
    Ok(None)
}

fn irregular(list: &[Numbers], reached: bool) -> Steady {
    let (one, period) = (|_: &Numbers| 1.0, |b: &Numbers| b[0]);
    let column = |k: usize| {
        let number = move |b: &Numbers| b[k];
        [ratio(list, number, one), error(list, number, one)]
    };
    let rates = [ratio(list, |b| b[1], period), error(list, |b| b[1], period)];
    let all = [rates, column(0), column(1), column(2), column(3)];
    let [mean, error] = [0, 1].map(|i| averages(all.map(|pair| pair[i])));
    let (kind, blows) = (Kind::Irregular, list.len());
    Steady { kind, mean, error, spread: spread(list), blows, reached, cycle: None }
}

fn averages([rop, period, penetration, speed, energy]: [f64; 5]) -> Averages {
    Averages { rop, period, penetration, speed, energy }
}

fn ratio(
    list: &[Numbers],
    above: impl Fn(&Numbers) -> f64,
    below: impl Fn(&Numbers) -> f64,
) -> f64 {
    list.iter().map(above).sum::<f64>() / list.iter().map(below).sum::<f64>()
}

/// Standard error of a ratio of sums, by batches.
fn error(
    list: &[Numbers],
    above: impl Fn(&Numbers) -> f64 + Copy,
    below: impl Fn(&Numbers) -> f64 + Copy,
) -> f64 {
    let size = list.len() / BATCHES;
    if size == 0 {
        return f64::INFINITY;
    }
    let mean = ratio(list, above, below);
    let batches = list.chunks_exact(size).take(BATCHES);
    let sum = |batch: &[Numbers], f: &dyn Fn(&Numbers) -> f64| batch.iter().map(f).sum::<f64>();
    let off = batches.map(|b| [sum(b, &above) - mean * sum(b, &below), sum(b, &below)]);
    let [squares, total] = off.fold([0.0; 2], |[s, t], [e, below]| [s + e * e, t + below]);
    let count = BATCHES as f64;
    (squares / (count * (count - 1.0))).sqrt() / (total / count)
}

fn rate_error(list: &[Numbers]) -> f64 {
    error(list, |b| b[1], |b| b[0]) / ratio(list, |b| b[1], |b| b[0]).abs()
}

fn spread(list: &[Numbers]) -> Averages {
    let deviation = |f: &dyn Fn(&Numbers) -> f64| {
        let (count, mean) =
            (list.len() as f64, list.iter().map(f).sum::<f64>() / list.len() as f64);
        (list.iter().map(|b| (f(b) - mean) * (f(b) - mean)).sum::<f64>() / count).sqrt()
    };
    let column = |k: usize| deviation(&move |b: &Numbers| b[k]);
    averages([deviation(&|b| b[1] / b[0]), column(0), column(1), column(2), column(3)])
}

/// Where the transient ends: the start, up to the middle, from which on the variance of the rate
/// over the number of blows squared is the least.
fn transient(list: &[Numbers]) -> usize {
    let (mut sum, mut squares, mut best) = (0.0, 0.0, (f64::INFINITY, 0));
    for (k, blow) in list.iter().enumerate().rev() {
        let (rate, count) = (blow[1] / blow[0], (list.len() - k) as f64);
        (sum, squares) = (sum + rate, squares + rate * rate);
        let variance = (squares / count - (sum / count) * (sum / count)).max(0.0);
        if k <= list.len() / 2 && variance / count < best.0 {
            best = (variance / count, k);
        }
    }
    best.1
}
