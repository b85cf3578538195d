//! Many hammers side by side: `fleet 1000 1` moves so many of them in turn, 1 ms each, for so many
//! seconds, then the same one after another; prints the CPU times, and the memory of an instance
//! beyond what all share. Linux only: it reads `/proc`.

use hammer::{InputValues, Machine, Parameters, Vectors};

/// Communication step, s.
const STEP: f64 = 1e-3;

/// The first number of the line of a file that starts so.
fn read(file: &str, start: &str) -> f64 {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix(start));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(f64::NAN)
}

/// Memory of this process, kB.
fn resident() -> f64 {
    read("/proc/self/status", "VmRSS:")
}

/// CPU time of this thread, s.
fn cpu() -> f64 {
    1e-9 * read("/proc/thread-self/schedstat", "")
}

/// Hammer `i`, under a feed force of its own.
fn hammer(i: u32) -> Result<Machine, hammer::Error> {
    let mut inputs = InputValues::default();
    inputs.feed_force += f64::from(i);
    Machine::new(&Parameters::default(), &inputs, 0.0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count: u32 = words.first().map_or(Ok(1000), |text| text.parse())?;
    let seconds: u32 = words.get(1).map_or(Ok(1), |text| text.parse())?;
    let steps = 1000 * seconds;
    let live =
        |machine: &mut Machine| (1..=steps).try_for_each(|k| machine.advance(STEP * f64::from(k)));
    // What all share is made once.
    live(&mut hammer(0)?)?;
    let (before, begun) = (resident(), cpu());
    let mut all = (0..count).map(hammer).collect::<Result<Vec<_>, _>>()?;
    for k in 1..=steps {
        all.iter_mut().try_for_each(|machine| machine.advance(STEP * f64::from(k)))?;
    }
    let (in_turn, grown) = (cpu() - begun, resident() - before);
    drop(all);
    let begun = cpu();
    (0..count).try_for_each(|i| live(&mut hammer(i)?))?;
    let after_another = cpu() - begun;
    println!(
        "{count} hammers for {seconds} s in steps of 1 ms ({}): {:.0} kB each; in turn \
         {in_turn:.2} s, one after another {after_another:.2} s, ratio {:.3}",
        Vectors::in_use(),
        grown / f64::from(count),
        in_turn / after_another,
    );
    Ok(())
}
