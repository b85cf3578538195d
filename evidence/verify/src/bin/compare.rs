//! Drawn scenes, the engine beside the extended-precision reference.
//!
//! `cargo compare --scenes 5000` prints what disagrees and how near the rest came.

use clap::Parser;
use std::process::ExitCode;
use verify::compare::{Tally, tally};

#[derive(Parser)]
#[command(about = "Compares the engine with the extended-precision reference on drawn scenes")]
struct Arguments {
    /// Scenes
    #[arg(long, default_value_t = 5000)]
    scenes: u32,
    /// Number of the first batch of a hundred: other batches are other scenes
    #[arg(long, default_value_t = 0)]
    from: u32,
    /// Scenes without changing inputs, pressures and retuning
    #[arg(long)]
    still: bool,
    /// Derivatives by parameters, against differences
    #[arg(long)]
    tangents: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.tangents {
        let found = verify::tangent::tally(arguments.scenes, arguments.from, |text| {
            println!("{text}");
        });
        return if found.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    let Tally { failures, .. } =
        tally(arguments.scenes, arguments.from, !arguments.still, |text| {
            println!("{text}");
        });
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
