//! `cargo suite`: every test, in stages that are reported by name and time.

use crate::{QUICK, begin, fmu, laboratory, lint, python};
use clap::{Args, ValueEnum};
use std::fmt;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use std::{sync::Mutex, thread};
use support::python::{Needs, PREPARED};
use support::run::{Failure, answer, locked, run};

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
    /// Runs the stages, of several those of Rust beside those of Python: alone, each leaves a core idle for a
    /// third of its time. What fails stops no other. What cannot run here is said at the beginning and at the end.
    pub fn pass(&self, root: &Path) -> Result<(), Failure> {
        if let [stage] = self.stages[..] {
            return self.prepare(root).and_then(|()| self.stage(root, stage));
        }
        let lacking = equip(root)?;
        if let Some(what) = &lacking {
            println!("--- Some tests cannot run here: {what}");
        }
        let verdicts = Mutex::new(Vec::new());
        let pass = |stage: Stage| {
            if self.stages.contains(&stage) {
                let begun = Instant::now();
                let verdict = self.beside(stage);
                println!("=== {stage:?} {verdict} in {:.0} s", begun.elapsed().as_secs_f64());
                verdicts.lock().expect("no stage panics").push((stage, verdict));
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
        conclude(&verdicts.into_inner().expect("no stage panics"), lacking)
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
    fn beside(&self, stage: Stage) -> Verdict {
        let name = format!("{stage:?}");
        let mut skipped = Vec::new();
        let mut run = || -> io::Result<bool> {
            let (lines, end) = io::pipe()?;
            // By its path, since cargo replaces the file during the tests.
            let mut command = Command::new(std::env::args_os().next().unwrap_or_default());
            command.args(["suite", "--stage", &name]).args(&self.pytest).env(PREPARED, "1");
            command.stdout(end.try_clone()?).stderr(end);
            let mut child = command.spawn()?;
            drop(command); // It holds the pipe's end, after which its lines end.
            for line in BufReader::new(lines).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                println!("{name} | {line}");
                skipped.extend(Skipped::read(&line));
            }
            Ok(child.wait()?.success())
        };
        match run() {
            Ok(true) => Verdict::Passed(skipped),
            Ok(false) => Verdict::Failed,
            Err(error) => {
                eprintln!("error: stage {name} cannot be run: {error}");
                Verdict::Failed
            }
        }
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

/// How a stage ended.
enum Verdict {
    /// No test failed; these did not run.
    Passed(Vec<Skipped>),
    /// A test failed, or the stage could not be run.
    Failed,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Failed => f.write_str("FAILED"),
            Self::Passed(skipped) if skipped.is_empty() => f.write_str("passed"),
            Self::Passed(skipped) => {
                let tests: usize = skipped.iter().map(|skipped| skipped.tests).sum();
                write!(f, "passed but for {tests} tests that did not run,")
            }
        }
    }
}

/// Tests that did not run, and why.
#[derive(Debug, PartialEq)]
struct Skipped {
    tests: usize,
    why: String,
}

impl Skipped {
    /// Reads a line of pytest's summary: `SKIPPED [3] tests/python/browsing.py:59: no browser: apt install chromium`.
    fn read(line: &str) -> Option<Self> {
        let (tests, rest) = line.trim().strip_prefix("SKIPPED [")?.split_once("] ")?;
        let (_, why) = rest.split_once(": ")?;
        Some(Self { tests: tests.parse().ok()?, why: why.to_owned() })
    }
}

/// Installs what tests need beyond Rust and Python where that is allowed: as root on Debian, as CI is. Returns what
/// is still missing, with the command that brings it.
fn equip(root: &Path) -> Result<Option<String>, Failure> {
    let prepare = || Command::new(root.join(".ci/prepare"));
    let lacking = || answer(prepare().arg("lacking")).filter(|missing| !missing.is_empty());
    let is_root = || answer(Command::new("id").arg("-u")).is_some_and(|user| user == "0");
    if lacking().is_some() && Path::new("/etc/debian_version").exists() && is_root() {
        run(&mut prepare())?;
    }
    Ok(lacking().map(|missing| format!("{missing} not installed: `.ci/prepare` installs it")))
}

/// Prints how each stage ended and what did not run. An error if a stage failed.
fn conclude(verdicts: &[(Stage, Verdict)], lacking: Option<String>) -> Result<(), Failure> {
    let mut failed = String::new();
    let mut reasons = Vec::from_iter(lacking);
    for (stage, verdict) in verdicts {
        println!("=== {stage:?} {}", verdict.to_string().trim_end_matches(','));
        match verdict {
            Verdict::Failed => failed += &format!(" {stage:?}"),
            Verdict::Passed(skipped) => {
                let words =
                    |Skipped { tests, why }: &Skipped| format!("{tests} of {stage:?}: {why}");
                reasons.extend(skipped.iter().map(words));
            }
        }
    }
    for reason in reasons {
        println!("not run: {reason}");
    }
    if failed.is_empty() { Ok(()) } else { Err(Failure::Stages(failed)) }
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
    fn what_did_not_run_is_never_called_passed() {
        let line = "SKIPPED [84] tests/python/browsing.py:59: no browser: apt install chromium";
        let skipped = Skipped::read(line).expect("a line of pytest's summary");
        assert_eq!(skipped.tests, 84);
        assert_eq!(skipped.why, "no browser: apt install chromium");
        assert_eq!(Skipped::read("16 passed, 84 skipped in 3.2s"), None);
        let said = Verdict::Passed(vec![skipped]).to_string();
        assert!(said.contains("84 tests that did not run"), "{said}");
        assert_eq!(Verdict::Passed(Vec::new()).to_string(), "passed");
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
