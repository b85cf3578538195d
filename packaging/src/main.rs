//! `cargo fmu`: from the sources to `dist/dth_hammer.fmu`.

mod archive;
mod document;
mod icon;
mod library;
mod licenses;
mod presets;

use clap::{Parser, Subcommand};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use thiserror::Error;

/// What can go wrong while packaging.
#[derive(Debug, Error)]
pub enum Failure {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A program could not be run, or did not succeed.
    #[error("{program} failed: {reason}")]
    Program {
        /// Its command line.
        program: String,
        /// Why.
        reason: String,
    },
    /// A program's answer is not what it should be.
    #[error("unexpected answer: {0}")]
    Answer(#[from] serde_json::Error),
    /// The archive cannot be written.
    #[error("archive: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The icon cannot be encoded.
    #[error("icon: {0}")]
    Icon(#[from] png::EncodingError),
    /// The committed description is not that of the sources.
    #[error("{0} is stale: refresh it with `cargo describe`")]
    Stale(PathBuf),
}

/// Remembers which file an error is about.
pub trait About<T> {
    /// # Errors
    /// As before, with the path.
    fn about(self, path: &Path) -> Result<T, Failure>;
}

impl<T> About<T> for io::Result<T> {
    fn about(self, path: &Path) -> Result<T, Failure> {
        self.map_err(|source| Failure::File { path: path.into(), source })
    }
}

/// Builds and packages the hammer.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build the shared library and write the .fmu
    Fmu {
        /// File to write
        #[arg(long, default_value_os_t = root().join("dist/dth_hammer.fmu"))]
        output: PathBuf,
    },
    /// Refresh the committed copy of the model description
    Describe {
        /// Only tell whether it is fresh
        #[arg(long)]
        check: bool,
    },
}

/// Folder of the workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).into()
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Fmu { output } => package(&output),
        Task::Describe { check } => describe(check),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// One line of progress.
fn tell(what: &str, details: &str) {
    eprintln!("{what:>12} {details}");
}

fn package(output: &Path) -> Result<(), Failure> {
    let begun = Instant::now();
    tell("Building", "the shared library");
    let library = library::build(&root())?;
    tell("Collecting", "licences");
    let licenses = licenses::collect(&root())?;
    tell("Writing", "documentation, presets and icon");
    let mut files = vec![
        archive::File::new("modelDescription.xml", dth_hammer::MODEL_DESCRIPTION),
        archive::File::new("documentation/index.html", document::write(&licenses)),
        archive::File::new("model.png", icon::draw()?),
        library,
    ];
    files.extend(presets::files()?);
    files.extend(licenses.into_iter().flat_map(|license| license.files));
    let size = archive::write(output, files)?;
    let shown = output.strip_prefix(root()).unwrap_or(output).display().to_string();
    let seconds = begun.elapsed().as_secs_f64();
    tell("Packaged", &format!("{shown} ({} kB, {seconds:.1} s)", size / 1000));
    Ok(())
}

fn describe(check: bool) -> Result<(), Failure> {
    let path = root().join("modelDescription.xml");
    let committed = fs::read_to_string(&path).unwrap_or_default();
    if committed == dth_hammer::MODEL_DESCRIPTION {
        tell("Fresh", &path.display().to_string());
        return Ok(());
    }
    if check {
        return Err(Failure::Stale(path));
    }
    fs::write(&path, dth_hammer::MODEL_DESCRIPTION).about(&path)?;
    tell("Refreshed", &path.display().to_string());
    Ok(())
}
