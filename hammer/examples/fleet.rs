//! Many hammers side by side: `fleet 1000` moves so many of them in turn, 1 ms each, then the same
//! one after another; prints the times and the heap that an instance takes beyond what all share.

use hammer::{InputValues, Machine, Parameters, Vectors};
use std::time::Instant;

/// Communication step, s.
const STEP: f64 = 1e-3;
/// Steps of each hammer.
const STEPS: u32 = 1000;

/// Memory of this process, kB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().split(' ').next()?.parse().ok()).unwrap_or(0)
}

/// Hammer `i`, under a feed force of its own.
fn hammer(i: u32) -> Result<Machine, hammer::Error> {
    let mut inputs = InputValues::default();
    inputs.feed_force += f64::from(i);
    Machine::new(&Parameters::default(), &inputs, 0.0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u32 = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    // What all share is made once.
    let mut first = hammer(0)?;
    (1..=STEPS).try_for_each(|k| first.advance(STEP * f64::from(k)))?;
    let before = resident();
    let begun = Instant::now();
    let mut all = (0..count).map(hammer).collect::<Result<Vec<_>, _>>()?;
    for k in 1..=STEPS {
        all.iter_mut().try_for_each(|machine| machine.advance(STEP * f64::from(k)))?;
    }
    let together = begun.elapsed().as_secs_f64();
    let grown = resident().saturating_sub(before);
    let residual: f64 = all.iter().map(|machine| machine.energies().residual.abs()).sum();
    drop(all);
    let begun = Instant::now();
    for i in 0..count {
        let mut machine = hammer(i)?;
        (1..=STEPS).try_for_each(|k| machine.advance(STEP * f64::from(k)))?;
    }
    let apart = begun.elapsed().as_secs_f64();
    println!(
        "{}: {count} hammers, {} kB each; in turn {together:.2} s, one after another {apart:.2} s, \
         ratio {:.3}; residuals {residual:.1e} J",
        Vectors::in_use(),
        grown / u64::from(count),
        together / apart,
    );
    Ok(())
}
