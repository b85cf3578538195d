//! Studies of the engine alone: size, communication step, fidelity, footprint.

use crate::contest::timed;
use crate::fmu::{Instance, Unpacked};
use crate::{Failure, target};
use bench::engine::{Engine, machine};
use bench::trajectory::{Peer, Shown, Task};
use cpu_time::ThreadTime;
use hammer::{Fidelity, Machine, Parameters, State, Vectors};
use oracles::model::Model;
use oracles::reference::Record;
use serde::{Deserialize, Serialize};
use std::process::Command;
use std::time::Duration;

/// Period of the stationary response, s.
pub const PERIOD: f64 = 45.389e-3;

/// A machine whose systems are decomposed, and its state at rest.
pub struct Warm {
    machine: Machine,
    rest: State,
}

impl Warm {
    /// The reference hammer.
    pub fn new() -> Self {
        Self::of(&Parameters::default())
    }

    /// Any hammer.
    pub fn of(parameters: &Parameters) -> Self {
        let mut machine = machine(parameters);
        let rest = machine.state();
        machine.advance(PERIOD).expect("a cycle runs");
        machine.restore(&rest).expect("its own state");
        Self { machine, rest }
    }

    /// Mean CPU time of the first `end` seconds from rest in steps of `step`, s.
    pub fn cycle(&mut self, end: f64, step: f64, repeats: u32) -> f64 {
        let mut total = 0.0;
        for _ in 0..repeats {
            self.machine.restore(&self.rest).expect("its own state");
            total += timed(|| march(end, step, |to, _| self.machine.advance(to).expect("runs"))).1;
        }
        self.machine.restore(&self.rest).expect("its own state");
        total / f64::from(repeats)
    }
}

/// Calls with the end and length of every step.
fn march(end: f64, step: f64, mut advance: impl FnMut(f64, f64)) {
    let count = (end / step).ceil() as u32;
    let mut time = 0.0;
    for i in 1..=count {
        let to = (f64::from(i) * step).min(end);
        advance(to, to - time);
        time = to;
    }
}

/// The same through the FMU, reading `references` after every step.
pub fn fmi_cycle(
    instance: &mut Instance,
    end: f64,
    step: f64,
    references: &[u32],
    repeats: u32,
) -> f64 {
    let mut values = vec![0.0; references.len()];
    let mut total = 0.0;
    // Once more than counted: the first one decomposes.
    for i in 0..=repeats {
        instance.rewind();
        let once = timed(|| {
            march(end, step, |to, size| {
                instance.step(to - size, size);
                if !values.is_empty() {
                    instance.read(references, &mut values);
                }
            });
        });
        total += if i > 0 { once.1 } else { 0.0 };
    }
    total / f64::from(repeats)
}

/// Cost against the number of elements of each bar.
#[derive(Serialize, Deserialize)]
pub struct Size {
    /// Elements.
    pub elements: usize,
    /// From parameters to a machine, s.
    pub setup: f64,
    /// First cycle, which decomposes the systems it meets, s.
    pub first: f64,
    /// The same cycle again, s.
    pub again: f64,
    /// Transitions in it.
    pub events: u64,
}

/// Cost against the communication step.
#[derive(Serialize, Deserialize)]
pub struct Step {
    /// Step, s.
    pub step: f64,
    /// A cycle by the engine, s.
    pub engine: f64,
    /// By `fmi2DoStep`, s.
    pub fmi: f64,
    /// By `fmi2DoStep` and one `fmi2GetReal` of eleven outputs, s.
    pub reading: f64,
}

/// Cost and truth of a fidelity.
#[derive(Serialize, Deserialize)]
pub struct Grade {
    /// Name.
    pub name: String,
    /// CPU time of a stationary cycle, s.
    pub cpu: f64,
    /// Period, s.
    pub period: f64,
    /// Rate of penetration, m/s.
    pub rop: f64,
    /// Largest contact force of the last cycles, N.
    pub contact: f64,
    /// Largest rock force, N.
    pub rock: f64,
}

/// Cost of a settled cycle in 1 ms steps.
#[derive(Serialize, Deserialize)]
pub struct Settled {
    /// Which vectors the engine was told to use.
    pub vectors: String,
    /// CPU time where nobody asks for an energy, the fastest of some rounds, s.
    pub cycle: f64,
    /// The same in a run so long that what is owed to the energies is paid on the way, s.
    pub long: f64,
    /// The same with the energies asked for after every step, s.
    pub with_energies: f64,
}

/// Cycles in which nothing that is owed must be paid.
const SHORT: u64 = 20;
/// Cycles in which it is paid several times.
const LONG: u64 = 400;

