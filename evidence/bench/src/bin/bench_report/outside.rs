//! Solvers of other houses: a virtual environment for SciPy, a C program for SUNDIALS.

use crate::{Failure, root, target};
use bench::trajectory::{Task, Trajectory};
use oracles::law::{Event, State};
use oracles::model::Model;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// One line of another program's answer.
#[derive(Deserialize)]
pub struct Outcome {
    #[serde(default)]
    cpu: f64,
    #[serde(default)]
    states: Vec<Vec<f64>>,
    #[serde(default)]
    events: Vec<(f64, Event)>,
    failure: Option<String>,
}

impl From<Outcome> for (Trajectory, f64) {
    fn from(outcome: Outcome) -> Self {
        let states = outcome.states.iter().map(|row| {
            let (u, v) = row.split_at(row.len() / 2);
            State { u: u.to_vec(), v: v.to_vec(), psi: 0.0 }
        });
        let trajectory =
            Trajectory { states: states.collect(), events: outcome.events, ..Default::default() };
        (trajectory, outcome.cpu)
    }
}

fn folder() -> Result<PathBuf, Failure> {
    let folder = target().join("bench-report");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The assembled system as a file.
pub fn export(model: &Model<f64>) -> Result<PathBuf, Failure> {
    let path = folder()?.join("system.txt");
    std::fs::write(&path, bench::export::text(model))?;
    Ok(path)
}

fn succeed(command: &mut Command) -> Result<Output, Failure> {
    let output = command.output()?;
    if output.status.success() {
        return Ok(output);
    }
    let text = String::from_utf8_lossy(&output.stderr);
    Err(text.lines().last().unwrap_or("failed").to_string().into())
}

/// Compiles the C program.
pub fn sundials() -> Result<PathBuf, Failure> {
    let program = folder()?.join("sundials_peer");
    let libraries = ["cvode", "arkode", "nvecserial", "sunmatrixband", "sunlinsolband"];
    let mut command = Command::new("cc");
    command.arg("-O3").arg(root().join("evidence/bench/sundials_peer.c")).arg("-o").arg(&program);
    command.args(libraries.map(|name| format!("-lsundials_{name}")));
    command.args(["-lsundials_sunnonlinsolfixedpoint", "-lm"]);
    match succeed(&mut command) {
        Ok(_) => Ok(program),
        Err(_) => Err("needs a C compiler and SUNDIALS 6 (Debian: libsundials-dev)".into()),
    }
}

/// Python with SciPy, numba and matplotlib.
pub fn python() -> Result<PathBuf, Failure> {
    let venv = target().join("bench-venv");
    let python = venv.join("bin/python");
    let pins = root().join("requirements/bench.txt");
    let (stamp, wanted) = (venv.join("pins.txt"), std::fs::read_to_string(&pins)?);
    if std::fs::read_to_string(&stamp).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    println!("Creating the Python environment");
    let base = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    succeed(Command::new(base).args(["-m", "venv", "--clear"]).arg(&venv))?;
    let options = ["-m", "pip", "install", "--quiet", "--only-binary", ":all:", "-r"];
    succeed(Command::new(&python).args(options).arg(&pins))?;
    std::fs::write(stamp, wanted)?;
    Ok(python)
}

fn answer(output: Output) -> Result<Outcome, String> {
    let text = String::from_utf8_lossy(&output.stdout);
    let outcome: Outcome = serde_json::from_str(text.trim()).map_err(|e| {
        let error = String::from_utf8_lossy(&output.stderr);
        error.lines().last().map_or_else(|| e.to_string(), str::to_string)
    })?;
    match outcome.failure {
        Some(reason) => Err(reason),
        None => Ok(outcome),
    }
}

/// One run of the C program.
pub fn run_sundials(
    program: &Path,
    system: &Path,
    method: &str,
    tolerance: f64,
    task: &Task,
) -> Result<Outcome, String> {
    let mut command = Command::new(program);
    command.arg(system).arg(method).arg(format!("{tolerance:e}"));
    command.arg(task.patience.to_string()).arg(task.end.to_string());
    command.args(task.instants.iter().map(f64::to_string));
    answer(command.output().map_err(|e| e.to_string())?)
}

/// One run of the Python script.
pub fn run_scipy(
    python: &Path,
    system: &Path,
    method: &str,
    tolerance: f64,
    task: &Task,
) -> Result<Outcome, String> {
    let instants: Vec<String> = task.instants.iter().map(f64::to_string).collect();
    let mut command = Command::new(python);
    command.arg(root().join("evidence/bench/scipy_peer.py")).arg(system).arg(task.end.to_string());
    command.arg(instants.join(",")).arg(format!("{method}:{tolerance:e}"));
    answer(command.output().map_err(|e| e.to_string())?)
}

/// Draws the figure beside the data.
pub fn draw(name: &Path) -> Result<(), Failure> {
    let script = root().join("evidence/bench/figure.py");
    let (data, figure) = (name.with_extension("json"), name.with_extension("svg"));
    succeed(Command::new(python()?).arg(script).arg(data).arg(figure))?;
    Ok(())
}
