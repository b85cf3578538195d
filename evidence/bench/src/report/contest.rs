//! The contest: every solver with its settings, in turn, round after round.

use crate::{folder, timed};
use bench::Failure;
use bench::diffsol_peer::{Diffsol, Method};
use bench::engine::{Engine, machine};
use bench::heyoka::{self, Heyoka};
use bench::schema::{Answer, Peer, Task, Verdict};
use bench::sundials::{Sundials, compile};
use hammer::{Fidelity, Parameters, Source};
use indicatif::ProgressBar;
use oracles::model::Model;
use oracles::reference::Solution;
use serde::Serialize;
use verify::reference::overdamped;

/// Communication step of the engine's row, s.
const STEP: f64 = 1e-3;
/// Cycles in one round of the engine's row.
const REPEATS: u32 = 30;
/// Elements per bar of the hammer that all solve.
pub const ELEMENTS: usize = 20;

/// One solver at one setting.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Solver.
    pub solver: &'static str,
    /// Its tolerance or step.
    pub setting: String,
    /// CPU time of the cycle, s: fastest round.
    pub cpu: f64,
    /// CPU time of the slowest round, s.
    pub slowest: f64,
    /// Preparation that is not in `cpu`, s.
    pub setup: f64,
    /// Errors and events; none if the solver failed.
    pub verdict: Option<Verdict>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// The hammer driven by air: the reference hammer with rigid bodies.
pub fn aired() -> Parameters {
    let mut parameters = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    parameters.drive.source = Source::Air;
    parameters
}

const ADAMS: (&str, &str) = ("CVODE Adams", "adams");
const ERK: (&str, &str) = ("ARKODE ERK5", "erk");

/// Solves once. Returns the answer and the CPU time, s.
type Solve<'a> = Box<dyn FnMut() -> Result<(Answer, f64), String> + 'a>;