/// Settled cycles by every kind of vectors, in turn.
fn settled(rounds: u32) -> Vec<Settled> {
    let chosen = Vectors::in_use();
    let mut machine = machine(&Parameters::default());
    let run = |machine: &mut Machine, cycles: u64, asked: bool| {
        let last = machine.counters().blows + cycles;
        let mut sum = 0.0;
        while machine.counters().blows < last {
            machine.advance(machine.time() + 1e-3).expect("runs");
            if asked {
                sum += machine.energies().residual;
            }
        }
        assert!(sum.is_finite());
    };
    run(&mut machine, 12, true);
    let kinds = Vectors::available();
    let mut list: Vec<(Vectors, [f64; 3])> = kinds.map(|v| (v, [f64::INFINITY; 3])).collect();
    for _ in 0..rounds {
        for (vectors, best) in &mut list {
            assert!(vectors.select());
            let ways = [(SHORT, false), (LONG, false), (SHORT, true)];
            for (best, (cycles, asked)) in best.iter_mut().zip(ways) {
                // None pays what another owes.
                run(&mut machine, 1, true);
                let took = timed(|| run(&mut machine, cycles, asked)).1 / cycles as f64;
                *best = best.min(took);
            }
        }
    }
    assert!(chosen.select());
    let told = |(vectors, [cycle, long, with_energies]): (Vectors, [f64; 3])| Settled {
        vectors: vectors.to_string(),
        cycle,
        long,
        with_energies,
    };
    list.into_iter().map(told).collect()
}

/// The engine's worst error up to the second blow and after it.
pub fn errors(model: &Model<f64>, record: &Record) -> Result<[f64; 2], Failure> {
    let instants: Vec<f64> = record.states.iter().map(|s| s.time).collect();
    let task = Task { end: 71e-3, instants, patience: 60.0 };
    let done = Engine { parameters: Parameters::default() }.run(&task)?;
    let worst = |keep: &dyn Fn(f64) -> bool| {
        let pairs = done.shown.iter().zip(&record.states).filter(|(_, s)| keep(s.time));
        pairs.map(|(own, s)| Shown::of(model, &s.u, &s.v).distance(own)).fold(0.0, f64::max)
    };
    Ok([worst(&|t| t < SECOND_BLOW), worst(&|t| t >= SECOND_BLOW)])
}

/// The second blow begins here, s.
const SECOND_BLOW: f64 = 57.8e-3;

/// All of it.
#[derive(Serialize, Deserialize)]
pub struct Studies {
    /// Error before and after the second blow.
    pub blows: [f64; 2],
    /// Against elements.
    pub sizes: Vec<Size>,
    /// Against the communication step.
    pub steps: Vec<Step>,
    /// Fidelities.
    pub grades: Vec<Grade>,
    /// Bytes of heap of an instance: new, and after a cycle.
    pub memory: Option<(u64, u64)>,
    /// Instructions of one cycle in 1 ms steps, or why they were not counted.
    pub instructions: Result<u64, String>,
    /// Stationary cycles per second on one and on two cores.
    pub throughput: Vec<f64>,
    /// A settled cycle by the vectors that the processor has.
    #[serde(default)]
    pub vectors: Vec<Settled>,
}

/// Runs them all.
pub fn all(
    library: &Unpacked,
    (model, record): (&Model<f64>, &Record),
    cores: &[core_affinity::CoreId],
    short: bool,
) -> Result<Studies, Failure> {
    let sizes: &[usize] = if short { &[5, 20] } else { &[5, 10, 20, 40, 80, 160, 400] };
    let steps: &[f64] = if short { &[1e-4, 1e-3] } else { &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2] };
    let blows = if short { 3 } else { 20 };
    let mut grades = vec![grade(None, blows)];
    let fine: &[usize] = if short { &[5, 20] } else { &[5, 10, 20, 40, 160] };
    grades.extend(fine.iter().map(|&elements| grade(Some(elements), blows)));
    Ok(Studies {
        blows: errors(model, record)?,
        sizes: sizes.iter().map(|&elements| size(elements)).collect(),
        steps: steps.iter().map(|&s| step(library, s, short)).collect::<Result<_, _>>()?,
        grades,
        memory: memory(),
        instructions: instructions().map_err(|e| e.to_string()),
        throughput: throughput(cores, if short { 0.2 } else { 2.0 }),
        vectors: settled(if short { 2 } else { 10 }),
    })
}

