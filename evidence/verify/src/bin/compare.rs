//! Drawn scenes, the engine beside the extended-precision reference.
//!
//! `cargo compare --scenes 5000` prints what disagrees, what differs by the roughness of the engine's
//! bases alone, what by less than anyone sees, and how near the rest came.

use clap::Parser;
use std::process::ExitCode;
use verify::tally::{Kind, Name, tally, these};

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
    /// Write what came of it to reports/verification/compared.txt, from where `cargo verify` takes it
    #[arg(long, conflicts_with_all = ["only", "derivatives", "kind"])]
    keep: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.derivatives {
        let found = verify::sensitivity::tally(arguments.scenes, arguments.from, |text| {
            println!("{text}");
        });
        return if found.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    let tell = |text: &str| println!("{text}");
    let found = if arguments.only.is_empty() {
        tally(arguments.scenes, arguments.from, arguments.kind, tell)
    } else {
        these(&arguments.only, arguments.kind, arguments.events, tell)
    };
    if arguments.keep {
        let Arguments { scenes, from, .. } = arguments;
        let text = format!("`cargo compare --scenes {scenes} --from {from}`\n\n{}\n", found.line());
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../reports/verification/compared.txt");
        if let Err(error) = std::fs::write(path, text) {
            eprintln!("error: {path}: {error}");
            return ExitCode::FAILURE;
        }
    }
    if found.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
