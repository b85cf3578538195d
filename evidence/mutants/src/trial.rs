//! Tests on trial: which come past a change, and which notices it.

use crate::Problem;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// What a test may take of a changed engine, over what it takes of the unchanged one.
const PATIENCE: (u32, Duration) = (10, Duration::from_secs(5));

/// A test of the engine.
pub struct Test {
    /// Program and name.
    pub name: (String, String),
    path: PathBuf,
    time: Duration,
    /// The changes that it comes past, ascending.
    met: Vec<usize>,
}

/// What became of a change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// No test comes past it.
    Unmet,
    /// This test fails.
    Caught(String),
    /// This test does not end.
    Endless(String),
    Survives,
}

fn command(path: &Path, folder: &Path, name: &str) -> Command {
    let mut command = Command::new(path);
    command.args(["--exact", name, "--test-threads=1"]).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn names(path: &Path, folder: &Path, ignored: &[&str]) -> Result<Vec<String>, Problem> {
    let mut list = Command::new(path);
    list.args(["--list", "--format", "terse"]).args(ignored).current_dir(folder);
    let output = list.output().map_err(|error| Problem::file("a test", error))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect())
}

/// Waits for a test: whether it passes, or `None` after `limit`, when it is ended.
fn wait(mut command: Command, limit: Duration) -> std::io::Result<Option<bool>> {
    let (mut child, until) = (command.spawn()?, Instant::now() + limit);
    loop {
        match child.try_wait()? {
            Some(status) => return Ok(Some(status.success())),
            None if Instant::now() > until => break,
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    child.kill()?;
    child.wait()?;
    Ok(None)
}

/// All tests that pass within `limit`, with the changes that they come past; others are named.
///
/// # Errors
///
/// A program that cannot be run.
pub fn tests(
    programs: &[(String, PathBuf)],
    folder: &Path,
    limit: Duration,
) -> Result<Vec<Test>, Problem> {
    let notes = std::env::temp_dir().join(format!("mutants-{}", std::process::id()));
    let mut tests = Vec::new();
    for (program, path) in programs {
        let ignored = names(path, folder, &["--ignored"])?;
        for name in names(path, folder, &[])?.into_iter().filter(|name| !ignored.contains(name)) {
            let _ = std::fs::remove_file(&notes);
            let start = Instant::now();
            let mut once = command(path, folder, &name);
            once.env("MUTANTS_MET", &notes);
            let passed = wait(once, limit).map_err(|error| Problem::file(&name, error))?;
            if passed != Some(true) {
                let why = if passed.is_none() { "takes too long" } else { "fails" };
                println!("left out, for it {why} on the unchanged engine: {program} {name}");
                continue;
            }
            let text = std::fs::read_to_string(&notes).unwrap_or_default();
            let mut met: Vec<usize> = text.lines().filter_map(|line| line.parse().ok()).collect();
            met.sort_unstable();
            let (time, name) = (start.elapsed(), (program.clone(), name));
            tests.push(Test { name, path: path.clone(), time, met });
        }
        println!("{program}: {} tests so far", tests.len());
    }
    let _ = std::fs::remove_file(&notes);
    Ok(tests)
}

/// How often each test has failed, by the file of the change: it is likely to fail again there.
#[derive(Default)]
pub struct Experience(Mutex<HashMap<(String, usize), u32>>);

impl Experience {
    /// The tests that come past a change, those first that are quick and often fail.
    fn order<'a>(&self, tests: &'a [Test], file: &str, switch: usize) -> Vec<(usize, &'a Test)> {
        let past = |test: &&Test| test.met.binary_search(&switch).is_ok();
        let mut order: Vec<_> = tests.iter().enumerate().filter(|(_, test)| past(test)).collect();
        let failed = self.0.lock().expect("no panic while locked");
        let rank = |(index, test): &(usize, &Test)| {
            let times = failed.get(&(file.to_owned(), *index)).copied().unwrap_or(0);
            test.time.as_secs_f64() / f64::from(1 + times)
        };
        order.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
        order
    }

    /// Runs the tests that come past a change until one notices.
    ///
    /// # Errors
    ///
    /// A program that cannot be run.
    pub fn try_out(
        &self,
        tests: &[Test],
        folder: &Path,
        file: &str,
        switch: usize,
    ) -> Result<Outcome, Problem> {
        let order = self.order(tests, file, switch);
        if order.is_empty() {
            return Ok(Outcome::Unmet);
        }
        for (index, test) in order {
            let mut changed = command(&test.path, folder, &test.name.1);
            changed.env("MUTANT", switch.to_string());
            let passed = wait(changed, PATIENCE.0 * test.time + PATIENCE.1)
                .map_err(|error| Problem::file(&test.name.1, error))?;
            let name = format!("{} {}", test.name.0, test.name.1);
            if passed != Some(true) {
                let mut failed = self.0.lock().expect("no panic while locked");
                *failed.entry((file.to_owned(), index)).or_default() += 1;
            }
            match passed {
                Some(true) => {}
                Some(false) => return Ok(Outcome::Caught(name)),
                None => return Ok(Outcome::Endless(name)),
            }
        }
        Ok(Outcome::Survives)
    }
}
