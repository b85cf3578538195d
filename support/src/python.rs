//! The Python environment: made once under the target folder, from pinned versions whose files
//! have known hashes.

use crate::run::{Failure, answer, run_quietly, target};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Oldest Python that the pinned versions support, 3.x.
const OLDEST: u32 = 10;

/// The hashes of all pinned packages; `requirements/hashes.py` writes it.
const HASHES: &str = "hashes.txt";

/// Environment variable of a run beside others: the suite's environment is complete, and must not be changed.
pub const PREPARED: &str = "DTH_PREPARED";

/// What a task needs installed.
#[derive(Clone, Copy)]
pub enum Needs {
    /// Packing the wheel.
    Wheel,
    /// To run and plot.
    Demo,
    /// Also testing: everything of the demo, and more.
    Suite,
    /// Also building the user guide.
    Guide,
    /// General solvers beside the engine; nothing of the above.
    Peers,
    /// Linking for other machines; nothing of the above.
    Cross,
    /// Making wheels and the bill of materials of a release; nothing of the above.
    Release,
}

impl Needs {
    /// Files of pinned versions. Those of a smaller need come first in those of a larger one.
    fn files(self) -> &'static [&'static str] {
        // Those of the guide come last: the suite builds the guide too, but runs none of its pages.
        let all = &["demo.txt", "suite.txt", "python.txt", "hosts.txt", "guide.txt", "pages.txt"];
        match self {
            Self::Demo => &all[..1],
            Self::Suite => &all[..5],
            Self::Guide => all,
            Self::Peers => &["peers.txt"],
            Self::Cross => &["cross.txt"],
            Self::Wheel => &["wheel.txt"],
            Self::Release => &["release.txt"],
        }
    }

    /// Where the environment is, in cargo's target folder.
    fn folder(self) -> &'static str {
        match self {
            Self::Peers => "venv-peers",
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
    /// Makes the environment, or reuses it.
    pub fn prepare(root: &Path, needs: Needs) -> Result<Self, Failure> {
        let folder = target(root).join(needs.folder());
        let environment = Self { root: root.to_path_buf(), folder };
        if matches!(needs, Needs::Suite) && std::env::var_os(PREPARED).is_some() {
            return Ok(environment);
        }
        let python = Python::find()?;
        let pins = format!("# Python {}\n{}", python.version, environment.pins(needs)?);
        // The stamp is the text of the pins: equal texts mean equal packages. The suite's pins begin with the demo's,
        // so either serves the demo.
        let stamp = environment.folder.join("pins.txt");
        let installed = fs::read_to_string(&stamp).unwrap_or_default();
        if installed.starts_with(&pins) {
            environment.install_own(needs)?;
            return Ok(environment);
        }
        if installed.is_empty() || !pins.starts_with(&installed) {
            environment.create(&python)?;
        }
        environment.install(&pins)?;
        environment.install_own(needs)?;
        fs::write(&stamp, pins).map_err(|source| Failure::File { path: stamp, source })?;
        Ok(environment)
    }

    /// A Python with zig, and zig's version: that of the environment for other machines if it exists, otherwise one
    /// on the path.
    #[must_use]
    pub fn with_zig(root: &Path) -> Option<(PathBuf, String)> {
        let folder = target(root).join(Needs::Cross.folder());
        let made = Self { root: root.to_path_buf(), folder }.program("python");
        let named = std::env::var_os("PYTHON").map(PathBuf::from);
        let candidates = [Some(made), named, Some("python3".into())];
        let version =
            |python: &PathBuf| answer(Command::new(python).args(["-m", "ziglang", "version"]));
        candidates.into_iter().flatten().find_map(|python| {
            let version = version(&python)?;
            Some((python, version))
        })
    }

    /// Path of a program of the environment.
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
        let texts = needs.files().iter().map(|file| self.read(file));
        let texts: String = texts.collect::<Result<_, _>>()?;
        let pins = texts.lines().filter(|line| line.contains("=="));
        Ok(pins.flat_map(|line| [line, "\n"]).collect())
    }

    fn read(&self, file: &str) -> Result<String, Failure> {
        let path = self.root.join("requirements").join(file);
        fs::read_to_string(&path).map_err(|source| Failure::File { path, source })
    }

    fn create(&self, python: &Python) -> Result<(), Failure> {
        let mut command = Command::new(&python.program);
        // An incomplete environment, or one whose Python was removed, cannot be reused.
        command.args(["-m", "venv", "--clear"]).arg(&self.folder);
        run_quietly("Creating the Python environment", &mut command)
    }

    /// Installs exactly the pins, each from a file of a known hash: nothing is resolved.
    fn install(&self, pins: &str) -> Result<(), Failure> {
        let known = self.read(HASHES)?;
        let list = self.folder.join("hashed.txt");
        let text = with_hashes(pins, &known).map_err(Failure::NoHash)?;
        fs::write(&list, text).map_err(|source| Failure::File { path: list.clone(), source })?;
        let mut command = self.command("python");
        // What is imported is compiled then, a part of it.
        let options = ["--disable-pip-version-check", "--no-deps", "--require-hashes"];
        command.args(["-m", "pip", "install", "--no-compile", "--only-binary", ":all:"]);
        command.args(options);
        command.arg("--requirement").arg(list);
        run_quietly("Installing the pinned Python packages", &mut command)
    }

    /// Installs the project's own package as a link to its sources; its native module is rebuilt if they have
    /// changed.
    fn install_own(&self, needs: Needs) -> Result<(), Failure> {
        if !matches!(needs, Needs::Suite | Needs::Guide) {
            return Ok(());
        }
        let mut command = self.command("python");
        let options = ["--disable-pip-version-check", "--no-deps", "--no-build-isolation"];
        command.args(["-m", "pip", "install"]).args(options).args(["--editable", "python"]);
        command.env("MATURIN_PEP517_ARGS", "--locked").env("MATURIN_NO_INSTALL_RUST", "1");
        // pip calls maturin by its name.
        let programs = self.program("python").parent().map(Path::to_path_buf);
        let known = std::env::var_os("PATH").unwrap_or_default();
        let path = std::env::join_paths(programs.into_iter().chain(std::env::split_paths(&known)));
        command.envs(path.ok().map(|path| ("PATH", path)));
        run_quietly("Building the native module", &mut command)
    }
}

