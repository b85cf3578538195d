//! Changes of the engine that its tests should notice, each tested by itself.
//!
//! All changes are in one build, each with a switch that an environment variable sets, so that a change costs only
//! the tests that reach it and no build. Changes that no test notices are listed; the file
//! `target/mutants/outcomes.txt` has all results, and evidence/mutants.md says what is known of the changes.

#![forbid(unsafe_code)]

mod build;
mod changes;
mod trial;

use build::Build;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use support::run::{Failure, checkout, target};
use trial::{Experience, Outcome, Test};

/// Why it ended early.
#[derive(Debug, thiserror::Error)]
enum Problem {
    #[error("{what}: {source}")]
    File { what: String, source: std::io::Error },
    #[error("{}: {error}", file.display())]
    NotRust { file: PathBuf, error: syn::Error },
    #[error("errors that are at no change:\n{0}")]
    Compiler(String),
    #[error("no test that is quick enough is called {0}")]
    NoTest(String),
    #[error(transparent)]
    Run(#[from] Failure),
}

impl Problem {
    fn file(what: &str, source: std::io::Error) -> Self {
        Self::File { what: what.to_owned(), source }
    }
}

#[derive(Parser)]
#[command(about = "Changes of the engine that no test of it notices")]
struct Arguments {
    /// Folders or files of hammer/src to change
    #[arg(default_values = ["air/", "datasheet/", "laws/", "machine/", "modal/", "motion/",
        "numerics/", "search/", "sensitivity/"])]
    parts: Vec<String>,
    /// Number of changes tried at a time
    #[arg(long, default_value_t = std::thread::available_parallelism().map_or(1, usize::from))]
    jobs: usize,
    /// Only every n-th change
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Leave out a test that takes longer than this on the unchanged engine, s
    #[arg(long, default_value_t = 20.0)]
    longest: f64,
    /// Only these test programs: `hammer` has the unit tests, `compare` compares drawn scenes with the
    /// extended-precision reference
    #[arg(long, num_args = 1..)]
    tests: Vec<String>,
    /// Whether these tests, or those of these programs, would be missed: only changes that one of them notices, and
    /// whether another test notices them
    #[arg(long, num_args = 1..)]
    missing: Vec<String>,
    /// Only those changes that no test noticed or reached according to target/mutants/outcomes.txt
    #[arg(long)]
    again: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Problem> {
    let root = checkout();
    println!("Building the engine with every change in it (some minutes the first time)");
    let mut build = Build::new(&root, &arguments.parts)?;
    build.compile()?;
    let wanted =
        |name: &str| arguments.tests.is_empty() || arguments.tests.iter().any(|n| n == name);
    let mut programs = build.programs()?;
    programs.retain(|(name, _)| wanted(name));
    println!("Each test once on the unchanged engine");
    let limit = Duration::from_secs_f64(arguments.longest.clamp(0.01, 3600.0));
    let mut tests = trial::tests(&programs, &build.folder(), limit)?;
    if wanted("compare") {
        tests.extend(trial::comparisons(&build.comparison()?, &build.folder())?);
    }
    let path = target(&root).join("mutants/outcomes.txt");
    for name in &arguments.missing {
        let found = tests.iter_mut().filter(|test| [&test.name.0, &test.name.1].contains(&name));
        if found.map(|test| test.judged = true).count() == 0 {
            return Err(Problem::NoTest(name.clone()));
        }
    }
    let chosen = chosen(&build, arguments, &path);
    println!("{} changes of {}, {} tests", chosen.len(), build.count(), tests.len());
    let outcomes = all(&build, &tests, &chosen, arguments, &path)?;
    report(&build, &outcomes);
    Ok(())
}

/// Switches of the changes to try.
fn chosen(build: &Build, arguments: &Arguments, outcomes: &Path) -> Vec<usize> {
    let before = std::fs::read_to_string(outcomes).unwrap_or_default();
    // The last line of each change is valid.
    let last: BTreeMap<&str, &str> =
        before.lines().filter_map(|line| line.split_once('\t')).collect();
    let is_unnoticed = |of: &str| matches!(last.get(of), Some(&"Survives" | &"Unmet"));
    let switches = (1..=build.count()).filter(|switch| !build.refused.contains(switch));
    let switches = switches.step_by(arguments.every as usize);
    let left =
        |switch: &usize| !arguments.again || is_unnoticed(&build.change(*switch).to_string());
    switches.filter(left).collect()
}

/// Tries every change, and records each result at once.
fn all(
    build: &Build,
    tests: &[Test],
    chosen: &[usize],
    arguments: &Arguments,
    path: &Path,
) -> Result<BTreeMap<usize, Outcome>, Problem> {
    let file = if arguments.again {
        OpenOptions::new().append(true).open(path)
    } else {
        File::create(path)
    };
    let file = Mutex::new(file.map_err(|error| Problem::file("outcomes.txt", error))?);
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {eta}").expect("a template");
    let bar = ProgressBar::new(chosen.len() as u64).with_style(style);
    let (next, experience) = (AtomicUsize::new(0), Experience::default());
    let outcomes = Mutex::new(BTreeMap::new());
    let work = || -> Result<(), Problem> {
        while let Some(&switch) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
            let change = build.change(switch);
            let outcome = experience.try_out(tests, &build.folder(), &change.file, switch)?;
            let line = format!("{}\t{outcome:?}\n", build.change(switch));
            let mut file = file.lock().expect("no panic while locked");
            let written = file.write_all(line.as_bytes());
            written.map_err(|error| Problem::file("outcomes.txt", error))?;
            outcomes.lock().expect("no panic while locked").insert(switch, outcome);
            bar.inc(1);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..arguments.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().expect("no panic"))
    })?;
    bar.finish_and_clear();
    Ok(outcomes.into_inner().expect("no panic while locked"))
}

/// Lists changes that no other test notices, and the numbers of each result in each file.
fn report(build: &Build, outcomes: &BTreeMap<usize, Outcome>) {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (&switch, outcome) in outcomes {
        let kind = match outcome {
            Outcome::Caught(_) => "caught",
            Outcome::Endless(_) => "do not end",
            Outcome::Alone(_) => "noticed by one alone",
            Outcome::Survives => "survive",
            Outcome::Unmet => "never met",
        };
        *counts.entry((&build.change(switch).file, kind)).or_default() += 1;
        if !matches!(outcome, Outcome::Caught(_) | Outcome::Endless(_)) {
            println!("{outcome:?}\t{}", build.change(switch));
        }
    }
    for ((file, kind), count) in counts {
        println!("{file}\t{count} {kind}");
    }
}
