//! heyoka, in a Python program that reads a [`Case`].

use crate::Failure;
use crate::schema::{Answer, Case, Peer, Task};
use oracles::model::Model;
use std::path::PathBuf;
use support::python::{Environment, Needs};
use support::run::checkout;

/// Solutions of which the fastest counts: one takes less time than a process needs to warm up.
const REPEATS: &str = "30";

/// heyoka's Taylor integrator with its tolerance. It measures its own time and set-up.
pub struct Heyoka<'a> {
    /// The hammer: rigid, and driven by air.
    pub model: &'a Model<f64>,
    /// Where the case is written.
    pub folder: PathBuf,
    /// Tolerance, relative; absolute over 10 mm, 1 m/s, 10 g, 1 kJ.
    pub tolerance: f64,
}

/// Installs heyoka.
///
/// # Errors
/// Where there is no such package for the machine.
pub fn install() -> Result<Environment, Failure> {
    Ok(Environment::prepare(&checkout(), Needs::Peers)?)
}

impl Heyoka<'_> {
    fn solve(&self, task: &Task) -> Result<Answer, Failure> {
        let case = self.folder.join("air_case.json");
        std::fs::write(&case, serde_json::to_string(&Case::new(self.model, task))?)?;
        let mut command = install()?.command("python");
        command.arg("evidence/bench/heyoka_peer.py").arg(case);
        let output = command.arg(format!("{:e}", self.tolerance)).arg(REPEATS).output()?;
        if output.status.success() {
            return Ok(serde_json::from_slice(&output.stdout)?);
        }
        Err(String::from_utf8_lossy(&output.stderr).into())
    }
}

impl Peer for Heyoka<'_> {
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        self.solve(task).map_err(|error| error.to_string())
    }
}