/// Each pin followed by its hashes, or an error with the pin that has none.
fn with_hashes(pins: &str, known: &str) -> Result<String, String> {
    // Spelled as in the package index.
    let plain = |pin: &str| pin.trim().to_lowercase().replace(['_', '.'], "-");
    let known: HashMap<String, &str> = known
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(pin, hashes)| (plain(pin), hashes))
        .collect();
    let line = |pin: &str| {
        let version = plain(pin.split(';').next().unwrap_or_default());
        let hashes = known.get(&version).ok_or_else(|| pin.to_owned())?;
        Ok(format!("{pin} {hashes}\n"))
    };
    pins.lines().filter(|pin| !pin.starts_with('#')).map(line).collect()
}

/// The Python that makes an environment.
struct Python {
    program: String,
    version: String,
}

impl Python {
    /// `PYTHON`, or the first Python on the path that is new enough.
    fn find() -> Result<Self, Failure> {
        let candidates = match std::env::var("PYTHON") {
            Ok(python) => vec![python],
            Err(_) => ["python3", "python", "python3.13", "python3.12", "python3.11", "python3.10"]
                .map(String::from)
                .to_vec(),
        };
        let check = format!(
            "import sys, venv; print(sys.version.split()[0]); sys.exit(sys.version_info < (3, {OLDEST}))"
        );
        let version = |program: &String| answer(Command::new(program).args(["-c", &check]));
        candidates
            .iter()
            .find_map(|program| Some(Self { program: program.clone(), version: version(program)? }))
            .ok_or_else(|| Failure::NoPython { minor: OLDEST, tried: candidates.join(", ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: &str = "# Written\nboolean-py==5.0 --hash=sha256:a --hash=sha256:b\n";

    #[test]
    fn a_pin_gets_its_hashes_by_the_name_that_the_index_spells() {
        let found = with_hashes("# Python\nboolean.py==5.0; python_version < \"3.11\"\n", KNOWN);
        let line = "boolean.py==5.0; python_version < \"3.11\" --hash=sha256:a --hash=sha256:b\n";
        assert_eq!(found.as_deref(), Ok(line));
    }

    #[test]
    fn a_pin_without_a_hash_is_refused() {
        assert_eq!(with_hashes("boolean.py==5.1", KNOWN), Err("boolean.py==5.1".into()));
    }
}
