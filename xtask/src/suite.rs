//! `cargo suite`: every test, in stages that are reported by name and time.

use crate::{QUICK, begin, fmu, laboratory, lint, python};
use clap::{Args, ValueEnum};
use std::path::Path;
use std::time::Instant;
use support::python::Needs;
use support::run::{Failure, locked, run};

/// What a browser tests; the pages are built before.
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
/// Tests of hosts in C++, each of which gets a process of its own: two of them in one have been
/// found to corrupt the heap.
const NATIVE: (&str, [&str; 2]) = ("tests/python/test_hosts_of_systems.py", ["libcosim", "ecos"]);
/// A process for each core; a file's tests share what it has prepared.
const IN_PARALLEL: [&str; 4] = ["--numprocesses", "auto", "--dist", "loadfile"];
/// pytest's exit code where a selection has chosen no test.
const NONE_CHOSEN: i32 = 5;

/// A part of all that CI does.
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

impl Stage {
    fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

/// What is to be tested.
#[derive(Args)]
pub struct Suite {
    /// Only this stage; several may be given
    #[arg(long = "stage", value_enum, default_values = ["rust", "python", "lab"])]
    stages: Vec<Stage>,
    /// With the libraries for Windows, old Linux and aarch64, run where that can be
    #[arg(long)]
    all_platforms: bool,
    /// Handed to pytest, for instance `-k coupling`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pytest: Vec<String>,
}

impl Suite {
    /// One stage, whole.
    pub fn of(stage: Stage) -> Self {
        Self { stages: vec![stage], all_platforms: false, pytest: Vec::new() }
    }

    /// Passes the stages in turn, those after a failed one too. Each tells of those before it, so that what
    /// is said last is what cargo or pytest says.
    pub fn pass(&self, root: &Path) -> Result<(), Failure> {
        let (mut before, mut failed) = (String::new(), Vec::new());
        for (index, stage) in self.stages.iter().enumerate() {
            let (name, count) = (stage.name(), self.stages.len());
            println!("=== {name} (stage {} of {count}{before})", index + 1);
            let begun = Instant::now();
            let result = self.stage(root, *stage);
            let verdict = if result.is_ok() { "passed" } else { "FAILED" };
            before += &format!(", {name} {verdict} in {:.0} s", begun.elapsed().as_secs_f64());
            if let Err(failure) = result {
                eprintln!("error: {failure}");
                failed.push(name);
            }
        }
        if failed.is_empty() { Ok(()) } else { Err(Failure::Stages(failed.join(", "))) }
    }

    fn stage(&self, root: &Path, stage: Stage) -> Result<(), Failure> {
        match stage {
            Stage::Lint => lint(root),
            Stage::Rust => {
                begin("Tests in Rust", "6 minutes the first time, then 3");
                // All packages at once: a part of them asks for other features, and for another engine.
                // Examples are no tests: clippy sees that they compile.
                let tests = ["--workspace", "--no-fail-fast", "--lib", "--bins", "--tests"];
                run(locked(root, "test").args(tests))?;
                run(locked(root, "test").args(["--workspace", "--doc"]))
            }
            Stage::Python => {
                fmu(root, if self.all_platforms { &["--all-platforms"] } else { QUICK })?;
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
                fmu(root, QUICK)?;
                laboratory(root)?;
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
    }

    #[test]
    fn a_stage_is_chosen_by_its_name() {
        assert_eq!(read(&["--stage", "lab", "--stage", "lint"]).stages, [Stage::Lab, Stage::Lint]);
    }
}
