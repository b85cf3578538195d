//! The project's own commands, as cargo aliases.
//!
//! `cargo demo` shows the reference hammer, `cargo suite` passes every test,
//! `cargo lint` checks form, `cargo docs` builds the user guide, `cargo wheel` the
//! Python package. Each builds what it needs, Python included, under
//! cargo's target folder: a machine with Rust and Python 3.10 is enough.

use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use support::python::{Environment, Needs};
use support::run::{Failure, answer, cargo, run, target};

/// A workspace of its own.
const IMPORTER: &str = "tests/importer/Cargo.toml";

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
    Suite {
        /// With the libraries for Windows, old Linux and aarch64, run where that can be
        #[arg(long)]
        all_platforms: bool,
        /// Handed to pytest, for instance `-k slicing`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        pytest: Vec<String>,
    },
    /// Formatting and lints of Rust and Python, types of the Python package
    Lint,
    /// Build the user guide into target/guide
    Docs {
        /// Measure anew what the guide tells of coupling and sweeps: some minutes
        #[arg(long)]
        measure: bool,
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
    let root = root();
    let done = match Arguments::parse().task {
        Task::Demo => demo(&root),
        Task::Suite { all_platforms, pytest } => suite(&root, all_platforms, &pytest),
        Task::Lint => lint(&root),
        Task::Docs { measure } => docs(&root, measure),
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

fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().expect("xtask is a member of a workspace").to_path_buf()
}

fn demo(root: &Path) -> Result<(), Failure> {
    run(cargo(root).arg("fmu"))?;
    let python = Environment::prepare(root, Needs::Demo)?;
    run(python.command("python").arg("demo/reference.py"))
}

fn suite(root: &Path, all_platforms: bool, pytest: &[String]) -> Result<(), Failure> {
    // First, so that a failing test is not found behind minutes of downloads.
    run(cargo(root).args(["test", "--workspace"]))?;
    let platforms = if all_platforms { &["--all-platforms"][..] } else { &[] };
    run(cargo(root).arg("fmu").args(platforms))?;
    run(cargo(root).args(["lab", "--if-possible"]))?;
    let python = Environment::prepare(root, Needs::Suite)?;
    run(python.command("pytest").args(pytest))
}

fn lint(root: &Path) -> Result<(), Failure> {
    run(cargo(root).args(["fmt", "--all", "--check"]))?;
    run(cargo(root).args(["fmt", "--check", "--manifest-path", IMPORTER]))?;
    let clippy = ["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"];
    run(cargo(root).args(clippy))?;
    let python = Environment::prepare(root, Needs::Suite)?;
    lint_importer(root, &python)?;
    run(python.command("ruff").args(["check", "."]))?;
    run(python.command("ruff").args(["format", "--check", "."]))?;
    run(&mut python.command("mypy"))
}

/// Its bindings are made by the libclang of the environment, with the headers of gcc.
fn lint_importer(root: &Path, python: &Environment) -> Result<(), Failure> {
    let headers = answer(Command::new("gcc").arg("-print-file-name=include"));
    let find = ["-c", "import clang, pathlib; print(pathlib.Path(clang.__path__[0], 'native'))"];
    let (Some(headers), Some(libclang)) = (headers, answer(python.command("python").args(find)))
    else {
        println!("skipped: clippy of {IMPORTER}, whose bindings need gcc's headers");
        return Ok(());
    };
    let mut command = cargo(root);
    command.env("LIBCLANG_PATH", libclang);
    command.env("BINDGEN_EXTRA_CLANG_ARGS", format!("-I{headers}"));
    command.args(["clippy", "--quiet", "--locked", "--all-targets", "--manifest-path", IMPORTER]);
    command.arg("--target-dir").arg(target(root).join("importer"));
    run(command.args(["--", "-D", "warnings"]))
}

fn docs(root: &Path, measure: bool) -> Result<(), Failure> {
    run(cargo(root).arg("fmu"))?;
    run(cargo(root).args(["lab", "--if-possible"]))?;
    let python = Environment::prepare(root, Needs::Guide)?;
    if measure {
        run(python.command("python").arg("guide/measure.py"))?;
    }
    run(python.command("python").arg("guide/build.py"))
}

fn front(root: &Path) -> Result<(), Failure> {
    let python = Environment::prepare(root, Needs::Wheel)?;
    run(python.command("python").arg("guide/front.py"))
}

fn wheel(root: &Path) -> Result<(), Failure> {
    run(cargo(root).arg("fmu"))?;
    let python = Environment::prepare(root, Needs::Wheel)?;
    run(python.command("python").args(["packaging/wheels.py", "dist/dth_hammer.fmu", "dist"]))?;
    println!("To install it: pip install --find-links dist dth-hammer");
    Ok(())
}

fn ship(root: &Path) -> Result<(), Failure> {
    run(cargo(root).args(["run", "--quiet", "--package", "packaging", "--", "release"]))?;
    run(cargo(root).args(["lab", "--if-possible"]))?;
    let python = Environment::prepare(root, Needs::Release)?;
    run(python.command("python").arg("packaging/release.py"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pytest_gets_what_the_suite_does_not_know() {
        let words = ["xtask", "suite", "--all-platforms", "-k", "wine", "--pdb"];
        let Task::Suite { all_platforms, pytest } = Arguments::parse_from(words).task else {
            panic!("another task");
        };
        assert!(all_platforms);
        assert_eq!(pytest, ["-k", "wine", "--pdb"]);
    }
}
