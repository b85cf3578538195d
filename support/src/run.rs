//! Runs other programs, and reports their failures.

use indicatif::{ProgressBar, ProgressStyle};
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::Duration;

/// Why a task stopped.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The program could not be started.
    #[error("cannot start {program}: {source}")]
    Start {
        /// Its name.
        program: String,
        /// Why not.
        source: io::Error,
    },
    /// The program has failed, and has said why itself.
    #[error("{program} failed: {status}")]
    Status {
        /// Its name.
        program: String,
        /// How it ended.
        status: ExitStatus,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A pin whose files have no known hash.
    #[error("requirements/hashes.txt has no {0}: run requirements/hashes.py")]
    NoHash(String),
    /// Something to install first.
    #[error("cannot build {0}")]
    Missing(String),
    /// Some stages of the suite failed; each has said why.
    #[error("failed:{0}")]
    Stages(String),
    /// No Python to make an environment with.
    #[error("no Python of at least 3.{minor} found: tried {tried}")]
    NoPython {
        /// The oldest that would do.
        minor: u32,
        /// What was tried.
        tried: String,
    },
}

/// The checkout that this run is about: the one around the package that `cargo run` runs, otherwise around the working
/// folder. A path from compile time would be that of another checkout once this one was copied or moved.
#[must_use]
pub fn checkout() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let here = std::env::current_dir().unwrap_or_default();
    let is_checkout = |folder: &&Path| folder.join("xtask/Cargo.toml").is_file();
    let around = |place: &PathBuf| place.ancestors().find(is_checkout).map(PathBuf::from);
    package.iter().chain([&here]).find_map(around).unwrap_or_else(|| here.clone())
}

/// Folder of cargo's builds and of the project's environments.
pub fn target(root: &Path) -> PathBuf {
    root.join(std::env::var_os("CARGO_TARGET_DIR").map_or("target".into(), PathBuf::from))
}

/// The cargo that runs this task, in the workspace.
pub fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

/// A cargo command that must not change `Cargo.lock`.
pub fn locked(root: &Path, task: &str) -> Command {
    let mut command = cargo(root);
    command.args([task, "--locked"]);
    command
}

fn name(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let first = command.get_args().next().unwrap_or_default();
    [program, first].map(OsStr::to_string_lossy).join(" ").trim().to_string()
}

/// Runs a program that talks to the terminal itself.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let program = name(command);
    let status = command.status();
    let status = status.map_err(|source| Failure::Start { program: program.clone(), source })?;
    if status.success() { Ok(()) } else { Err(Failure::Status { program, status }) }
}

/// The one line that a program prints; none if the program is missing or fails.
pub fn answer(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Runs a program behind a progress line; its output is shown only if it fails.
pub fn run_quietly(message: &'static str, command: &mut Command) -> Result<(), Failure> {
    let program = name(command);
    let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}").expect("valid template");
    let bar = ProgressBar::new_spinner().with_style(style).with_message(message);
    if bar.is_hidden() {
        println!("{message}");
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    let output = command.output();
    bar.finish_and_clear();
    let output = output.map_err(|source| Failure::Start { program: program.clone(), source })?;
    if output.status.success() {
        return Ok(());
    }
    eprint!("{}", String::from_utf8_lossy(&output.stdout));
    eprint!("{}", String::from_utf8_lossy(&output.stderr));
    Err(Failure::Status { program, status: output.status })
}
