//! The contest: every solver with its settings, in turn, round after round.

use crate::fmu::{Instance, Unpacked};
use crate::outside::{self, Outcome};
use crate::{Failure, studies};
use bench::alpha::Alpha;
use bench::diffsol_peer::{Diffsol, Method};
use bench::engine::Engine;
use bench::exponential::Exponential;
use bench::hybrid;
use bench::radau::Radau;
use bench::sampled::Sampled;
use bench::tabulated::Tabulated;
use bench::trajectory::{Peer, Shown, Task, Trajectory, Verdict};
use cpu_time::ProcessTime;
use indicatif::{ProgressBar, ProgressStyle};
use oracles::model::Model;
use oracles::reference::Record;
use serde::{Deserialize, Serialize};
use std::rc::Rc;

/// The engine with its certification off.
pub const SAMPLED: &str = "engine without its proof";

/// One solver at one setting.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Point {
    /// Solver.
    pub solver: String,
    /// Its tolerance or step.
    pub setting: String,
    /// CPU time of the cycle, s: fastest round.
    pub cpu: f64,
    /// Slowest round, s.
    pub slowest: f64,
    /// Preparation that is not in `cpu`, s.
    pub setup: f64,
    /// Errors and events; none if it failed.
    pub verdict: Option<Verdict>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// Solves once: what came out, and the CPU time, s.
type Solve<'a> = Box<dyn FnMut() -> Result<(Trajectory, f64), String> + 'a>;

struct Entry<'a> {
    solver: &'static str,
    setting: String,
    setup: f64,
    solve: Solve<'a>,
}

/// The field.
pub struct Contest<'a> {
    model: &'a Model<f64>,
    record: &'a Record,
    task: &'a Task,
    short: bool,
    entries: Vec<Entry<'a>>,
    absent: Vec<(String, String)>,
}

/// CPU time of `action`, s.
pub fn timed<T>(action: impl FnOnce() -> T) -> (T, f64) {
    let clock = ProcessTime::now();
    let result = action();
    (result, clock.elapsed().as_secs_f64())
}

impl<'a> Contest<'a> {
    /// Nobody yet.
    pub fn new(model: &'a Model<f64>, record: &'a Record, task: &'a Task, short: bool) -> Self {
        Self { model, record, task, short, entries: Vec::new(), absent: Vec::new() }
    }

    fn add(&mut self, solver: &'static str, setting: f64, setup: f64, solve: Solve<'a>) {
        let setting = if setting > 0.0 { format!("{setting:e}") } else { "none".into() };
        self.entries.push(Entry { solver, setting, setup, solve });
    }

    fn peer(
        &mut self,
        solver: &'static str,
        setting: f64,
        make: impl FnOnce() -> Box<dyn Peer + 'a>,
    ) {
        let (mut peer, setup) = timed(make);
        let task = self.task;
        let solve: Solve = Box::new(move || {
            let (done, cpu) = timed(|| peer.run(task));
            Ok((done?, cpu))
        });
        self.add(solver, setting, setup, solve);
    }

    /// Ours, in process and as a host sees it.
    pub fn add_engine(&mut self, library: &'a Unpacked) -> Result<(), Failure> {
        let task = self.task;
        let repeats = if self.short { 3 } else { 30 };
        let (mut machine, setup) = timed(studies::Warm::new);
        let solve: Solve = Box::new(move || {
            let done = Engine { parameters: Default::default() }.run(task)?;
            Ok((done, machine.cycle(task.end, 1e-3, repeats)))
        });
        self.add("this engine", 0.0, setup, solve);
        let mut instance = Instance::new(library)?;
        let references = SHOWN.map(|name| library.reference(name));
        let solve: Solve = Box::new(move || {
            let done = through_fmi(&mut instance, &references, task);
            Ok((done, studies::fmi_cycle(&mut instance, task.end, 1e-3, &[], repeats)))
        });
        self.add("this engine, fmi2DoStep", 0.0, 0.0, solve);
        Ok(())
    }

