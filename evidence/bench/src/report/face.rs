//! `reports/face-cost.md`: what a call of the FMU costs, beside an FMU whose functions do nothing
//! and, where there is the like, the engine alone. All in CPU time of the thread, so that other
//! programs take nothing from it but caches.

use crate::{Written, duration, root};
use bench::Failure;
use bench::engine::machine;
use bench::library::{Fmu, Instance, State};
use cpu_time::ThreadTime;
use dth_hammer::{GUID, TOKEN};
use hammer::variables::{Read, Role, VARIABLES};
use hammer::{Input, InputValues, Machine, Parameters};
use serde::Serialize;
use std::ffi::{CStr, CString};
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use support::run::{cargo, run, target};

/// What is measured, in the order of the samples; the engine has the like of the first nine.
const ROWS: [&str; 16] = [
    "`fmi2DoStep` of 1 us without an event",
    "`fmi3DoStep` of 1 us without an event",
    "`fmi2DoStep`, and `fmi2GetReal` of all outputs",
    "`fmi3DoStep`, and `fmi3GetFloat64` of all outputs",
    "`fmi2SetReal` of all inputs, `fmi2DoStep`, `fmi2GetReal` of all outputs",
    "`fmi3SetFloat64` of all inputs, `fmi3DoStep`, `fmi3GetFloat64` of all outputs",
    "`fmi2SetReal` of all inputs, `fmi2GetReal` of all outputs, no step between",
    "`fmi2GetFMUstate` and `fmi2FreeFMUstate`",
    "`fmi2SetFMUstate`",
    "`fmi2SerializedFMUstateSize` and `fmi2SerializeFMUstate`",
    "`fmi2DeSerializeFMUstate` and `fmi2FreeFMUstate`",
    "load: dlopen and the functions' addresses",
    "`fmi2Instantiate`",
    "set up, enter and exit initialization mode",
    "first `fmi2DoStep`, of 1 ms",
    "all from dlopen to the end of that step",
];

/// Goals, s: what a step may take beyond the engine's, and all up to the end of the first step.
const GOALS: [f64; 2] = [100e-9, 2e-3];
/// Between the start and the first blow at 13.7 ms; that no event falls in it is checked.
const BEGIN: f64 = 2e-3;
const STEP: f64 = 1e-6;
const STEPS: usize = 4000;
const REPEATS: usize = 100;

/// Median and quartiles of many rounds, s.
#[derive(Clone, Copy, Serialize)]
struct Spread {
    median: f64,
    quartiles: [f64; 2],
}

impl Spread {
    fn of(mut samples: Vec<f64>) -> Option<Self> {
        samples.sort_by(f64::total_cmp);
        let at = |part: usize| samples.get(samples.len() * part / 4).copied();
        Some(Self { median: at(2)?, quartiles: [at(1)?, at(3)?] })
    }

    fn text(self) -> String {
        let [low, high] = self.quartiles.map(duration);
        format!("{} ({low} to {high})", duration(self.median))
    }
}

/// One kind of call.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    fmu: Spread,
    empty: Spread,
    engine: Option<Spread>,
}

