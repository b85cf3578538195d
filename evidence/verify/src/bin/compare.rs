//! Compares the engine with the extended-precision reference on drawn scenes.
//!
//! `cargo compare --scenes 5000` prints scenes that disagree, scenes that differ only by the roughness of the
//! engine's bases or by less than guards resolve, and how near the rest came to the allowed difference.

use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use support::run::checkout;
use verify::comparison::asked::Study;
use verify::comparison::known::Account;
use verify::comparison::tally::{Kept, Kind, Name, accounts, against, tally, these};

#[derive(Parser)]
#[command(about = "Compares the engine with the extended-precision reference on drawn scenes")]
struct Arguments {
    /// Scenes
    #[arg(long, default_value_t = 5000)]
    scenes: u32,
    /// Number of the first batch of a hundred; other batches have other scenes
    #[arg(long, default_value_t = 0)]
    from: u32,
    /// Which scenes
    #[arg(long, value_enum, default_value_t = Kind::Mixed)]
    kind: Kind,
    /// Only these scenes, by the names in the reports: batch and place in it
    #[arg(long, num_args = 1.., value_name = "BATCH.PLACE", conflicts_with_all = ["scenes", "from"])]
    only: Vec<Name>,
    /// Print the events of those scenes: of the engine, the reference and its perturbed runs
    #[arg(long, requires = "only")]
    events: bool,
    /// Compare derivatives by parameters with differences
    #[arg(long)]
    derivatives: bool,
    /// Measure the error of air over the error asked, for this many drawn hammers
    #[arg(long, conflicts_with_all = ["only", "derivatives", "accounts", "kind"])]
    asked: bool,
    /// Add the results of each batch to reports/verification/compared.json, from where `cargo verify` takes them, or
    /// replace its previous results there; write those of derivatives to reports/derivatives.md
    #[arg(long, conflicts_with = "only")]
    keep: bool,
    /// File of the reference's accounts of the scenes, which do not depend on the engine: read if it exists,
    /// otherwise written
    #[arg(long, conflicts_with_all = ["only", "derivatives", "keep"])]
    accounts: Option<PathBuf>,
}

/// Head of the report on derivatives.
const ABOUT: &str = "# How often the errors of derivatives hold

Drawn hammers, each simulated to its end and differentiated by four of its parameters in turn. The true derivative is a
central difference in double-double arithmetic over 2^-36 of the parameter, right to all digits of a double. Beside each
derivative the engine tells an estimate of its error, from two steps: how often is the true error within it? Where it
is not, it is still by rounding alone if it is less than one unit in the last place of the quantity's size over
the engine's step.

The scenes that disagree are named below (`scene BATCH.PLACE` of `cargo compare --derivatives`). 1.11 does by the reference:
the rock is retuned at the instant of an event, before it on one side and behind it on the other; over 2^-30 the
reference's difference is 64 times smaller.
";

/// A file in the folder of reports.
fn report(name: &str) -> PathBuf {
    checkout().join("reports").join(name)
}

/// Results of drawn scenes, in that folder.
const COMPARED: &str = "verification/compared.json";

/// The study of air's error, in that folder.
const ASKED: &str = "verification/asked.txt";

/// Writes a report, or says why it cannot.
fn write(name: &str, text: &str) -> ExitCode {
    let path = report(name);
    match std::fs::write(&path, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}

/// The stored results of drawn scenes.
fn stored() -> Kept {
    let text = std::fs::read_to_string(report(COMPARED)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// A file of accounts: which scenes, and what the reference determines of them.
type Stored = ((u32, u32), Kind, Vec<Account>);

/// Reads accounts from a file, or writes them to it.
fn accounts_of(path: &Path, scenes: (u32, u32), kind: Kind) -> Result<Vec<Account>, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    if path.exists() {
        let bytes = std::fs::read(path).map_err(|error| wrong(&error))?;
        let stored = postcard::from_bytes(&bytes).map_err(|error| wrong(&error))?;
        let (of, its_kind, accounts): Stored = stored;
        let same = of == scenes && its_kind == kind;
        return if same { Ok(accounts) } else { Err(wrong(&"has other scenes")) };
    }
    let stored: Stored = (scenes, kind, accounts(scenes, kind));
    let bytes = postcard::to_allocvec(&stored).map_err(|error| wrong(&error))?;
    std::fs::write(path, bytes).map_err(|error| wrong(&error))?;
    Ok(stored.2)
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.derivatives {
        let found =
            verify::comparison::sensitivity::tally(arguments.scenes, arguments.from, |text| {
                println!("{text}");
            });
        if arguments.keep {
            let command = format!("cargo compare --derivatives --scenes {}", arguments.scenes);
            let (line, table) = (found.line(), found.table());
            return write("derivatives.md", &format!("{ABOUT}\n`{command}`: {line}.\n\n{table}"));
        }
        return if found.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    if arguments.asked {
        let Arguments { scenes, from, keep, .. } = arguments;
        let mut written = ExitCode::SUCCESS;
        Study::of(scenes, from, |study| {
            if study.drawn % 10 == 0 || study.drawn == scenes {
                println!("{}", study.table());
                if keep {
                    let stopped =
                        if study.drawn < scenes { ", stopped before its end" } else { "" };
                    let command = format!("`cargo compare --asked --scenes {scenes}`{stopped}");
                    written = write(ASKED, &format!("{command}: {}", study.table()));
                }
            }
        });
        return written;
    }
    let tell = |text: &str| println!("{text}");
    let Arguments { scenes, from, keep, .. } = arguments;
    let mut written = ExitCode::SUCCESS;
    let found = if let Some(path) = &arguments.accounts {
        match accounts_of(path, (scenes, from), arguments.kind) {
            Ok(accounts) => against(&accounts, tell),
            Err(error) => {
                eprintln!("error: {error}");
                return ExitCode::FAILURE;
            }
        }
    } else if arguments.only.is_empty() {
        let kind = arguments.kind;
        tally((scenes, from), kind, tell, |batch, found| {
            println!("batch {batch}: {}", found.line());
            if keep {
                let mut all = stored();
                all.entry(kind).or_default().insert(batch, found.clone());
                written = write(COMPARED, &serde_json::to_string_pretty(&all).expect("plain data"));
            }
        })
    } else {
        these(&arguments.only, arguments.kind, arguments.events, tell)
    };
    println!("{}", found.line());
    if found.failures.is_empty() { written } else { ExitCode::FAILURE }
}