    /// Everything compiled into this program.
    pub fn add_compiled(&mut self) {
        let (model, task) = (self.model, self.task);
        let few = |all: &'static [f64], short: bool| if short { &all[..2] } else { all };
        for &d in few(&[2.5e-7, 5e-7, 1e-6, 2e-6, 4e-6], self.short) {
            let sampled = || Sampled::new(Default::default(), d).expect("the engine's own scene");
            self.peer(SAMPLED, d, || Box::new(sampled()));
        }
        for &d in few(&[2e-6, 1e-6, 7e-7, 5e-7, 2.5e-7], self.short) {
            self.peer("tabulated propagators", d, || Box::new(Tabulated::new(model, d)));
        }
        for &e in few(&[1e-4, 1e-5, 1e-6, 1e-7, 1e-8], self.short) {
            self.peer("Radau IIA-5, adaptive", e, move || {
                Box::new(Stepper { model, task, method: Radau::adaptive(model, e) })
            });
        }
        for &h in few(&[1e-6, 4e-7, 2e-7, 1e-7, 5e-8], self.short) {
            self.peer("Radau IIA-5, fixed", h, move || {
                Box::new(Stepper { model, task, method: Radau::fixed(model, h) })
            });
        }
        for &h in few(&[2e-7, 1e-7, 5e-8, 2e-8, 1e-8], self.short) {
            self.peer("generalised-alpha", h, move || {
                Box::new(Stepper { model, task, method: Alpha::new(model, h, 0.8) })
            });
        }
        for &e in few(&[1e-4, 1e-6, 1e-8, 1e-10], self.short) {
            self.peer("exponential, Taylor", e, move || {
                Box::new(Stepper { model, task, method: Exponential::new(model, e) })
            });
        }
        for (solver, method, settings) in [
            ("diffsol Tsit45", Method::Tsit45, &[1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11]),
            ("diffsol ESDIRK34", Method::Esdirk34, &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11]),
            ("diffsol BDF", Method::Bdf, &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11]),
        ] {
            for &tolerance in few(settings, self.short) {
                self.peer(solver, tolerance, || Box::new(Diffsol { model, method, tolerance }));
            }
        }
    }

    /// SUNDIALS, if its development package and a C compiler are there.
    pub fn add_sundials(&mut self) {
        let program = match outside::sundials() {
            Ok(program) => Rc::new(program),
            Err(reason) => return self.absent.push(("SUNDIALS".into(), reason.to_string())),
        };
        let Ok(system) = outside::export(self.model).map(Rc::new) else { return };
        for (solver, method, settings) in [
            ("CVODE Adams", "adams", &[1e-6, 1e-8, 1e-9, 1e-10, 1e-12]),
            ("CVODE BDF", "bdf", &[1e-5, 1e-7, 1e-8, 1e-9, 1e-10]),
            ("ARKODE ERK5", "erk", &[1e-5, 1e-7, 1e-9, 1e-10, 1e-11]),
        ] {
            for &tolerance in settings.iter().take(if self.short { 1 } else { 9 }) {
                let (program, system, task) = (program.clone(), system.clone(), self.task);
                let solve: Solve = Box::new(move || {
                    outside::run_sundials(&program, &system, method, tolerance, task)
                        .map(Outcome::into)
                });
                self.add(solver, tolerance, 0.0, solve);
            }
        }
    }

    /// SciPy, in a virtual environment of its own.
    pub fn add_scipy(&mut self) -> Result<(), Failure> {
        let python = match outside::python() {
            Ok(python) => Rc::new(python),
            Err(reason) => {
                self.absent.push(("SciPy".into(), reason.to_string()));
                return Ok(());
            }
        };
        let system = Rc::new(outside::export(self.model)?);
        for (solver, method, settings) in [
            ("SciPy DOP853", "DOP853", &[1e-5, 1e-7, 1e-8, 1e-9, 1e-11]),
            ("SciPy LSODA", "LSODA", &[1e-6, 1e-7, 1e-8, 1e-9, 1e-11]),
            ("SciPy Radau", "Radau", &[1e-4, 1e-5, 1e-6, 1e-7, 1e-8]),
        ] {
            for &tolerance in settings.iter().take(if self.short { 1 } else { 9 }) {
                let (python, system, task) = (python.clone(), system.clone(), self.task);
                let solve: Solve = Box::new(move || {
                    outside::run_scipy(&python, &system, method, tolerance, task).map(Outcome::into)
                });
                self.add(solver, tolerance, 0.0, solve);
            }
        }
        Ok(())
    }

    /// All rounds: the points, and who was left out.
    pub fn run(mut self, rounds: usize) -> (Vec<Point>, Vec<(String, String)>) {
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}");
        let bar = ProgressBar::new((rounds * self.entries.len()) as u64)
            .with_style(style.expect("valid template"));
        let mut points: Vec<Option<Point>> = vec![None; self.entries.len()];
        for _ in 0..rounds {
            for (entry, point) in self.entries.iter_mut().zip(&mut points) {
                bar.set_message(format!("{} {}", entry.solver, entry.setting));
                // What failed once is not tried again.
                if point.as_ref().is_none_or(|p| p.failure.is_none()) {
                    let solved = (entry.solve)();
                    let judged = solved
                        .map(|(done, cpu)| (done.judge(self.model, self.record, self.task), cpu));
                    *point = Some(merge(entry, point.take(), judged));
                }
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        (points.into_iter().flatten().collect(), self.absent)
    }
}

fn merge(entry: &Entry, before: Option<Point>, judged: Result<(Verdict, f64), String>) -> Point {
    let (verdict, failure, cpu) = match judged {
        Ok((verdict, cpu)) => (Some(verdict), None, cpu),
        Err(reason) => (None, Some(reason), 0.0),
    };
    let (fastest, slowest) = before.map_or((cpu, cpu), |p| (p.cpu.min(cpu), p.slowest.max(cpu)));
    Point {
        solver: entry.solver.to_string(),
        setting: entry.setting.clone(),
        cpu: fastest,
        slowest,
        setup: entry.setup,
        verdict,
        failure,
    }
}

/// A one-step method behind the event-driven loop.
struct Stepper<'a, S> {
    model: &'a Model<f64>,
    task: &'a Task,
    method: S,
}

impl<S: hybrid::OneStep> Peer for Stepper<'_, S> {
    fn run(&mut self, _: &Task) -> Result<Trajectory, String> {
        hybrid::run(self.model, &mut self.method, self.task)
    }
}

/// Variables of the FMU in the order of [`Shown`], displacements then velocities.
const SHOWN: [&str; 7] = [
    "piston_position",
    "bit_position",
    "bit_tip_position",
    "contact_gap",
    "piston_velocity",
    "bit_velocity",
    "bit_tip_velocity",
];

/// The trajectory as a host sees it, with communication points at the instants.
fn through_fmi(instance: &mut Instance, references: &[u32; 7], task: &Task) -> Trajectory {
    instance.rewind();
    let mut done = Trajectory::default();
    let (mut time, mut values) = (0.0, [0.0; 7]);
    for stop in task.stops().take(task.instants.len()) {
        instance.step(time, stop - time);
        instance.read(references, &mut values);
        let [p, b, t, g, pv, bv, tv] = values;
        done.shown.push(Shown { displacements: [p, b, t, g], velocities: [pv, bv, tv] });
        time = stop;
    }
    done
}
