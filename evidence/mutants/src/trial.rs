//! Runs tests on changes: which tests reach a change, and which notice it.

use crate::Problem;
use std::collections::HashMap;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Processor time allowed for a test of a changed engine, over that of the unchanged one.
const PATIENCE: (u32, Duration) = (10, Duration::from_secs(5));

/// Clock time allowed for a second of processor time, on a machine with other work.
const BUSY: u32 = 30;

/// Signal that ends a process after its processor time.
const SIGXCPU: i32 = 24;

/// Scenes of one comparison, and number of comparisons of each kind.
const SCENES: u32 = 40;
const COMPARISONS: [(&str, u32); 2] = [("mixed", 12), ("air", 3)];

/// A test of the engine.
pub struct Test {
    /// Program and name.
    pub name: (String, String),
    path: PathBuf,
    arguments: Vec<String>,
    time: Duration,
    /// Whether to find out if this test would be missed.
    pub judged: bool,
    /// The changes that it reaches, ascending.
    met: Vec<usize>,
}

impl Test {
    fn of(program: &str, name: String, path: &Path, arguments: Vec<String>) -> Self {
        let (name, path) = ((program.to_owned(), name), path.to_owned());
        Self { name, path, arguments, time: Duration::ZERO, judged: false, met: Vec::new() }
    }

    /// Comparisons, each with the file in `folder` that has the reference's accounts.
    fn comparisons(path: &Path, folder: &Path) -> Vec<(PathBuf, Self)> {
        let one = |kind: &str, from: u32| {
            let accounts = folder.join(format!("{kind}-{from}.accounts"));
            let numbers = [("--scenes", SCENES), ("--from", from)];
            let mut arguments = vec!["--kind".to_owned(), kind.to_owned()];
            arguments.extend(["--accounts".to_owned(), accounts.display().to_string()]);
            arguments.extend(numbers.into_iter().flat_map(|(k, n)| [k.to_owned(), n.to_string()]));
            (accounts, Self::of("compare", format!("{kind} {from}"), path, arguments))
        };
        let all = |(kind, count)| (0..count).map(move |from| one(kind, from));
        COMPARISONS.into_iter().flat_map(all).collect()
    }

    /// Command of the test's process, with this limit of processor time.
    fn command(&self, folder: &Path, limit: Duration) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -S -t \"$0\" && exec \"$@\""]);
        command.arg(limit.as_secs().max(1).to_string());
        command.arg(&self.path).args(&self.arguments).current_dir(folder);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// The test with its time and the changes that it reaches, if it passes on the unchanged engine within `limit`.
    fn tried(mut self, folder: &Path, limit: Duration) -> Result<Option<Self>, Problem> {
        let notes = std::env::temp_dir().join(format!("mutants-{}", std::process::id()));
        let _ = std::fs::remove_file(&notes);
        let mut once = self.command(folder, limit);
        once.env("MUTANTS_MET", &notes);
        let before = processor_time()?;
        let passed = wait(once, limit).map_err(|error| Problem::file(&self.name.1, error))?;
        self.time = processor_time()?.saturating_sub(before);
        let text = std::fs::read_to_string(&notes).unwrap_or_default();
        self.met = text.lines().filter_map(|line| line.parse().ok()).collect();
        self.met.sort_unstable();
        let _ = std::fs::remove_file(&notes);
        if passed == Some(true) && self.time <= limit {
            return Ok(Some(self));
        }
        let why = if passed != Some(false) { "takes too long" } else { "fails" };
        let (program, name) = &self.name;
        println!("left out, for it {why} on the unchanged engine: {program} {name}");
        Ok(None)
    }
}

/// Result of a change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// No test reaches it.
    Unmet,
    /// This test fails.
    Caught(String),
    /// This test exceeds its time.
    Endless(String),
    /// This judged test fails or exceeds its time, and no other test does.
    Alone(String),
    Survives,
}

fn names(path: &Path, folder: &Path, ignored: &[&str]) -> Result<Vec<String>, Problem> {
    let mut list = Command::new(path);
    list.args(["--list", "--format", "terse"]).args(ignored).current_dir(folder);
    let output = list.output().map_err(|error| Problem::file("a test", error))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect())
}

