//! `cargo bench-report speed|face|cost`: measures, and writes a page of `reports/`.

mod contest;
mod face;
mod speed;

use bench::Failure;
use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use support::python::{Environment, Needs};
use support::run::{cargo, checkout, run, target};

#[derive(Clone, Copy, ValueEnum)]
enum Page {
    /// Time of a cycle against its error, beside general solvers (some minutes)
    Speed,
    /// What a call of the FMU costs (a minute)
    Face,
    /// CPU time of everything that users run (some minutes, besides building)
    Cost,
}

#[derive(Parser)]
#[command(about = "Measures speed, and writes a page of reports/")]
struct Arguments {
    /// Which page
    page: Page,
}

/// The folder of working files.
///
/// # Errors
/// If it cannot be made.
pub fn folder() -> Result<PathBuf, Failure> {
    let folder = target(&checkout()).join("bench-report");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// CPU time of `action`, s.
pub fn timed<T>(action: impl FnOnce() -> T) -> (T, f64) {
    let clock = ProcessTime::now();
    let result = action();
    (result, clock.elapsed().as_secs_f64())
}

/// `1.23 ms` and the like.
pub fn duration(seconds: f64) -> String {
    match seconds.abs() {
        s if s >= 1.0 => format!("{seconds:.2} s"),
        s if s >= 1e-3 => format!("{:.3} ms", seconds * 1e3),
        s if s >= 1e-6 => format!("{:.1} us", seconds * 1e6),
        _ => format!("{:.0} ns", seconds * 1e9),
    }
}

/// The results as a page, and as JSON for the figure and the front page.
pub struct Written {
    text: String,
    json: String,
    figure: bool,
}

fn draw(name: &Path, json: &str) -> Result<(), Failure> {
    let environment = Environment::prepare(&checkout(), Needs::Suite)?;
    let mut command = environment.command("python");
    command.arg("evidence/bench/figure.py").arg(name.with_extension("png"));
    let mut child = command.stdin(Stdio::piped()).spawn()?;
    child.stdin.take().ok_or("no pipe")?.write_all(json.as_bytes())?;
    if child.wait()?.success() { Ok(()) } else { Err("no figure".into()) }
}

/// Builds what `cost.py` measures, and runs it; its last line is the JSON.
fn cost() -> Result<Written, Failure> {
    let root = checkout();
    let examples =
        ["build", "--release", "-p", "dth-hammer", "--example", "runs", "--example", "fleet"];
    run(cargo(&root).args(examples))?;
    run(cargo(&root).args(["lab"]))?;
    let mut command = Environment::prepare(&root, Needs::Suite)?.command("python");
    command.arg("evidence/bench/cost.py");
    command.env("CARGO_TARGET_DIR", target(&root));
    let done = command.stderr(Stdio::inherit()).output()?;
    if !done.status.success() {
        return Err("cost.py failed".into());
    }
    let text = String::from_utf8(done.stdout)?;
    let (text, json) = text.trim_end().rsplit_once('\n').ok_or("nothing was measured")?;
    let [text, json] = [text.trim_end().to_owned() + "\n", json.to_owned()];
    Ok(Written { text, json, figure: false })
}

fn main() -> Result<(), Failure> {
    let (name, written) = match Arguments::parse().page {
        Page::Speed => ("speed-against-error", speed::page()?),
        Page::Face => ("face-cost", face::page()?),
        Page::Cost => ("cost", cost()?),
    };
    let path = checkout().join("reports").join(name).with_extension("md");
    std::fs::write(&path, written.text)?;
    std::fs::write(path.with_extension("json"), written.json.clone() + "\n")?;
    println!("{}", path.display());
    if written.figure { draw(&path, &written.json) } else { Ok(()) }
}
