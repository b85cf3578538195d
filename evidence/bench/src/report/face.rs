//! `reports/face-cost.md`: the cost of a call of the FMU, beside that of the engine alone where it has such a call.
//! CPU time of the thread is measured, on which other programs act only through the caches.

use crate::{Written, duration};
use bench::Failure;
use bench::engine::machine;
use bench::library::{Fmu, Instance};
use cpu_time::ThreadTime;
use dth_hammer::GUID;
use hammer::variables::{InputRow, Read, Role, VARIABLES};
use hammer::{Input, InputValues, Machine, Parameters};
use serde::Serialize;
use std::ffi::CString;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use support::run::{cargo, checkout, run, target};

/// The rows, in the order of the samples. The engine has calls like the first four.
const ROWS: [&str; 9] = [
    "`fmi2DoStep` of 1 us without an event",
    "`fmi2DoStep`, and `fmi2GetReal` of all outputs",
    "`fmi2SetReal` of all inputs, `fmi2DoStep`, `fmi2GetReal` of all outputs",
    "`fmi2SetReal` of all inputs, `fmi2GetReal` of all outputs, no step between",
    "load: dlopen and the functions' addresses",
    "`fmi2Instantiate`",
    "set up, enter and exit initialization mode",
    "first `fmi2DoStep`, of 1 ms",
    "all from dlopen to the end of that step",
];

/// Goals, s: for a step beyond the engine's own time, and for everything up to the end of the first step.
const GOALS: [f64; 2] = [100e-9, 2e-3];
/// Start of a stretch without events, s, before the first blow at 13.7 ms. That it has no event is checked.
const BEGIN: f64 = 2e-3;
const STEP: f64 = 1e-6;
const STEPS: usize = 3000;
const ROUNDS: usize = 301;

/// Median of many rounds, s.
fn median(mut samples: Vec<f64>) -> Option<f64> {
    samples.sort_by(f64::total_cmp);
    samples.get(samples.len() / 2).copied()
}

/// One kind of call.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    fmu: f64,
    engine: Option<f64>,
}

impl Row {
    /// The cost beyond the engine's, s.
    fn face(&self) -> Option<f64> {
        self.engine.map(|engine| self.fmu - engine)
    }
}

/// Everything measured.
#[derive(Serialize)]
struct Data {
    processor: String,
    rounds: usize,
    /// Numbers of inputs and outputs.
    ports: [usize; 2],
    rows: Vec<Row>,
}

/// Builds both libraries as they are shipped, and measures.
///
/// # Errors
/// If a library cannot be built or loaded, or the engine refuses.
pub fn page() -> Result<Written, Failure> {
    let hammer = build()?;
    if let Some(&core) = core_affinity::get_core_ids().unwrap_or_default().last() {
        core_affinity::set_for_current(core);
    }
    let ports = Ports::all();
    let mut all: [Vec<Vec<f64>>; 2] = Default::default();
    for _ in 0..ROUNDS {
        all[0].push(library(&hammer, &ports)?);
        all[1].push(engine(&ports)?);
    }
    let row = |(row, &name): (usize, &&'static str)| {
        let middle = |rounds: &Vec<Vec<f64>>| {
            median(rounds.iter().filter_map(|round| round.get(row).copied()).collect())
        };
        let [fmu, engine] = all.each_ref().map(middle);
        Some(Row { name, fmu: fmu?, engine })
    };
    let rows = ROWS.iter().enumerate().filter_map(row).collect();
    let ports = [ports.inputs.len(), ports.outputs.len()];
    let data = Data { processor: bench::processor(), rounds: ROUNDS, ports, rows };
    Ok(Written { text: text(&data), json: serde_json::to_string(&data)?, figure: false })
}

fn build() -> Result<PathBuf, Failure> {
    let root = checkout();
    let options = ["build", "--quiet", "--profile", "fmu", "--lib", "--package", "dth-fmu"];
    run(cargo(&root).args(options))?;
    let (begin, end) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(target(&root).join("fmu").join(format!("{begin}dth_hammer{end}")))
}

fn text(data: &Data) -> String {
    let mut out = format!(
        "# Cost of the face: `cargo bench-report face`\n\n\
         A call of the FMU and, where there is the like, of the engine alone, both from Rust and the library \
         through its C symbols; CPU time on one core ({processor}), {rounds} rounds of each in turn: the median. The reference hammer; {inputs} inputs, \
         {outputs} outputs; steps of 1 us, 3000 of each kind, before the first blow. What the face costs is \
         the first column less the second.\n\n\
         | calls | this FMU | the engine alone | the face |\n|---|---|---|---|\n",
        processor = data.processor,
        rounds = data.rounds,
        inputs = data.ports[0],
        outputs = data.ports[1],
    );
    for row in &data.rows {
        let engine = row.engine.map_or(String::new(), duration);
        let face = row.face().map_or(String::new(), duration);
        let _ = writeln!(out, "| {} | {} | {engine} | {face} |", row.name, duration(row.fmu));
    }
    let step = data.rows.first().and_then(Row::face);
    let start = data.rows.last().map(|row| row.fmu);
    let what = ["A step beyond the engine's own", "From dlopen to the end of the first step"];
    for ((what, value), goal) in what.iter().zip([step, start]).zip(GOALS) {
        let Some(value) = value else { continue };
        let verdict = if value <= goal { "met" } else { "missed" };
        let (value, goal) = (duration(value), duration(goal));
        let _ = writeln!(out, "\n{what}: {value}; the goal, {goal}, is {verdict}.");
    }
    out
}