impl Row {
    /// The face's own part of the cost, s.
    fn face(&self) -> Option<f64> {
        self.engine.map(|engine| self.fmu.median - engine.median)
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
pub fn page(short: bool) -> Result<Written, Failure> {
    let rounds = if short { 11 } else { 301 };
    let (hammer, empty) = (build("dth-fmu", "dth_hammer")?, build("empty-fmu", "empty_fmu")?);
    if let Some(&core) = core_affinity::get_core_ids().unwrap_or_default().last() {
        core_affinity::set_for_current(core);
    }
    let ports = Ports::all();
    let mut all: [Vec<Vec<f64>>; 3] = Default::default();
    for _ in 0..rounds {
        all[0].push(library(&hammer, &ports)?);
        all[1].push(library(&empty, &ports)?);
        all[2].push(engine(&ports)?);
    }
    let row = |(row, &name): (usize, &&'static str)| {
        let spread = |rounds: &Vec<Vec<f64>>| {
            Spread::of(rounds.iter().filter_map(|round| round.get(row).copied()).collect())
        };
        let [fmu, empty, engine] = all.each_ref().map(spread);
        Some(Row { name, fmu: fmu?, empty: empty?, engine })
    };
    let rows = ROWS.iter().enumerate().filter_map(row).collect();
    let ports = [ports.inputs.len(), ports.outputs.len()];
    let data = Data { processor: bench::processor(), rounds, ports, rows };
    Ok(Written { text: text(&data), json: serde_json::to_string(&data)?, figure: false })
}

fn build(package: &str, name: &str) -> Result<PathBuf, Failure> {
    let root = root();
    let options = ["build", "--quiet", "--profile", "fmu", "--lib", "--package", package];
    run(cargo(&root).args(options))?;
    let (begin, end) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(target(&root).join("fmu").join(format!("{begin}{name}{end}")))
}

fn text(data: &Data) -> String {
    let mut out = format!(
        "# Cost of the face: `cargo bench-report face`\n\n\
         A call of the FMU, of an FMU whose functions do nothing (`evidence/bench/empty`) and, where \
         there is the like, of the engine alone, all from Rust and the libraries through their C \
         symbols; CPU time on one core ({processor}), {rounds} rounds of each in turn: the median, and \
         in brackets the quartiles. The reference hammer; {inputs} inputs, \
         {outputs} outputs; steps of 1 us in the 4 ms before the first blow. What the face costs is \
         the first column less the third.\n\n\
         | calls | this FMU | an empty FMU | the engine alone | the face |\n|---|---|---|---|---|\n",
        processor = data.processor,
        rounds = data.rounds,
        inputs = data.ports[0],
        outputs = data.ports[1],
    );
    for row in &data.rows {
        let engine = row.engine.map_or(String::new(), Spread::text);
        let face = row.face().map_or(String::new(), duration);
        let (fmu, empty) = (row.fmu.text(), row.empty.text());
        let _ = writeln!(out, "| {} | {fmu} | {empty} | {engine} | {face} |", row.name);
    }
    let step = data.rows.first().and_then(Row::face);
    let start = data.rows.last().map(|row| row.fmu.median);
    let what = ["A step beyond the engine's own", "From dlopen to the end of the first step"];
    for ((what, value), goal) in what.iter().zip([step, start]).zip(GOALS) {
        let Some(value) = value else { continue };
        let verdict = if value <= goal { "met" } else { "missed" };
        let (value, goal) = (duration(value), duration(goal));
        let _ = writeln!(out, "\n{what}: {value}; the goal, {goal}, is {verdict}.");
    }
    out
}

/// Point number `i` of the quiet stretch, s.
fn point(i: usize) -> f64 {
    BEGIN + STEP * i as f64
}

/// Mean CPU time of one of `count` calls, s.
fn clock(count: usize, work: impl FnMut(usize)) -> f64 {
    let begun = ThreadTime::now();
    (0..count).for_each(work);
    begun.elapsed().as_secs_f64() / count as f64
}

/// What a host sets and gets at each point, by value reference.
struct Ports {
    inputs: Vec<(u32, Input)>,
    starts: Vec<f64>,
    outputs: Vec<(u32, Read<f64>)>,
    events: u32,
}

impl Ports {
    /// All there are.
    fn all() -> Self {
        let (mut inputs, mut outputs, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        let mut events = 0;
        for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
            match &variable.role {
                Role::Input { input, start, .. } => {
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

/// A round of a library's calls, s.
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
    let start = instance.save();
    let [quiet, read, coupled, both] = steps(&instance, &start, ports);
    let [quiet3, read3, coupled3] = steps3(&library, &CString::new(TOKEN)?, ports)?;
    let mut round = vec![quiet, quiet3, read, read3, coupled, coupled3, both];
    round.extend(states(&instance, &start));
    instance.forget(start);
    round.extend(marks.windows(2).map(|pair| pair[1].duration_since(pair[0]).as_secs_f64()));
    round.push(marks[4].duration_since(marks[0]).as_secs_f64());
    Ok(round)
}

fn steps(instance: &Instance, start: &State, ports: &Ports) -> [f64; 4] {
    let inputs: Vec<u32> = ports.inputs.iter().map(|input| input.0).collect();
    let outputs: Vec<u32> = ports.outputs.iter().map(|output| output.0).collect();
    let mut values = vec![0.0; outputs.len()];
    let count = || {
        let mut value = [0.0];
        instance.get(&[ports.events], &mut value);
        value
    };
    instance.restore(start);
    let before = count();
    let quiet = clock(STEPS, |i| instance.step(point(i), STEP));
    assert_eq!(count(), before, "the stretch must be quiet");
    instance.restore(start);
    let read = clock(STEPS, |i| {
        instance.step(point(i), STEP);
        instance.get(&outputs, &mut values);
    });
    instance.restore(start);
    let coupled = clock(STEPS, |i| {
        instance.set(&inputs, &ports.starts);
        instance.step(point(i), STEP);
        instance.get(&outputs, &mut values);
    });
    let both = clock(STEPS, |_| {
        instance.set(&inputs, &ports.starts);
        instance.get(&outputs, &mut values);
    });
    [quiet, read, coupled, both]
}

/// The first three by the functions of FMI 3.0, an instance each.
fn steps3(library: &Fmu, token: &CStr, ports: &Ports) -> Result<[f64; 3], Failure> {
    let inputs: Vec<u32> = ports.inputs.iter().map(|input| input.0).collect();
    let outputs: Vec<u32> = ports.outputs.iter().map(|output| output.0).collect();
    let mut values = vec![0.0; outputs.len()];
    let mut times = [0.0; 3];
    for (time, [sets, gets]) in times.iter_mut().zip([[false; 2], [false, true], [true; 2]]) {
        let instance = library.start3(token)?;
        instance.step(0.0, BEGIN);
        *time = clock(STEPS, |i| {
            if sets {
                instance.set(&inputs, &ports.starts);
            }
            instance.step(point(i), STEP);
            if gets {
                instance.get(&outputs, &mut values);
            }
        });
    }
    Ok(times)
}

fn states(instance: &Instance, start: &State) -> [f64; 4] {
    let saved = clock(REPEATS, |_| instance.forget(instance.save()));
    let restored = clock(REPEATS, |_| instance.restore(start));
    // A state keeps its bytes once they are made: a fresh one each time.
    let fresh: Vec<State> = (0..REPEATS).map(|_| instance.save()).collect();
    let mut bytes = Vec::with_capacity(1 << 16);
    let written = clock(REPEATS, |i| instance.serialise(&fresh[i], &mut bytes));
    fresh.into_iter().for_each(|state| instance.forget(state));
    let got_back = clock(REPEATS, |_| instance.forget(instance.deserialise(&bytes)));
    [saved, restored, written, got_back]
}

/// A round of the same on the engine alone, s: the first nine rows, of which three have the like twice.
fn engine(ports: &Ports) -> Result<Vec<f64>, Failure> {
    let mut machine = machine(&Parameters::default());
    machine.advance(BEGIN)?;
    let start = machine.state();
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
    machine.restore(&start)?;
    let read = clock(STEPS, |i| {
        step(&mut machine, i);
        get(&mut machine);
    });
    machine.restore(&start)?;
    let coupled = clock(STEPS, |i| {
        set(&mut machine);
        step(&mut machine, i);
        get(&mut machine);
    });
    let both = clock(STEPS, |_| {
        set(&mut machine);
        get(&mut machine);
    });
    let saved = clock(REPEATS, |_| drop(black_box(machine.state())));
    let restored = clock(REPEATS, |_| machine.restore(&start).expect("its own state"));
    Ok(vec![quiet, quiet, read, read, coupled, coupled, both, saved, restored])
}
