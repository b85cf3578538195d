//! `cargo fmu`: from the sources to `dist/dth_hammer.fmu`, and for FMI 3.0 `dist/dth_hammer_fmi3.fmu`.

#![forbid(unsafe_code)]

mod archive;
mod binary;
#[cfg(unix)]
mod cross;
mod document;
mod inspect;
mod lab;
mod library;
mod licenses;
mod presets;
mod reference;
#[cfg(unix)]
mod release;

use binary::Binary;
use clap::{Parser, Subcommand};
use dth_hammer::MODEL_IDENTIFIER;
use licenses::License;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use support::run::checkout;
use thiserror::Error;

/// What can go wrong while packaging.
#[derive(Debug, Error)]
pub enum Failure {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// Its path.
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
    /// A library cannot be read.
    #[error("library: {0}")]
    Library(#[from] object::read::Error),
    /// A library does not fulfil what it must.
    #[error("{name} is not fit to be shipped: {reason}")]
    Unfit {
        /// Its place in the archive.
        name: String,
        /// Why.
        reason: String,
    },
    /// Something to install first.
    #[error("cannot build for other machines: {0}")]
    Missing(String),
    /// The Python environment could not be made.
    #[error(transparent)]
    Environment(#[from] support::run::Failure),
    /// The committed description differs from that of the sources.
    #[error("{0} is stale: refresh it with `cargo describe`")]
    Stale(PathBuf),
}

/// Remembers which file an error is about.
pub trait About<T> {
    /// Adds the path to the error.
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
        /// File to write; the file for FMI 3.0 is beside it, with `_fmi3` appended to its name
        #[arg(long, default_value_os_t = checkout().join("dist/dth_hammer.fmu"))]
        output: PathBuf,
        /// Linux with any glibc since 2.17 and Windows in one file, and one for Linux on
        /// aarch64 beside it
        #[arg(long, conflicts_with = "quick")]
        all_platforms: bool,
        /// Only for this machine, in a third of the time and as the tests use it: some per cent slower
        #[arg(long)]
        quick: bool,
    },
    /// Write the laboratory: one page that runs the engine in a browser
    Lab {
        /// File to write
        #[arg(long, default_value_os_t = checkout().join("dist/lab/index.html"))]
        output: PathBuf,
        /// If something is missing, say so and succeed
        #[arg(long)]
        if_possible: bool,
    },
    /// Write an .fmu for each platform that this machine can build for, and one for all
    #[cfg(unix)]
    Release {
        /// Folder to write to; a `dth_hammer-macos-universal2.fmu` in it is included in the archive for all platforms
        #[arg(long, default_value_os_t = checkout().join("dist/release"))]
        folder: PathBuf,
    },
    /// Refresh the committed copies of the model descriptions
    Describe {
        /// Only check whether they are up to date
        #[arg(long)]
        check: bool,
    },
}

/// The standard that an archive is for; the library is for both.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// Ports that belong together, and the icon's place.
const TERMINALS: &str = include_str!("../terminalsAndIcons.xml");
/// Piston, bit and rock.
const ICON: &[u8] = include_bytes!("../icon.png");

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Fmu { output, all_platforms: false, quick } => package(&output, quick),
        Task::Fmu { output, all_platforms: true, .. } => package_all(&output),
        Task::Lab { output, if_possible } => laboratory(&output, if_possible),
        #[cfg(unix)]
        Task::Release { folder } => release::write(&checkout(), &folder),
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

/// The file for FMI 3.0 beside that for FMI 2.0.
fn of_three(output: &Path) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}_fmi3.fmu"))
}

/// Prints a line of progress.
fn tell(what: &str, details: &str) {
    eprintln!("{what:>12} {details}");
}

fn package(output: &Path, quick: bool) -> Result<(), Failure> {
    let begun = Instant::now();
    describe(true)?;
    licenses::note_wheel(&checkout())?;
    let (library, more) = if quick {
        (library::quick(&checkout())?, Vec::new())
    } else {
        tell("Building", "the shared library (2 minutes the first time, then seconds)");
        library::build(&checkout())?
    };
    let licenses =
        licenses::collect(&checkout(), &licenses::FMU, &[&licenses::host(&checkout())?], more)?;
    write_both(output, &[library], &licenses, begun)
}