/// All solvers with their settings.
pub struct Contest<'a> {
    model: &'a Model<f64>,
    exact: &'a Solution,
    task: &'a Task,
    entries: Vec<(Point, Solve<'a>)>,
    /// Solvers that were left out, and the reasons.
    pub absent: Vec<(&'static str, String)>,
}

impl<'a> Contest<'a> {
    /// A contest without solvers.
    pub fn new(model: &'a Model<f64>, exact: &'a Solution, task: &'a Task) -> Self {
        Self { model, exact, task, entries: Vec::new(), absent: Vec::new() }
    }

    /// Adds the engine and the other solvers.
    pub fn of_steel(mut self) -> Result<Self, Failure> {
        let model = self.model;
        self.add_engine(overdamped(ELEMENTS), 0.0);
        for (solver, method) in [
            ("diffsol Tsit45", Method::Tsit45),
            ("diffsol ESDIRK34", Method::Esdirk34),
            ("diffsol BDF", Method::Bdf),
        ] {
            for tolerance in [1e-6, 1e-7, 1e-8, 1e-9, 1e-11] {
                self.add(solver, tolerance, || Box::new(Diffsol { model, method, tolerance }));
            }
        }
        self.add_sundials([ADAMS, ("IDA (BDF, mass form)", "ida"), ERK])?;
        Ok(self)
    }

    /// The same for a hammer driven by air.
    pub fn of_air(mut self) -> Result<Self, Failure> {
        for error in [1e-4, 1e-6, 1e-8, 1e-10] {
            let mut parameters = aired();
            parameters.air.error = error;
            self.add_engine(parameters, error);
        }
        self.add_heyoka()?;
        self.add_sundials([ADAMS, ("CVODE BDF", "bdf"), ERK])?;
        Ok(self)
    }

    fn add_heyoka(&mut self) -> Result<(), Failure> {
        if let Err(reason) = heyoka::install() {
            self.absent.push(("heyoka", reason.to_string()));
            return Ok(());
        }
        let (model, folder) = (self.model, folder()?);
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let peer = Heyoka { model, folder: folder.clone(), tolerance };
            self.add("heyoka", tolerance, || Box::new(peer));
        }
        Ok(())
    }

    fn enter(&mut self, solver: &'static str, setting: f64, setup: f64, solve: Solve<'a>) {
        let setting = if setting > 0.0 { format!("{setting:e}") } else { "none".into() };
        let (cpu, slowest) = (f64::INFINITY, 0.0);
        let point = Point { solver, setting, cpu, slowest, setup, verdict: None, failure: None };
        self.entries.push((point, solve));
    }

    fn add(
        &mut self,
        solver: &'static str,
        setting: f64,
        make: impl FnOnce() -> Box<dyn Peer + 'a>,
    ) {
        let (mut peer, setup) = timed(make);
        let task = self.task;
        let solve = move || {
            let (answer, cpu) = timed(|| peer.run(task));
            answer.map(|answer| (answer.cpu.unwrap_or(cpu), answer)).map(|(cpu, a)| (a, cpu))
        };
        self.enter(solver, setting, setup, Box::new(solve));
    }

    /// Adds the engine. Its systems are decomposed beforehand, as are the other solvers' tables and factors.
    fn add_engine(&mut self, parameters: Parameters, setting: f64) {
        let task = self.task;
        let (mut warm, setup) = timed(|| {
            let mut machine = machine(&parameters);
            let rest = machine.state();
            machine.advance(task.end).expect("a cycle runs");
            (machine, rest)
        });
        let solve = move || {
            let answer = Engine(parameters).run(task)?;
            let (machine, rest) = &mut warm;
            let mut total = 0.0;
            for _ in 0..REPEATS {
                machine.restore(rest).map_err(|e| e.to_string())?;
                let run = || (1..).map(|k| f64::from(k) * STEP).take_while(|t| *t < task.end);
                let cycle = || run().chain([task.end]).try_for_each(|t| machine.advance(t));
                let (done, cpu) = timed(cycle);
                done.map_err(|e| e.to_string())?;
                total += cpu;
            }
            Ok((answer, total / f64::from(REPEATS)))
        };
        self.enter("this engine", setting, setup, Box::new(solve));
    }

    fn add_sundials(&mut self, methods: [(&'static str, &'static str); 3]) -> Result<(), Failure> {
        let program: &'a std::path::Path = match compile(&folder()?) {
            Ok(program) => Box::leak(program.into_boxed_path()),
            Err(reason) => {
                self.absent.push(("SUNDIALS", reason.to_string()));
                return Ok(());
            }
        };
        let model = self.model;
        for (solver, method) in methods {
            let settings = match method {
                "adams" => [1e-6, 1e-8, 1e-9, 1e-10, 1e-12],
                "erk" => [1e-5, 1e-7, 1e-9, 1e-10, 1e-11],
                _ => [1e-5, 1e-7, 1e-8, 1e-9, 1e-10],
            };
            for tolerance in settings {
                let peer = Sundials { model, program, method, tolerance };
                self.add(solver, tolerance, || Box::new(peer));
            }
        }
        Ok(())
    }

    /// Runs all rounds. A solver that has failed is not run again.
    pub fn run(&mut self, rounds: usize) -> Vec<Point> {
        let bar = ProgressBar::new((rounds * self.entries.len()) as u64);
        for _ in 0..rounds {
            for (point, solve) in &mut self.entries {
                bar.inc(1);
                if point.failure.is_some() {
                    continue;
                }
                match solve() {
                    Ok((answer, cpu)) => {
                        point.setup = answer.setup.unwrap_or(point.setup);
                        point.verdict = Some(answer.judge(self.exact, self.task));
                        point.cpu = point.cpu.min(cpu);
                        point.slowest = point.slowest.max(cpu);
                    }
                    Err(reason) => (point.failure, point.cpu) = (Some(reason), 0.0),
                }
            }
        }
        bar.finish_and_clear();
        self.entries.iter().map(|(point, _)| point.clone()).collect()
    }
}
