//! The calls that are measured, on an FMU and, where there is the like, on the engine alone.

use bench::Failure;
use bench::library::{Fmu, Instance, State};
use dth_hammer::GUID;
use hammer::variables::{Read, Role, VARIABLES};
use hammer::{Input, InputValues, Machine, Parameters};
use std::ffi::CString;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

/// What is measured, in the order of the samples.
pub const ROWS: [&str; 13] = [
    "`fmi2DoStep` of 1 us without an event",
    "that, and `fmi2GetReal` of all outputs",
    "`fmi2SetReal` of all inputs, `fmi2DoStep`, `fmi2GetReal` of all outputs",
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

/// One round: ns a call, by row; nothing where there is no such thing to measure.
pub type Round = [Option<f64>; ROWS.len()];

/// Between the start and the first blow at 13.7 ms; that no event falls in it is checked.
const BEGIN: f64 = 2e-3;
const STEP: f64 = 1e-6;
const STEPS: usize = 4000;
const REPEATS: usize = 100;

/// Point number `i` of the quiet stretch, s.
fn point(i: usize) -> f64 {
    BEGIN + STEP * i as f64
}

/// Mean time of one of `count` calls, ns.
fn clock(count: usize, mut work: impl FnMut(usize)) -> f64 {
    let begun = Instant::now();
    (0..count).for_each(&mut work);
    begun.elapsed().as_nanos() as f64 / count as f64
}

/// The ports: what a host sets and gets at each point.
pub struct Ports {
    inputs: Vec<(u32, Input)>,
    outputs: Vec<(u32, Read<f64>)>,
    starts: Vec<f64>,
}

impl Ports {
    /// All there are.
    pub fn all() -> Self {
        let (mut inputs, mut outputs, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
            match &variable.role {
                Role::Input { input, start, .. } => {
                    inputs.push((reference, *input));
                    starts.push(*start(&mut InputValues::default()));
                }
                Role::Output(output) => outputs.push((reference, output.value)),
                _ => {}
            }
        }
        Self { inputs, outputs, starts }
    }

    /// Numbers of inputs and outputs.
    pub fn count(&self) -> [usize; 2] {
        [self.inputs.len(), self.outputs.len()]
    }
}

/// A round of an FMU's calls.
///
/// # Errors
/// If it cannot be loaded or instantiated.
pub fn fmu(path: &Path, ports: &Ports) -> Result<Round, Failure> {
    let guid = CString::new(GUID)?;
    let begun = Instant::now();
    let library = Fmu::load(path)?;
    let loaded = Instant::now();
    let instance = library.instantiate(&guid)?;
    let instantiated = Instant::now();
    instance.initialise();
    let initialised = Instant::now();
    instance.step(0.0, 1e-3);
    let stepped = Instant::now();

    instance.step(1e-3, BEGIN - 1e-3);
    let start = instance.save();
    let [quiet, read, coupled, ports] = stretches(&instance, &start, ports);
    let [saved, restored, written, got_back] = states(&instance, &start);
    instance.forget(start);
    let span = |from: Instant, to: Instant| Some((to - from).as_nanos() as f64);
    Ok([
        Some(quiet),
        Some(read),
        Some(coupled),
        Some(ports),
        Some(saved),
        Some(restored),
        Some(written),
        Some(got_back),
        span(begun, loaded),
        span(loaded, instantiated),
        span(instantiated, initialised),
        span(initialised, stepped),
        span(begun, stepped),
    ])
}

fn stretches(instance: &Instance, start: &State, ports: &Ports) -> [f64; 4] {
    let inputs: Vec<u32> = ports.inputs.iter().map(|input| input.0).collect();
    let outputs: Vec<u32> = ports.outputs.iter().map(|output| output.0).collect();
    let mut values = vec![0.0; outputs.len()];
    let events = VARIABLES.iter().position(|variable| variable.name == "event_count");
    let counted = [events.expect("promised") as u32];
    let count = || {
        let mut value = [0.0];
        instance.get(&counted, &mut value);
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
    let ports = clock(STEPS, |_| {
        instance.set(&inputs, &ports.starts);
        instance.get(&outputs, &mut values);
    });
    [quiet, read, coupled, ports]
}

fn states(instance: &Instance, start: &State) -> [f64; 4] {
    let saved = clock(REPEATS, |_| {
        let state = instance.save();
        instance.forget(state);
    });
    let restored = clock(REPEATS, |_| instance.restore(start));
    // A state keeps its bytes once they are made: a fresh one each time.
    let fresh: Vec<State> = (0..REPEATS).map(|_| instance.save()).collect();
    let mut bytes = Vec::with_capacity(1 << 16);
    let written = clock(REPEATS, |i| instance.serialise(&fresh[i], &mut bytes));
    fresh.into_iter().for_each(|state| instance.forget(state));
    let got_back = clock(REPEATS, |_| {
        let state = instance.deserialise(&bytes);
        instance.forget(state);
    });
    [saved, restored, written, got_back]
}

/// A round of the same on the engine alone.
///
/// # Errors
/// If the engine refuses.
pub fn engine(ports: &Ports) -> Result<Round, Failure> {
    let begun = Instant::now();
    let mut machine = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
    let made = Instant::now();
    machine.advance(1e-3)?;
    let stepped = Instant::now();

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
    let step =
        |machine: &mut Machine, i| machine.advance(point(i) + STEP).expect("a quiet stretch");
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
    let span = |from: Instant, to: Instant| Some((to - from).as_nanos() as f64);
    let (stepping, keeping) = ([quiet, read, coupled, both], [saved, restored]);
    let mut round = [None; ROWS.len()];
    let values = stepping.into_iter().chain(keeping).map(Some);
    round.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    round[10..].copy_from_slice(&[span(begun, made), span(made, stepped), span(begun, stepped)]);
    Ok(round)
}
