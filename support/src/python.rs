//! The Python environment: made once under the target folder, from pinned versions.

use crate::run::{Failure, run_quietly, target};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Oldest Python that the pinned versions support, 3.x.
const OLDEST: u32 = 10;

/// Packages whose own pins contradict ours: installed without what they depend on.
const ALONE: &str = "hosts-alone.txt";

/// What a task wants installed.
#[derive(Clone, Copy)]
pub enum Needs {
    /// To pack the wheel; nothing of the others.
    Wheel,
    /// To run and plot.
    Demo,
    /// To test as well: all of the demo's, and more.
    Suite,
    /// To build the user guide as well.
    Guide,
    /// To link for other machines than this one; nothing of the above.
    Cross,
    /// To make wheels and the bill of materials of a release; nothing of the above.
    Release,
}

impl Needs {
    /// Files of pinned versions; of two needs, the smaller one's begin the larger one's.
    fn files(self) -> &'static [&'static str] {
        let all = &[
            "demo.txt",
            "suite.txt",
            "python.txt",
            "hosts.txt",
            ALONE,
            "guide.txt",
            "autograd.txt",
        ];
        match self {
            Self::Demo => &all[..1],
            // The guide is among what is tested.
            Self::Suite | Self::Guide => all,
            Self::Cross => &["cross.txt"],
            Self::Wheel => &["wheel.txt"],
            Self::Release => &["release.txt"],
        }
    }

    /// Where the environment is, in cargo's target folder.
    fn folder(self) -> &'static str {
        match self {
            Self::Cross => "venv-cross",
            Self::Wheel => "venv-wheel",
            Self::Release => "venv-release",
            Self::Demo | Self::Suite | Self::Guide => "venv",
        }
    }
}

/// A virtual environment whose packages match the pins.
pub struct Environment {
    root: PathBuf,
    folder: PathBuf,
}

impl Environment {
    /// Makes the environment, or finds it as an earlier run left it.
    pub fn prepare(root: &Path, needs: Needs) -> Result<Self, Failure> {
        let folder = target(root).join(needs.folder());
        let environment = Self { root: root.to_path_buf(), folder };
        let pins = environment.pins(needs)?;
        // The stamp holds the pins themselves: equal text means equal packages. The
        // suite's pins begin with the demo's, so either may be found where it has been.
        let stamp = environment.folder.join("pins.txt");
        let installed = fs::read_to_string(&stamp).unwrap_or_default();
        if installed.starts_with(&pins) {
            return Ok(environment);
        }
        if installed.is_empty() || !pins.starts_with(&installed) {
            environment.create()?;
        }
        environment.install(needs)?;
        fs::write(&stamp, pins).map_err(|source| Failure::File { path: stamp, source })?;
        Ok(environment)
    }

    /// Where a program of the environment is.
    pub fn program(&self, program: &str) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts" } else { "bin" }).join(program)
    }

    /// A program of the environment, to be run in the workspace.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new(self.program(program));
        command.current_dir(&self.root);
        command
    }

    fn pins(&self, needs: Needs) -> Result<String, Failure> {
        let mut pins = String::new();
        for file in needs.files() {
            let path = self.root.join("requirements").join(file);
            let text = fs::read_to_string(&path);
            pins += &text.map_err(|source| Failure::File { path, source })?;
        }
        Ok(pins)
    }

    fn create(&self) -> Result<(), Failure> {
        let python = find_python()?;
        let mut command = Command::new(python);
        // A half-made environment, or one of a Python since removed, is no base.
        command.args(["-m", "venv", "--clear"]).arg(&self.folder);
        run_quietly("Creating the Python environment", &mut command)
    }

    fn install(&self, needs: Needs) -> Result<(), Failure> {
        let (alone, together): (Vec<&str>, Vec<&str>) =
            needs.files().iter().partition(|file| **file == ALONE);
        self.install_files("Installing the pinned Python packages", &together, &[])?;
        if !alone.is_empty() {
            self.install_files("Installing foreign hosts", &alone, &["--no-deps"])?;
        }
        let own = matches!(needs, Needs::Suite | Needs::Guide);
        if own { self.install_own() } else { Ok(()) }
    }

    fn install_files(
        &self,
        message: &'static str,
        files: &[&str],
        more: &[&str],
    ) -> Result<(), Failure> {
        let mut command = self.command("python");
        let options = ["--disable-pip-version-check", "--only-binary", ":all:"];
        command.args(["-m", "pip", "install"]).args(options).args(more);
        for file in files {
            command.arg("--requirement").arg(Path::new("requirements").join(file));
        }
        run_quietly(message, &mut command)
    }

    /// The project's own package, as a link to its sources.
    fn install_own(&self) -> Result<(), Failure> {
        let mut command = self.command("python");
        let options = ["--disable-pip-version-check", "--no-deps", "--no-build-isolation"];
        command.args(["-m", "pip", "install"]).args(options).args(["--editable", "python"]);
        run_quietly("Installing dth-hammer", &mut command)
    }
}

/// The first Python on the path that is new enough; `PYTHON` goes before all.
fn find_python() -> Result<String, Failure> {
    let chosen = std::env::var("PYTHON").ok();
    let candidates: Vec<String> = match chosen {
        Some(python) => vec![python],
        None => ["python3", "python", "python3.13", "python3.12", "python3.11", "python3.10"]
            .map(String::from)
            .to_vec(),
    };
    let check = format!("import sys, venv; sys.exit(sys.version_info < (3, {OLDEST}))");
    let fits = |python: &&String| {
        let output = Command::new(python).args(["-c", &check]).output();
        output.is_ok_and(|done| done.status.success())
    };
    candidates
        .iter()
        .find(fits)
        .cloned()
        .ok_or_else(|| Failure::NoPython { minor: OLDEST, tried: candidates.join(", ") })
}