/// Point number `i` of the stretch without events, s.
fn point(i: usize) -> f64 {
    BEGIN + STEP * i as f64
}

/// Mean CPU time of one of `count` calls, s.
fn clock(count: usize, work: impl FnMut(usize)) -> f64 {
    let begun = ThreadTime::now();
    (0..count).for_each(work);
    begun.elapsed().as_secs_f64() / count as f64
}

/// Value references that a host sets and gets at each point.
struct Ports {
    inputs: Vec<(u32, Input)>,
    starts: Vec<f64>,
    outputs: Vec<(u32, Read<f64>)>,
    events: u32,
}

impl Ports {
    /// All inputs and outputs.
    fn all() -> Self {
        let (mut inputs, mut outputs, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        let mut events = 0;
        for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
            match &variable.role {
                Role::Input(InputRow { input, start, .. }) => {
                    inputs.push((reference, *input));
                    starts.push(*start(&mut InputValues::default()));
                }
                Role::Output(output) => outputs.push((reference, output.value)),
                _ => {}
            }
            events = if variable.name == "event_count" { reference } else { events };
        }
        Self { inputs, starts, outputs, events }
    }
}

/// One round of a library's calls, s.
fn library(path: &Path, ports: &Ports) -> Result<Vec<f64>, Failure> {
    let guid = CString::new(GUID)?;
    let mut marks = vec![ThreadTime::now()];
    let library = Fmu::load(path)?;
    marks.push(ThreadTime::now());
    let instance = library.instantiate(&guid)?;
    marks.push(ThreadTime::now());
    instance.initialise();
    marks.push(ThreadTime::now());
    instance.step(0.0, 1e-3);
    marks.push(ThreadTime::now());
    instance.step(1e-3, BEGIN - 1e-3);
    let mut round = steps(&instance, ports).to_vec();
    round.extend(marks.windows(2).map(|pair| pair[1].duration_since(pair[0]).as_secs_f64()));
    round.push(marks[4].duration_since(marks[0]).as_secs_f64());
    Ok(round)
}

fn steps(instance: &Instance, ports: &Ports) -> [f64; 4] {
    let inputs: Vec<u32> = ports.inputs.iter().map(|input| input.0).collect();
    let outputs: Vec<u32> = ports.outputs.iter().map(|output| output.0).collect();
    let mut values = vec![0.0; outputs.len()];
    let count = || {
        let mut value = [0.0];
        instance.get(&[ports.events], &mut value);
        value
    };
    let before = count();
    let quiet = clock(STEPS, |i| instance.step(point(i), STEP));
    let read = clock(STEPS, |i| {
        instance.step(point(STEPS + i), STEP);
        instance.get(&outputs, &mut values);
    });
    let coupled = clock(STEPS, |i| {
        instance.set(&inputs, &ports.starts);
        instance.step(point(2 * STEPS + i), STEP);
        instance.get(&outputs, &mut values);
    });
    let both = clock(STEPS, |_| {
        instance.set(&inputs, &ports.starts);
        instance.get(&outputs, &mut values);
    });
    assert_eq!(count(), before, "the stretch must be quiet");
    [quiet, read, coupled, both]
}

/// One round of the first four rows on the engine alone, s.
fn engine(ports: &Ports) -> Result<Vec<f64>, Failure> {
    let mut machine = machine(&Parameters::default());
    machine.advance(BEGIN)?;
    let mut values = vec![0.0; ports.outputs.len()];
    let mut get = |machine: &mut Machine| {
        for (value, output) in values.iter_mut().zip(&ports.outputs) {
            *value = (output.1)(machine);
        }
        black_box(&values);
    };
    let set = |machine: &mut Machine| {
        for ((_, input), value) in ports.inputs.iter().zip(&ports.starts) {
            machine.set_input(*input, &[*value]).expect("a finite number");
        }
    };
    let step = |machine: &mut Machine, i| machine.advance(point(i) + STEP).expect("quiet");
    let quiet = clock(STEPS, |i| step(&mut machine, i));
    let read = clock(STEPS, |i| {
        step(&mut machine, STEPS + i);
        get(&mut machine);
    });
    let coupled = clock(STEPS, |i| {
        set(&mut machine);
        step(&mut machine, 2 * STEPS + i);
        get(&mut machine);
    });
    let both = clock(STEPS, |_| {
        set(&mut machine);
        get(&mut machine);
    });
    Ok(vec![quiet, read, coupled, both])
}
