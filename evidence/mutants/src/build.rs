//! One build of the engine with all changes, in a copy of the project.

use crate::Problem;
use crate::changes::{Change, Source};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::run::{cargo, run, target};

/// Code that reads the switch, and records which changes a run passes if asked to.
const SWITCH: &str = include_str!("switch.rs.in");

/// A copy of the project whose engine contains every change that compiles.
pub struct Build {
    root: PathBuf,
    sources: Vec<Source>,
    /// File and index of each change. Its switch is one more than its place in this list.
    switches: Vec<(usize, usize)>,
    /// Switches of changes that do not compile.
    pub refused: BTreeSet<usize>,
}

impl Build {
    /// Copies the project and finds the changes of these parts of the engine.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or written, or that is not Rust.
    pub fn new(project: &Path, parts: &[String]) -> Result<Self, Problem> {
        let root = target(project).join("mutants/tree");
        let listed = Command::new("git")
            .args(["ls-files", "-co", "--exclude-standard"])
            .current_dir(project)
            .output();
        let listed = listed.map_err(|error| Problem::file("git", error))?.stdout;
        let (mut sources, mut switches) = (Vec::new(), Vec::new());
        for file in String::from_utf8_lossy(&listed).lines() {
            let from = project.join(file);
            let Ok(bytes) = std::fs::read(&from) else { continue };
            let part = |part: &String| file.starts_with(&format!("hammer/src/{part}"));
            if file.ends_with(".rs") && parts.iter().any(part) {
                let text = String::from_utf8_lossy(&bytes);
                let source = Source::read(file, &text)
                    .map_err(|error| Problem::NotRust { file: from.clone(), error })?;
                let of = (0..source.changes.len()).map(|change| (sources.len(), change));
                switches.extend(of);
                sources.push(source);
            } else if file != "hammer/src/lib.rs" {
                write(&root.join(file), &bytes)?;
            }
        }
        let library = "hammer/src/lib.rs";
        let text = std::fs::read_to_string(project.join(library));
        let text = text.map_err(|error| Problem::file(library, error))?;
        let text = format!("{text}\n#[doc(hidden)]\npub mod switch;\n");
        write(&root.join(library), text.as_bytes())?;
        let count = (switches.len() + 1).to_string();
        let switch = SWITCH.replace("COUNT", &count);
        write(&root.join("hammer/src/switch.rs"), switch.as_bytes())?;
        Ok(Self { root, sources, switches, refused: BTreeSet::new() })
    }

    /// The folder in which the engine's tests run.
    pub fn folder(&self) -> PathBuf {
        self.root.join("hammer")
    }

    pub fn count(&self) -> usize {
        self.switches.len()
    }

    pub fn change(&self, switch: usize) -> &Change {
        let (source, change) = self.switches[switch - 1];
        &self.sources[source].changes[change]
    }

    fn cargo(&self, task: &str) -> Command {
        let mut command = cargo(&self.root);
        let folder = self.root.with_file_name("build");
        command.env("CARGO_TARGET_DIR", folder).env("RUSTFLAGS", "--cap-lints=allow");
        command.args([task, "--locked", "--quiet"]);
        command
    }

    /// A cargo command for the engine alone, with its tests.
    fn engine(&self, task: &str) -> Command {
        let mut command = self.cargo(task);
        command.args(["--package", "dth-hammer", "--features", "internals"]);
        command
    }