/// Writes the archives for both standards.
fn write_both(
    output: &Path,
    libraries: &[Binary],
    licenses: &[License],
    begun: Instant,
) -> Result<(), Failure> {
    write(output, Standard::Two, libraries, licenses, begun)?;
    write(&of_three(output), Standard::Three, libraries, licenses, begun)
}

#[cfg(unix)]
fn package_all(output: &Path) -> Result<(), Failure> {
    use cross::{AARCH64, LINUX, WINDOWS, Workshop};
    let begun = Instant::now();
    describe(true)?;
    let workshop = Workshop::open(&checkout())?;
    let mut libraries = Vec::new();
    for platform in [LINUX, WINDOWS, AARCH64] {
        tell("Building", &format!("for {}", platform.triple));
        libraries.push(workshop.build(&platform)?);
    }
    let licenses = |platforms: &[_]| workshop.licenses(platforms);
    let beside = output.with_file_name(format!("{MODEL_IDENTIFIER}-aarch64.fmu"));
    let (both, alone) = libraries.split_at(2);
    write(output, Standard::Two, both, &licenses(&[LINUX, WINDOWS])?, begun)?;
    write(&beside, Standard::Two, alone, &licenses(&[AARCH64])?, begun)?;
    let all = licenses(&[LINUX, WINDOWS, AARCH64])?;
    write(&of_three(output), Standard::Three, &libraries, &all, begun)
}

#[cfg(not(unix))]
fn package_all(_: &Path) -> Result<(), Failure> {
    Err(Failure::Missing("that takes Linux on x86-64".into()))
}

fn laboratory(output: &Path, if_possible: bool) -> Result<(), Failure> {
    match lab::write(&checkout(), output) {
        Err(Failure::Missing(what)) if if_possible => {
            tell("Skipped", &format!("the laboratory (dist/lab/index.html): {what}"));
            Ok(())
        }
        other => other,
    }
}

/// Writes the archive with these libraries.
fn write(
    output: &Path,
    standard: Standard,
    libraries: &[Binary],
    licenses: &[License],
    begun: Instant,
) -> Result<(), Failure> {
    tell("Writing", "documentation, presets, icon and licences");
    let description = match standard {
        Standard::Two => dth_hammer::MODEL_DESCRIPTION,
        Standard::Three => dth_hammer::MODEL_DESCRIPTION_3,
    };
    // FMI 2.0.4 takes terminals from FMI 3.0; earlier hosts know only `model.png`.
    let icon = "terminalsAndIcons/icon.png";
    let page = document::write(standard, libraries, licenses);
    let mut files = vec![
        archive::File::new("modelDescription.xml", description),
        archive::File::new("documentation/index.html", page.replace("@ICON@", icon)),
        archive::File::new(licenses::PLACE, licenses::text(licenses)),
        archive::File::new("terminalsAndIcons/terminalsAndIcons.xml", TERMINALS),
        archive::File::new(icon, ICON),
    ];
    if standard == Standard::Two {
        files.push(archive::File::new("model.png", ICON));
    }
    files.extend(libraries.iter().flat_map(|library| library.files(standard)));
    files.extend(presets::files()?);
    files.extend(reference::Reference::new()?.files());
    let size = archive::write(output, files)?;
    let path = output.strip_prefix(checkout()).unwrap_or(output).display().to_string();
    let seconds = begun.elapsed().as_secs_f64();
    tell("Packaged", &format!("{path} ({} kB, {seconds:.1} s)", size / 1000));
    for library in libraries {
        tell("Runs on", &library.runs_on);
    }
    Ok(())
}

fn describe(check: bool) -> Result<(), Failure> {
    let two = dth_hammer::description::describe();
    let three = dth_hammer::description3::describe(&two);
    for (name, text) in [("modelDescription.xml", two), ("modelDescription3.xml", three)] {
        let path = checkout().join(name);
        let committed = fs::read_to_string(&path).unwrap_or_default();
        if committed == text {
            continue;
        }
        if check {
            return Err(Failure::Stale(path));
        }
        fs::write(&path, text).about(&path)?;
        tell("Refreshed", &path.display().to_string());
    }
    Ok(())
}
