//! Runs of one second as a sweep makes them, for a profiler: each with another rock, or another
//! feed force, or the same; or `count`, which counts the instructions of a run beyond the first by
//! valgrind: `cargo work-per-run`.
//!
//! Arguments: the number of runs; `rock`, `feed` or `same`; `start` ends each run at its second
//! blow; a number of elements per bar; `steps` makes ten steps of each run.

use hammer::{InputValues, Machine, Parameters, Vectors};
use std::process::Command;

/// Length of a run, s.
const SECOND: f64 = 1.0;

#[derive(Default)]
struct Plan {
    rock: bool,
    feed: bool,
    start: bool,
    steps: u32,
    elements: Option<usize>,
}

impl Plan {
    fn new(words: &[String]) -> Result<Self, Box<dyn std::error::Error>> {
        let mut plan = Self { steps: 1, ..Self::default() };
        for word in words {
            match word.as_str() {
                "rock" => plan.rock = true,
                "feed" => plan.feed = true,
                "same" => {}
                "start" => plan.start = true,
                "steps" => plan.steps = 10,
                elements => plan.elements = Some(elements.parse()?),
            }
        }
        Ok(plan)
    }

    /// Run `i`; its hole depth, m.
    fn run(&self, i: u32) -> Result<f64, hammer::Error> {
        let (mut parameters, mut inputs) = (Parameters::default(), InputValues::default());
        if self.rock {
            parameters.rock.stiffness *= 1.0 + 1e-3 * f64::from(i);
        }
        if self.feed {
            inputs.feed_force += f64::from(i);
        }
        if let Some(elements) = self.elements {
            (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
        }
        let mut machine = Machine::new(&parameters, &inputs, 0.0)?;
        if self.start {
            while machine.counters().blows < 2 {
                machine.advance(machine.time() + 1e-3)?;
            }
        } else {
            for step in 1..=self.steps {
                machine.advance(SECOND * f64::from(step) / f64::from(self.steps))?;
            }
        }
        Ok(machine.kinematics().hole_depth)
    }
}

/// Instructions of this program with these arguments, by callgrind (whose processor has no AVX-512).
fn instructions(runs: u32, more: &[String]) -> Result<u64, Box<dyn std::error::Error>> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    command.arg(std::env::current_exe()?).arg(runs.to_string()).args(more);
    let output = command.output().map_err(|error| format!("valgrind: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split("Collected :").nth(1));
    Ok(count.ok_or("valgrind gave no count")?.trim().parse()?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if words.first().is_some_and(|word| word == "count") {
        let [one, six] = [instructions(1, &words[1..])?, instructions(6, &words[1..])?];
        println!("{} instructions per run beyond the first, {one} once", (six - one) / 5);
        return Ok(());
    }
    let runs: u32 = words.first().map_or(Ok(20), |text| text.parse())?;
    let plan = Plan::new(words.get(1..).unwrap_or_default())?;
    let depths: f64 = (0..runs).map(|i| plan.run(i)).sum::<Result<f64, _>>()?;
    println!("{} {depths}", Vectors::in_use());
    Ok(())
}