    /// Writes the changed files, and removes changes that do not compile until the rest does.
    ///
    /// # Errors
    ///
    /// An error of the compiler that no change causes.
    pub fn compile(&mut self) -> Result<(), Problem> {
        // Changes that an earlier run removed. Without them, nothing is built again.
        let noted = self.root.with_file_name("refused.txt");
        let text = std::fs::read_to_string(&noted).unwrap_or_default();
        let known: BTreeSet<_> = text.lines().collect();
        let is_known = |switch: &usize| known.contains(&*self.change(*switch).to_string());
        self.refused = (1..=self.count()).filter(is_known).collect();
        loop {
            let mut places = Vec::new();
            for (index, source) in self.sources.iter().enumerate() {
                let first = self.switches.partition_point(|(source, _)| *source < index);
                let number = |change: usize| {
                    let switch = first + change + 1;
                    (!self.refused.contains(&switch)).then_some(switch)
                };
                let written = source.rewrite(number);
                write(&self.root.join(&source.file), written.text.as_bytes())?;
                let of_file = written.places.into_iter();
                places.extend(of_file.map(|(change, range)| (index, first + change + 1, range)));
            }
            let (output, messages) = messages(self.engine("check").arg("--tests"))?;
            if output.status.success() {
                let lines = self.refused.iter().map(|&switch| format!("{}\n", self.change(switch)));
                return write(&noted, lines.collect::<String>().as_bytes());
            }
            let before = self.refused.len();
            for message in &messages {
                self.refused.extend(self.blamed(message, &places));
            }
            if self.refused.len() == before {
                let rendered =
                    |message: &Value| message["message"]["rendered"].as_str().map(str::to_owned);
                let said = String::from_utf8_lossy(&output.stderr).into_owned();
                let texts = messages.iter().filter_map(rendered).take(3).chain([said]);
                return Err(Problem::Compiler(texts.collect()));
            }
            println!("{} of {} changes do not compile", self.refused.len(), self.count());
        }
    }

    /// The innermost changes at the places of an error.
    fn blamed(
        &self,
        message: &Value,
        places: &[(usize, usize, std::ops::Range<usize>)],
    ) -> Vec<usize> {
        let message = &message["message"];
        if message["level"] != "error" {
            return Vec::new();
        }
        let spans = message["spans"].as_array().cloned().unwrap_or_default();
        let innermost = |span: &Value| {
            // Modules with a `path` attribute have it in their names.
            let name = span["file_name"].as_str()?.replace("/./", "/");
            let at = usize::try_from(span["byte_start"].as_u64()?).ok()?;
            let inside = places.iter().filter(|(source, _, range)| {
                self.sources[*source].file.ends_with(name.trim_start_matches("hammer/"))
                    && range.contains(&at)
            });
            inside.min_by_key(|(_, _, range)| range.len()).map(|(_, switch, _)| *switch)
        };
        spans.iter().filter_map(innermost).collect()
    }

    /// The programs of the engine's tests, by name.
    ///
    /// # Errors
    ///
    /// Those of cargo.
    pub fn programs(&self) -> Result<Vec<(String, PathBuf)>, Problem> {
        let tests = ["--no-run", "--lib", "--tests"];
        run(self.engine("test").args(tests))?;
        let (_, messages) = messages(self.engine("test").args(tests))?;
        let program = |message: Value| {
            let path = message["executable"].as_str()?;
            Some((message["target"]["name"].as_str()?.to_owned(), PathBuf::from(path)))
        };
        Ok(messages.into_iter().filter_map(program).collect())
    }

    /// The program that compares the engine with the extended-precision reference.
    ///
    /// # Errors
    ///
    /// Those of cargo.
    pub fn comparison(&self) -> Result<PathBuf, Problem> {
        let program = ["--package", "verify", "--features", "programs", "--bin", "compare"];
        run(self.cargo("build").args(program))?;
        Ok(self.root.with_file_name("build").join("debug/compare"))
    }
}

/// Runs cargo, and returns its messages in JSON.
fn messages(command: &mut Command) -> Result<(Output, Vec<Value>), Problem> {
    let output = command.arg("--message-format=json").output();
    let output = output.map_err(|error| Problem::file("cargo", error))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let messages = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    Ok((output, messages))
}

/// Writes a file unless it is unchanged, since cargo compares times.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    if std::fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    let folder = path.parent().expect("a file is in a folder");
    let done = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, bytes));
    done.map_err(|error| Problem::file(&path.display().to_string(), error))
}