fn elastic(elements: usize) -> Parameters {
    let mut parameters = Parameters::default();
    (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
    parameters
}

fn size(elements: usize) -> Size {
    let parameters = elastic(elements);
    // Whoever had the same hammer before has left its systems.
    hammer::forget_shared_systems();
    let (mut made, setup) = timed(|| machine(&parameters));
    let first = timed(|| march(PERIOD, 1e-3, |to, _| made.advance(to).expect("runs"))).1;
    let events = made.counters().events;
    let again = Warm::of(&parameters).cycle(PERIOD, 1e-3, if elements > 80 { 3 } else { 20 });
    Size { elements, setup, first, again, events }
}

fn step(library: &Unpacked, step: f64, short: bool) -> Result<Step, Failure> {
    let repeats = if step < 1e-4 || short { 3 } else { 30 };
    let outputs: Vec<u32> = OUTPUTS.iter().map(|name| library.reference(name)).collect();
    let mut instance = Instance::new(library)?;
    Ok(Step {
        step,
        engine: Warm::new().cycle(PERIOD, step, repeats),
        fmi: fmi_cycle(&mut instance, PERIOD, step, &[], repeats),
        reading: fmi_cycle(&mut instance, PERIOD, step, &outputs, repeats),
    })
}

/// What a host would plot.
const OUTPUTS: [&str; 11] = [
    "piston_position",
    "piston_velocity",
    "bit_position",
    "bit_velocity",
    "bit_tip_position",
    "bit_tip_velocity",
    "relative_position",
    "contact_gap",
    "contact_force",
    "rock_force",
    "hole_depth",
];

/// `None`: rigid bodies.
fn grade(elements: Option<usize>, blows: u32) -> Grade {
    let mut parameters = elements.map_or_else(Parameters::default, elastic);
    if elements.is_none() {
        parameters.fidelity = Fidelity::Rigid;
    }
    let mut machine = machine(&parameters);
    machine.advance(f64::from(blows) * PERIOD).expect("runs");
    let (mut contact, mut rock) = (0.0f64, 0.0f64);
    let (begin, cycles) = (machine.time(), 5.0);
    let cpu = timed(|| {
        march(cycles * PERIOD, 1e-3, |to, _| {
            machine.advance(begin + to).expect("runs");
            let peaks = machine.peaks();
            contact = contact.max(peaks.contact_force);
            rock = rock.max(peaks.rock_force);
        });
    })
    .1 / cycles;
    let blow = *machine.blow().expect("a blow");
    let name = elements.map_or("rigid".into(), |n| format!("{n} elements"));
    Grade { name, cpu, period: blow.period, rop: blow.rop, contact, rock }
}

/// The program beside this one that does a fixed amount of work.
fn footprint() -> Result<std::path::PathBuf, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(crate::root()).args(["build", "--release", "--quiet"]);
    command.args(["--package", "bench", "--features", "contest", "--bin", "footprint"]);
    if !command.status()?.success() {
        return Err("footprint does not build".into());
    }
    Ok(target().join("release/footprint"))
}

fn memory() -> Option<(u64, u64)> {
    let output = Command::new(footprint().ok()?).arg("memory").output().ok()?;
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    Some((value["new"].as_u64()?, value["after_cycle"].as_u64()?))
}

/// Instructions of the cycles from the third to the sixth, one of them.
fn instructions() -> Result<u64, Failure> {
    let (short, long) = (collect(2)?, collect(6)?);
    Ok((long - short) / 4)
}

fn collect(cycles: u32) -> Result<u64, Failure> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(footprint()?)
        .args(["cycles", &cycles.to_string()])
        .output()
        .map_err(|e| format!("valgrind: {e}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find_map(|line| line.split("Collected :").nth(1));
    Ok(line.ok_or("valgrind gave no count")?.trim().parse()?)
}

/// Cycles a second of each core's CPU time, one machine a core, all at once.
fn throughput(cores: &[core_affinity::CoreId], seconds: f64) -> Vec<f64> {
    let run = |core: core_affinity::CoreId| {
        core_affinity::set_for_current(core);
        let mut machine = machine(&Parameters::default());
        machine.advance(4.0 * PERIOD).expect("runs");
        let (clock, mut cycles) = (ThreadTime::now(), 0.0);
        while clock.elapsed() < Duration::from_secs_f64(seconds) {
            machine.advance(machine.time() + PERIOD).expect("runs");
            cycles += 1.0;
        }
        cycles / clock.elapsed().as_secs_f64()
    };
    (1..=cores.len().min(2))
        .map(|count| {
            std::thread::scope(|scope| {
                let threads: Vec<_> =
                    cores[..count].iter().map(|&core| scope.spawn(move || run(core))).collect();
                threads.into_iter().map(|t| t.join().expect("no panic")).sum()
            })
        })
        .collect()
}
