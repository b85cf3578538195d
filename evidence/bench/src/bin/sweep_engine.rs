//! The runs of a sweep by the engine alone, for `evidence/bench/sweep_cost.py`.
//!
//! Reads a [`Plan`] from standard input and writes a [`Done`]: a machine a run, one step to the
//! end, the outputs read there; nothing of the FMU but its names. What Python's sweep takes
//! beyond this is its own.

use bench::Failure;
use hammer::variables::{Read, Role, VARIABLES, Variable};
use hammer::{InputValues, Machine, Parameters};
use serde::{Deserialize, Serialize};
use std::io::{read_to_string, stdin};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// What is to be run.
#[derive(Deserialize)]
struct Plan {
    /// Parameters and inputs that differ from run to run.
    names: Vec<String>,
    /// One row of numbers a run.
    points: Vec<Vec<f64>>,
    /// End of each run, s.
    until: f64,
    /// What is read at the end.
    outputs: Vec<String>,
    /// Runs at a time.
    threads: usize,
}

/// What came out.
#[derive(Serialize)]
struct Done {
    /// Wall time from the first run to the last, s.
    seconds: f64,
    /// One row of numbers a run, in order.
    rows: Vec<Vec<f64>>,
}

fn variable(name: &str) -> Result<&'static Variable, Failure> {
    let found = VARIABLES.iter().find(|variable| variable.name == name);
    found.ok_or_else(|| format!("no variable {name}").into())
}

/// Reads an output as a number.
#[derive(Clone, Copy)]
enum Reader {
    Real(Read<f64>),
    Truth(Read<bool>),
}

impl Reader {
    fn of(name: &str) -> Result<Self, Failure> {
        match &variable(name)?.role {
            Role::Output(output) => Ok(Self::Real(output.value)),
            Role::Truth(read) => Ok(Self::Truth(*read)),
            _ => Err(format!("{name} is no output").into()),
        }
    }

    fn read(self, machine: &mut Machine) -> f64 {
        match self {
            Self::Real(read) => read(machine),
            Self::Truth(read) => f64::from(u8::from(read(machine))),
        }
    }
}

fn run(
    plan: &Plan,
    settings: &[&Role],
    readers: &[Reader],
    row: usize,
) -> Result<Vec<f64>, hammer::Error> {
    let (mut parameters, mut inputs) = (Parameters::default(), InputValues::default());
    for (role, value) in settings.iter().zip(&plan.points[row]) {
        match role {
            Role::Parameter { slot, .. } => slot.write(&mut parameters, *value),
            Role::Input { start, .. } => *start(&mut inputs) = *value,
            _ => {}
        }
    }
    let mut machine = Machine::new(&parameters, &inputs, 0.0)?;
    machine.advance(plan.until)?;
    Ok(readers.iter().map(|reader| reader.read(&mut machine)).collect())
}

fn main() -> Result<(), Failure> {
    let plan: Plan = serde_json::from_str(&read_to_string(stdin())?)?;
    let settings = plan.names.iter().map(|name| Ok(&variable(name)?.role));
    let settings = settings.collect::<Result<Vec<_>, Failure>>()?;
    let readers = plan.outputs.iter().map(|name| Reader::of(name));
    let readers = readers.collect::<Result<Vec<_>, Failure>>()?;
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(vec![Ok(Vec::new()); plan.points.len()]));
    let begun = Instant::now();
    let work = || {
        loop {
            let row = next.fetch_add(1, Ordering::Relaxed);
            if row >= plan.points.len() {
                return;
            }
            let done = run(&plan, &settings, &readers, row);
            rows.lock().expect("no thread panics holding it")[row] = done;
        }
    };
    std::thread::scope(|scope| (0..plan.threads).for_each(|_| drop(scope.spawn(work))));
    let seconds = begun.elapsed().as_secs_f64();
    let rows = rows.into_inner()?.into_iter().collect::<Result<_, _>>()?;
    println!("{}", serde_json::to_string(&Done { seconds, rows })?);
    Ok(())
}
