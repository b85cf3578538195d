//! Many hammers side by side. `fleet 1000 1` moves 1000 hammers in turn by 1 ms each, for 1 s, then the same hammers one after another. It prints the CPU times, and the memory of an instance beyond what all share. A third word, `in turn` or `one after another`, does only that, for a profiler. `fleet count` counts the instructions of both by valgrind. Linux only, since it reads `/proc`.

mod callgrind;

use callgrind::instructions;
use hammer::{InputValues, Machine, Parameters, Vectors};

/// Communication step, s.
const STEP: f64 = 1e-3;

/// First number in the line of a file that starts with this text.
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

/// Hammer `i`, with its own feed force.
fn hammer(i: u32) -> Result<Machine, hammer::Error> {
    let mut inputs = InputValues::default();
    inputs.feed_force += f64::from(i);
    Machine::new(&Parameters::default(), &inputs, 0.0)
}

/// Moves the hammers in turn, a step each. Calls `done` while all of them exist.
fn in_turn(count: u32, steps: u32, done: impl FnOnce()) -> Result<(), hammer::Error> {
    let mut all = (0..count).map(hammer).collect::<Result<Vec<_>, _>>()?;
    for k in 1..=steps {
        all.iter_mut().try_for_each(|machine| machine.advance(STEP * f64::from(k)))?;
    }
    done();
    Ok(())
}

/// Moves the hammers one after another.
fn after_another(count: u32, steps: u32) -> Result<(), hammer::Error> {
    (0..count).try_for_each(|i| {
        let mut machine = hammer(i)?;
        (1..=steps).try_for_each(|k| machine.advance(STEP * f64::from(k)))
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize| words.get(k).map_or("", String::as_str);
    if word(0) == "count" {
        for way in ["in turn", "one after another"] {
            let seconds = ["1".to_owned(), way.to_owned()];
            // Counts hammers that are added when the process already stores many integrals.
            let (few, many) = (instructions(40, &seconds)?, instructions(80, &seconds)?);
            println!(
                "{way}: {:.1} million instructions a hammer",
                1e-6 * (many - few) as f64 / 40.0
            );
        }
        return Ok(());
    }
    let count: u32 = words.first().map_or(Ok(1000), |text| text.parse())?;
    let seconds: u32 = words.get(1).map_or(Ok(1), |text| text.parse())?;
    let steps = 1000 * seconds;
    match word(2) {
        "in turn" => return Ok(in_turn(count, steps, || ())?),
        "one after another" => return Ok(after_another(count, steps)?),
        _ => {}
    }
    // Makes shared data beforehand.
    after_another(1, steps)?;
    let (before, begun, mut grown) = (resident(), cpu(), 0.0);
    in_turn(count, steps, || grown = resident() - before)?;
    let in_turn = cpu() - begun;
    let begun = cpu();
    after_another(count, steps)?;
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