/// Waits for a test. Returns whether it passes, or `None` if it exceeds `limit`.
fn wait(mut command: Command, limit: Duration) -> std::io::Result<Option<bool>> {
    let (mut child, until) = (command.spawn()?, Instant::now() + BUSY * limit);
    loop {
        match child.try_wait()? {
            Some(status) if status.signal() == Some(SIGXCPU) => return Ok(None),
            Some(status) => return Ok(Some(status.success())),
            None if Instant::now() > until => break,
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    child.kill()?;
    child.wait()?;
    Ok(None)
}

/// Processor time of all child processes that have ended, from Linux.
fn processor_time() -> Result<Duration, Problem> {
    let stat = std::fs::read_to_string("/proc/self/stat");
    let stat = stat.map_err(|error| Problem::file("/proc/self/stat", error))?;
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().skip(13).take(2);
    Ok(Duration::from_millis(ticks.filter_map(|ticks| ticks.parse::<u64>().ok()).sum::<u64>() * 10))
}

/// All tests that pass within `limit`. The names of the others are printed.
///
/// # Errors
///
/// A program that cannot be run.
pub fn tests(
    programs: &[(String, PathBuf)],
    folder: &Path,
    limit: Duration,
) -> Result<Vec<Test>, Problem> {
    let mut tests = Vec::new();
    for (program, path) in programs {
        let ignored = names(path, folder, &["--ignored"])?;
        for name in names(path, folder, &[])?.into_iter().filter(|name| !ignored.contains(name)) {
            let arguments = ["--exact", &name, "--test-threads=1"].map(str::to_owned).to_vec();
            tests.extend(Test::of(program, name, path, arguments).tried(folder, limit)?);
        }
        println!("{program}: {} tests so far", tests.len());
    }
    Ok(tests)
}

/// The comparisons with the reference, after making its accounts.
///
/// # Errors
///
/// A program that cannot be run.
pub fn comparisons(path: &Path, folder: &Path) -> Result<Vec<Test>, Problem> {
    let mut tests = Vec::new();
    for (accounts, test) in Test::comparisons(path, folder) {
        let _ = std::fs::remove_file(accounts);
        let mut first = test.command(folder, Duration::from_secs(3600));
        first.status().map_err(|error| Problem::file(&test.name.1, error))?;
        tests.extend(test.tried(folder, Duration::from_secs(60))?);
    }
    println!("compare: {} comparisons of {SCENES} scenes", tests.len());
    Ok(tests)
}

/// How often each test has failed, by the file of the change, where it is likely to fail again.
#[derive(Default)]
pub struct Experience(Mutex<HashMap<(String, usize), u32>>);

impl Experience {
    /// The tests that reach a change, beginning with those that are fast and often fail.
    fn order<'a>(&self, tests: &'a [Test], file: &str, switch: usize) -> Vec<(usize, &'a Test)> {
        let past = |test: &&Test| test.met.binary_search(&switch).is_ok();
        let mut order: Vec<_> = tests.iter().enumerate().filter(|(_, test)| past(test)).collect();
        let failed = self.0.lock().expect("no panic while locked");
        let rank = |(index, test): &(usize, &Test)| {
            let times = failed.get(&(file.to_owned(), *index)).copied().unwrap_or(0);
            (0.005 + test.time.as_secs_f64()) / f64::from(1 + times)
        };
        order.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
        order
    }

    /// Runs the tests that come past a change until one notices; those that are judged first,
    /// and the others only if one of these does.
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
        let judging = tests.iter().any(|test| test.judged);
        let (judged, others): (Vec<_>, Vec<_>) = order.iter().partition(|(_, test)| test.judged);
        if order.is_empty() || judging && judged.is_empty() {
            return Ok(Outcome::Unmet);
        }
        let first = self.first_to_notice(judged, folder, file, switch)?;
        if judging && first.is_none() {
            return Ok(Outcome::Survives);
        }
        let other = self.first_to_notice(others, folder, file, switch)?;
        Ok(match (first, other) {
            (_, Some(other)) => other,
            (Some(Outcome::Caught(by) | Outcome::Endless(by)), None) => Outcome::Alone(by),
            (_, None) => Outcome::Survives,
        })
    }

    fn first_to_notice(
        &self,
        order: Vec<&(usize, &Test)>,
        folder: &Path,
        file: &str,
        switch: usize,
    ) -> Result<Option<Outcome>, Problem> {
        for (index, test) in order {
            let limit = PATIENCE.0 * test.time + PATIENCE.1;
            let mut changed = test.command(folder, limit);
            changed.env("MUTANT", switch.to_string());
            let passed =
                wait(changed, limit).map_err(|error| Problem::file(&test.name.1, error))?;
            if passed == Some(true) {
                continue;
            }
            let mut failed = self.0.lock().expect("no panic while locked");
            *failed.entry((file.to_owned(), *index)).or_default() += 1;
            let name = format!("{} {}", test.name.0, test.name.1);
            let outcome = if passed.is_some() { Outcome::Caught } else { Outcome::Endless };
            return Ok(Some(outcome(name)));
        }
        Ok(None)
    }
}
