//! SUNDIALS, in a separate C program that reads a [`Case`].

use crate::Failure;
use crate::schema::{Answer, Case, Peer, Task};
use oracles::model::Model;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::run::checkout;

/// One of SUNDIALS' methods (`ida`, `adams`, `erk` or `bdf`) with its tolerance: relative, and absolute over 1 mm, 1
/// m/s, 1 J.
pub struct Sundials<'a> {
    /// The hammer.
    pub model: &'a Model<f64>,
    /// The compiled program.
    pub program: &'a Path,
    /// Method.
    pub method: &'static str,
    /// Tolerance.
    pub tolerance: f64,
}

/// Compiles the program into a folder.
///
/// # Errors
/// If there is no C compiler or no SUNDIALS.
pub fn compile(folder: &Path) -> Result<PathBuf, Failure> {
    let source = checkout().join("evidence/bench/sundials_peer.c");
    let program = folder.join("sundials_peer");
    let libraries = [
        "ida",
        "cvode",
        "arkode",
        "nvecserial",
        "sunmatrixband",
        "sunlinsolband",
        "sunmatrixdense",
        "sunlinsoldense",
    ];
    let mut command = Command::new("cc");
    command.arg("-O3").arg(source).arg("-o").arg(&program);
    command.args(libraries.map(|name| format!("-lsundials_{name}")));
    command.args(["-lsundials_sunnonlinsolfixedpoint", "-lm"]);
    match command.output() {
        Ok(output) if output.status.success() => Ok(program),
        _ => Err("needs a C compiler and SUNDIALS 6 (Debian: libsundials-dev)".into()),
    }
}

impl Peer for Sundials<'_> {
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let case = self.program.with_file_name("case.json");
        let json = serde_json::to_string(&Case::new(self.model, task)).map_err(|e| text(&e))?;
        std::fs::write(&case, json).map_err(|e| text(&e))?;
        let mut command = Command::new(self.program);
        command.arg(case).arg(self.method).arg(format!("{:e}", self.tolerance));
        let output = command.output().map_err(|e| text(&e))?;
        let answer: Answer = serde_json::from_slice(&output.stdout).map_err(|e| text(&e))?;
        answer.failure.clone().map_or(Ok(answer), Err)
    }
}
