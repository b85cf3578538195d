//! The project's own commands, as cargo aliases.
//!
//! Each builds what it needs, Python included, under cargo's target folder: a machine with Rust and Python 3.10 is
//! enough. Each prints its stages and how long they usually take.

mod suite;

use clap::{Parser, Subcommand};
use std::path::Path;
use std::process::{Command, ExitCode};
use suite::Suite;
use support::python::{Environment, Needs};
use support::run::{Failure, cargo, checkout, locked, run};
use support::toolchain::browser_lacks;

/// The importer is a workspace of its own.
const IMPORTER: &str = "tests/importer/Cargo.toml";
/// The fuzzer is another, built with a sanitizer.
const FUZZ: &str = "fuzz/Cargo.toml";

#[derive(Parser)]
#[command(about = "The project's own commands")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Package the FMU, simulate the reference hammer, print its table, draw its figure
    Demo,
    /// Pass every test, Rust and Python
    Suite(Suite),
    /// Formatting and lints of Rust and Python, types of the Python package
    Lint,
    /// Build the user guide into target/guide
    Docs {
        /// Measure anew what the guide tells of coupling and sweeps: some minutes
        #[arg(long)]
        measure: bool,
    },
    /// Write dist/lab/index.html, one page that runs the engine in a browser
    Lab {
        /// Options of the packager: `--output FILE`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    /// Write what the README says of speed and exactness, from the reports in reports/
    Front,
    /// Build the Python package with the FMU in it into dist/
    Wheel,
    /// All files of a release into dist/release: an .fmu and a wheel for each platform that
    /// this machine can build for, one .fmu for all, the laboratory, what they are made of,
    /// their hashes
    Ship,
}

fn main() -> ExitCode {
    let root = checkout();
    let done = match Arguments::parse().task {
        Task::Demo => demo(&root),
        Task::Suite(suite) => suite.pass(&root),
        Task::Lint => lint(&root),
        Task::Docs { measure } => docs(&root, measure),
        Task::Lab { options } => lab(&root, &options),
        Task::Front => front(&root),
        Task::Wheel => wheel(&root),
        Task::Ship => ship(&root),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

const IF_POSSIBLE: &str = "--if-possible";
/// Options for a quick build of the FMU for this machine.
const QUICK: &[&str] = &["--quick"];

/// Prints the name of a stage, and how long it usually takes on two cores.
fn begin(what: &str, usual: &str) {
    println!("--- {what} ({usual})");
}

fn fmu(root: &Path, options: &[&str]) -> Result<(), Failure> {
    begin("Build and pack the FMU", "1 to 3 minutes the first time, then seconds");
    run(packager(root).arg("fmu").args(options))
}

/// The packager, in the profile of the library for tests and the demo, so that the engine is built once.
fn packager(root: &Path) -> Command {
    let mut command = locked(root, "run");
    command.args(["--quiet", "--profile", "native", "--package", "packaging", "--"]);
    command
}

fn lab(root: &Path, options: &[String]) -> Result<(), Failure> {
    // A missing tool is reported before minutes of compiling.
    if let Some(what) = browser_lacks().filter(|_| !options.contains(&IF_POSSIBLE.to_owned())) {
        return Err(Failure::Missing(format!("the laboratory: {what}")));
    }
    begin("Build the laboratory", "2 minutes the first time, then seconds");
    run(packager(root).arg("lab").args(options))
}

/// Builds the laboratory. If its tools are missing, it is left out, except in CI.
fn laboratory(root: &Path) -> Result<(), Failure> {
    lab(root, &if in_ci() { vec![] } else { vec![IF_POSSIBLE.to_owned()] })
}

fn python(root: &Path, needs: Needs) -> Result<Environment, Failure> {
    begin("Install the pinned Python packages", "1 to 3 minutes the first time, then nothing");
    Environment::prepare(root, needs)
}

/// True in CI, where everything that can be installed must be installed.
fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty())
}

fn demo(root: &Path) -> Result<(), Failure> {
    fmu(root, QUICK)?;
    let python = python(root, Needs::Demo)?;
    begin("Simulate the reference hammer and draw its figure", "5 seconds");
    run(python.command("python").arg("demo/reference.py"))
}

fn lint(root: &Path) -> Result<(), Failure> {
    begin("Format", "seconds");
    run(cargo(root).args(["fmt", "--all", "--check"]))?;
    for apart in [IMPORTER, FUZZ] {
        run(cargo(root).args(["fmt", "--check", "--manifest-path", apart]))?;
    }
    begin("Clippy", "2 minutes the first time");
    let every = ["--workspace", "--all-targets", "--features", "verify/programs"];
    run(locked(root, "clippy").args(every).args(["--quiet", "--", "-D", "warnings"]))?;
    begin("Documentation of the crates", "1 minute the first time");
    let options = ["--workspace", "--no-deps", "--quiet"];
    run(locked(root, "doc").env("RUSTDOCFLAGS", "-D warnings").args(options))?;
    let python = python(root, Needs::Suite)?;
    begin("ruff and mypy", "seconds");
    run(python.command("ruff").args(["check", "."]))?;
    run(python.command("ruff").args(["format", "--check", "."]))?;
    run(&mut python.command("mypy"))
}

fn docs(root: &Path, measure: bool) -> Result<(), Failure> {
    fmu(root, QUICK)?;
    laboratory(root)?;
    let python = python(root, Needs::Guide)?;
    if measure {
        begin("Measure what the guide tells", "some minutes");
        run(python.command("python").arg("guide/measure.py"))?;
    }
    begin("Build the guide", "1 minute");
    run(python.command("python").arg("guide/build.py"))
}

fn front(root: &Path) -> Result<(), Failure> {
    let python = python(root, Needs::Wheel)?;
    run(python.command("python").arg("guide/front.py"))
}

fn wheel(root: &Path) -> Result<(), Failure> {
    fmu(root, &[])?;
    let python = python(root, Needs::Wheel)?;
    run(python.command("python").args(["packaging/wheels.py", "dist/dth_hammer.fmu", "dist"]))?;
    println!("To install it: pip install --find-links dist 'dth-hammer[all]'");
    Ok(())
}

fn ship(root: &Path) -> Result<(), Failure> {
    begin("Build the FMU for every platform", "10 minutes the first time");
    run(packager(root).arg("release"))?;
    laboratory(root)?;
    let python = python(root, Needs::Release)?;
    run(python.command("python").arg("packaging/release.py"))
}
