//! Drawn scenes, the engine beside the extended-precision reference.
//!
//! `cargo compare --scenes 5000` prints what disagrees, what differs by the roughness of the engine's
//! bases alone, what by less than anyone sees, and how near the rest came.

use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use verify::comparison::asked::Study;
use verify::comparison::known::Account;
use verify::comparison::tally::{Kept, Kind, Name, accounts, against, tally, these};

#[derive(Parser)]
#[command(about = "Compares the engine with the extended-precision reference on drawn scenes")]
struct Arguments {
    /// Scenes
    #[arg(long, default_value_t = 5000)]
    scenes: u32,
    /// Number of the first batch of a hundred: other batches are other scenes
    #[arg(long, default_value_t = 0)]
    from: u32,
    /// Which scenes
    #[arg(long, value_enum, default_value_t = Kind::Mixed)]
    kind: Kind,
    /// These scenes alone, by the names that the others are told by: batch and place in it
    #[arg(long, num_args = 1.., value_name = "BATCH.PLACE", conflicts_with_all = ["scenes", "from"])]
    only: Vec<Name>,
    /// The events of those scenes, the engine's beside the reference's and its perturbed runs'
    #[arg(long, requires = "only")]
    events: bool,
    /// Derivatives by parameters, against differences
    #[arg(long)]
    derivatives: bool,
    /// How far the air errs over what was asked of it, of this many drawn hammers
    #[arg(long, conflicts_with_all = ["only", "derivatives", "accounts", "kind"])]
    asked: bool,
    /// Add what came of each batch to reports/verification/compared.json, from where `cargo verify` takes it, or put it
    /// in the place of what came of it before; write that of derivatives to reports/derivatives.md
    #[arg(long, conflicts_with = "only")]
    keep: bool,
    /// What the reference says of the scenes, which no change of the engine changes: read from this file, or
    /// written to it if there is none
    #[arg(long, conflicts_with_all = ["only", "derivatives", "keep"])]
    accounts: Option<PathBuf>,
}

/// What the report of derivatives is about.
const ABOUT: &str = "# How often the errors of derivatives hold

Drawn hammers, each simulated to its end and differentiated by four of its parameters in turn. The true derivative is a
central difference in double-double arithmetic over 2^-36 of the parameter, right to all digits of a double. Beside each
derivative the engine tells an estimate of its error, from two steps: how often is the true error within it? Where it
is not, it is still by rounding alone if it is less than one unit in the last place of the quantity's size over
the engine's step.

Two of the first 240 scenes disagree (`scene BATCH.PLACE` of `cargo compare --derivatives`), both by the reference. 1.7: the
rock's viscosity is retuned on the way to a number that is rounded to double precision, which is 4.3 millionths of what it
changes over 2^-36. 1.11: the rock is retuned at the instant of an event, before it on one side and behind it on the other;
over 2^-30 the reference's difference is 64 times smaller.
";

/// The folder of reports.
const REPORTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../reports");

/// What came of drawn scenes, in that folder.
const COMPARED: &str = "verification/compared.json";

/// What drawn hammers reached of the error asked, there too.
const ASKED: &str = "verification/asked.txt";

/// Writes a report, and says why it cannot.
fn write(name: &str, text: &str) -> ExitCode {
    let path = format!("{REPORTS}/{name}");
    match std::fs::write(&path, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {path}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What is kept of drawn scenes.
fn stored() -> Kept {
    let text = std::fs::read_to_string(format!("{REPORTS}/{COMPARED}")).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// The scenes of a file of accounts, and what the reference says of them.
type Stored = ((u32, u32), Kind, Vec<Account>);

/// Accounts from a file, or for it.
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
