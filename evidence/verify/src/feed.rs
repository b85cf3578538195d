//! Rate of penetration over feed force: means over many blows, how well they are known, and the
//! range of single blows.

use hammer::{Error, Fidelity, InputValues, Machine, Parameters};
use serde::Serialize;
use std::fmt::Write as _;

/// Feed forces, N, of the reference and of rigid bodies on hard rock.
const FEEDS: [f64; 6] = [0.0, 2e3, 5e3, 10e3, 20e3, 40e3];
const RIGID: [f64; 11] = [0.0, 0.25e3, 0.5e3, 1e3, 1.5e3, 2e3, 3e3, 5e3, 7e3, 10e3, 20e3];
/// Left out at the start, and looked at after it, s.
const SETTLE: f64 = 0.5;
const SPAN: f64 = 1.5;
/// Batches whose means give the standard error: single blows follow from each other.
const BATCHES: usize = 5;

/// One feed force. Rates are in m/s.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// Feed force, N.
    pub feed: f64,
    /// Hole drilled by all blows over their time.
    pub rate: f64,
    /// Standard error of the mean, from batches of blows.
    pub error: f64,
    /// Least and largest of the single blows.
    pub range: [f64; 2],
}

/// Both curves.
#[derive(Clone, Debug, Serialize)]
pub struct Curves {
    /// The reference hammer, elastic.
    pub reference: Vec<Point>,
    /// Rigid, with a barrier of 40 J and a viscosity of 1e6 N s/m.
    pub rigid: Vec<Point>,
}

fn point(p: &Parameters, feed: f64) -> Result<Point, Error> {
    let inputs = InputValues { feed_force: feed, ..Default::default() };
    let mut m = Machine::new(p, &inputs, 0.0)?;
    m.advance(SETTLE)?;
    m.advance(SETTLE + SPAN)?;
    let blows: Vec<_> = m.step_blows().iter().copied().collect();
    let mean = |part: &[hammer::Blow]| {
        let (hole, time) =
            part.iter().fold((0.0, 0.0), |s, b| (s.0 + b.rop * b.period, s.1 + b.period));
        hole / time
    };
    let batches: Vec<f64> = blows.chunks(blows.len().div_ceil(BATCHES)).map(mean).collect();
    let (n, middle) = (batches.len() as f64, batches.iter().sum::<f64>() / batches.len() as f64);
    let spread: f64 = batches.iter().map(|b| (b - middle).powi(2)).sum();
    let rates = || blows.iter().map(|blow| blow.rop);
    let range = [rates().fold(f64::INFINITY, f64::min), rates().fold(f64::NEG_INFINITY, f64::max)];
    Ok(Point { feed, rate: mean(&blows), error: (spread / (n - 1.0) / n).sqrt(), range })
}

/// Runs both.
pub fn curves() -> Result<Curves, Error> {
    let reference = Parameters::default();
    let mut rigid = Parameters { fidelity: Fidelity::Rigid, ..reference };
    (rigid.rock.energy_barrier, rigid.rock.viscosity) = (40.0, 1e6);
    let run = |p: &Parameters, feeds: &[f64]| -> Result<Vec<_>, Error> {
        feeds.iter().map(|&feed| point(p, feed)).collect()
    };
    Ok(Curves { reference: run(&reference, &FEEDS)?, rigid: run(&rigid, &RIGID)? })
}

fn table(out: &mut String, points: &[Point]) {
    *out += "\n| feed, kN | rate of penetration, m/h | standard error | single blows, m/h |\n|---|---|---|---|\n";
    for Point { feed, rate, error, range: [low, high] } in points {
        let [feed, rate, error, low, high] =
            [feed / 1e3, 3600.0 * rate, 3600.0 * error, 3600.0 * low, 3600.0 * high];
        let _ = writeln!(out, "| {feed} | {rate:.1} | {error:.1} | {low:.1} to {high:.1} |");
    }
}

/// The page.
pub fn page(curves: &Curves) -> String {
    let rock = Parameters::default().rock;
    let (energy, high) = (1e-6 * rock.specific_energy, rock.specific_energy_factor);
    let low = 1.0 / high;
    let mut out = format!(
        "# Feed and rate: `cargo verify --feed`\n\n\
         The hole that the whole blows in {SPAN} s drill over their time, after {SETTLE} s from rest; its \
         standard error from {BATCHES} batches of blows, and the range of single blows. The rock's specific \
         energy is {energy:.0} MJ/m3; as far as that is not known, every rate here is from {low:.2} to \
         {high:.2} times what stands here, all alike.\n\n![rate over feed](feed.png)\n\n\
         ## The reference hammer\n\n\
         More feed, more rate, and the worst place is no feed at all, where the bit bounces and \
         single blows fail. There is no best feed: what stalls a real drill (its rotation, and a \
         casing that carries the feed) is not in this scene.\n"
    );
    table(&mut out, &curves.reference);
    out += "\n## Rigid bodies, a barrier of 40 J and a viscosity of 1e6 N s/m\n\n\
        A local best feed near 1 to 1.5 kN, as in the drifting oscillator of Depouhon, Denoel and \
        Detournay; far above it the rate rises again.\n";
    table(&mut out, &curves.rigid);
    out
}
