//! `cargo suite`: every test, in stages that are reported by name and time.

use crate::{QUICK, begin, fmu, laboratory, lint, python};
use clap::{Args, ValueEnum};
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use std::{sync::Mutex, thread};
use support::python::{Needs, PREPARED};
use support::run::{Failure, locked, run};

/// Tests in a browser; their pages are built before.
const IN_A_BROWSER: [&str; 9] = [
    "tests/python/test_laboratory.py",
    "tests/python/test_laboratory_air.py",
    "tests/python/test_laboratory_casing.py",
    "tests/python/test_laboratory_screens.py",
    "tests/python/test_laboratory_texts.py",
    "tests/python/test_laboratory_tools.py",
    "tests/python/test_page.py",
    "tests/python/test_sheet.py",
    "python/tests/test_guide_site.py",
];
/// Tests of hosts in C++, each in its own process, since two of them in one process have corrupted the heap.
const NATIVE: (&str, [&str; 2]) = ("tests/python/test_hosts_of_systems.py", ["libcosim", "ecos"]);
/// A process for each core. Tests of a file, which share prepared data, first stay together.
const IN_PARALLEL: [&str; 4] = ["--numprocesses", "auto", "--dist", "worksteal"];
/// pytest's exit code if a selection contains no test.
const NONE_CHOSEN: i32 = 5;

/// A part of what CI does.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Stage {
    /// Formatting and lints of Rust and Python, types, documentation without a warning
    Lint,
    /// Tests in Rust: of the engine, its oracles and their comparison, the FMU's library, the tools
    Rust,
    /// Tests of the FMU in hosts, of the Python package and of the examples
    Python,
    /// Tests of the laboratory and the pages in a browser
    Lab,
}

/// What is to be tested.
#[derive(Args)]
pub struct Suite {
    /// Only this stage; several may be given
    #[arg(long = "stage", value_enum, ignore_case = true, default_values = ["rust", "python", "lab"])]
    stages: Vec<Stage>,
    /// With the libraries for Windows, old Linux and aarch64, run where that can be
    #[arg(long)]
    all_platforms: bool,
    /// Handed to pytest, for instance `-k coupling`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pytest: Vec<String>,
}

impl Suite {
    /// Passes the stages, of several those of Rust beside those of Python: alone, each leaves a core idle for a
    /// third of its time. What fails stops no other.
    pub fn pass(&self, root: &Path) -> Result<(), Failure> {
        if let [stage] = self.stages[..] {
            return self.prepare(root).and_then(|()| self.stage(root, stage));
        }
        let failed = Mutex::new(String::new());
        let pass = |stage: Stage| {
            if self.stages.contains(&stage) {
                let begun = Instant::now();
                let result = self.beside(stage);
                let verdict = if result.is_ok() { "passed" } else { "FAILED" };
                println!("=== {stage:?} {verdict} in {:.0} s", begun.elapsed().as_secs_f64());
                if let Err(failure) = result {
                    eprintln!("error: {failure}");
                    *failed.lock().expect("no stage panics") += &format!(" {stage:?}");
                }
            }
        };
        thread::scope(|scope| {
            // Lints last: they want the Python that is installed meanwhile.
            scope.spawn(|| [Stage::Rust, Stage::Lint].map(pass));
            self.prepare(root)?;
            scope.spawn(|| pass(Stage::Lab));
            pass(Stage::Python);
            Ok(())
        })?;
        let failed = failed.into_inner().expect("no stage panics");
        if failed.is_empty() { Ok(()) } else { Err(Failure::Stages(failed)) }
    }

    /// Builds what the Python stages share.
    fn prepare(&self, root: &Path) -> Result<(), Failure> {
        let alone = std::env::var_os(PREPARED).is_none();
        let wants = |some: &[Stage]| alone && some.iter().any(|one| self.stages.contains(one));
        if wants(&[Stage::Lint, Stage::Python, Stage::Lab]) {
            python(root, Needs::Suite)?;
        }
        if wants(&[Stage::Python, Stage::Lab]) {
            fmu(root, if self.all_platforms { &["--all-platforms"] } else { QUICK })?;
        }
        if wants(&[Stage::Lab]) { laboratory(root) } else { Ok(()) }
    }

    /// Runs a stage in a process of its own, and prints its lines with its name as they come.
    fn beside(&self, stage: Stage) -> Result<(), Failure> {
        let program = format!("{stage:?}");
        let start = |source| Failure::Start { program: program.clone(), source };
        let (lines, end) = io::pipe().map_err(start)?;
        // By its path, since cargo replaces the file during the tests.
        let mut command = Command::new(std::env::args_os().next().unwrap_or_default());
        command.args(["suite", "--stage", &program]).args(&self.pytest).env(PREPARED, "1");
        command.stdout(end.try_clone().map_err(start)?).stderr(end);
        let mut child = command.spawn().map_err(start)?;
        drop(command); // It holds the pipe's end, after which its lines end.
        for line in BufReader::new(lines).split(b'\n').map_while(Result::ok) {
            println!("{program} | {}", String::from_utf8_lossy(&line));
        }
        let status = child.wait().map_err(start)?;
        if status.success() { Ok(()) } else { Err(Failure::Status { program, status }) }
    }

    fn stage(&self, root: &Path, stage: Stage) -> Result<(), Failure> {
        match stage {
            Stage::Lint => lint(root),
            Stage::Rust => {
                begin("Tests in Rust", "6 minutes the first time, then 3");
                // All packages at once: fewer would need another build of the engine. Clippy compiles examples.
                ["--tests", "--doc"].into_iter().try_for_each(|which| {
                    run(locked(root, "test").args(["--workspace", "--no-fail-fast", which]))
                })
            }
            Stage::Python => {
                let mut others = IN_A_BROWSER.map(|file| format!("--ignore={file}")).to_vec();
                others.push(format!("--ignore={}", NATIVE.0));
                others.extend(IN_PARALLEL.map(String::from));
                self.pytest(root, &others, "5 minutes")?;
                for host in NATIVE.1 {
                    let chosen = [NATIVE.0, "-k", host].map(String::from);
                    self.pytest(root, &chosen, "20 seconds")?;
                }
                Ok(())
            }
            Stage::Lab => {
                let tests = IN_A_BROWSER.iter().chain(&IN_PARALLEL).map(|&word| word.into());
                self.pytest(root, &tests.collect::<Vec<_>>(), "2 minutes")
            }
        }
    }

    fn pytest(&self, root: &Path, tests: &[String], usual: &str) -> Result<(), Failure> {
        let python = python(root, Needs::Suite)?;
        begin("pytest", usual);
        match run(python.command("pytest").args(tests).args(&self.pytest)) {
            Err(Failure::Status { status, .. })
                if !self.pytest.is_empty() && status.code() == Some(NONE_CHOSEN) =>
            {
                Ok(())
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Words {
        #[command(flatten)]
        suite: Suite,
    }

    fn read(words: &[&str]) -> Suite {
        Words::parse_from([&["suite"], words].concat()).suite
    }

    #[test]
    fn pytest_gets_what_the_suite_does_not_know() {
        let suite = read(&["--all-platforms", "-k", "wine", "--pdb"]);
        assert!(suite.all_platforms);
        assert_eq!(suite.pytest, ["-k", "wine", "--pdb"]);
        assert_eq!(suite.stages, [Stage::Rust, Stage::Python, Stage::Lab]);
        assert_eq!(read(&["--stage", "lab", "--stage", "Lint"]).stages, [Stage::Lab, Stage::Lint]);
    }
}
