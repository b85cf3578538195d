//! `cargo bench-face`: what the FMU's own face costs. Writes `docs/face-cost.{md,json}`, in
//! `--short` form only under the target folder.

mod measure;
mod report;

use bench::Failure;
use clap::Parser;
use measure::{Ports, ROWS, Round};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use support::run::{cargo, run, target};

#[derive(Parser)]
#[command(about = "Measures what a call of the FMU costs")]
struct Arguments {
    /// A few rounds, to see that it runs; nothing is written into `docs`
    #[arg(long)]
    short: bool,
    /// Rounds
    #[arg(long, default_value_t = 301)]
    rounds: usize,
}

/// Everything measured.
#[derive(Serialize, Deserialize)]
struct Data {
    /// Name of the processor.
    processor: String,
    rounds: usize,
    /// Numbers of inputs and outputs.
    ports: [usize; 2],
    rows: Vec<Row>,
}

/// One kind of call, ns.
#[derive(Serialize, Deserialize)]
struct Row {
    name: String,
    fmu: Spread,
    empty: Spread,
    engine: Option<Spread>,
}

/// Of many rounds.
#[derive(Serialize, Deserialize)]
struct Spread {
    median: f64,
    quartiles: [f64; 2],
}

impl Spread {
    /// Of one row of the rounds; nothing if it was not measured.
    fn of(rounds: &[Round], row: usize) -> Option<Self> {
        let mut samples: Vec<f64> = rounds.iter().filter_map(|round| round[row]).collect();
        samples.sort_by(f64::total_cmp);
        let at = |part: usize| samples.get(samples.len() * part / 4).copied();
        Some(Self { median: at(2)?, quartiles: [at(1)?, at(3)?] })
    }
}

/// The workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("bench is a member of a workspace").to_path_buf()
}

/// Builds a library as it is shipped.
fn build(package: &str, name: &str) -> Result<PathBuf, Failure> {
    let root = root();
    run(cargo(&root).args([
        "build",
        "--quiet",
        "--profile",
        "fmu",
        "--lib",
        "--package",
        package,
    ]))?;
    let (begin, end) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Ok(target(&root).join("fmu").join(format!("{begin}{name}{end}")))
}

fn measure(rounds: usize) -> Result<Data, Failure> {
    let (hammer, empty) = (build("dth-fmu", "dth_hammer")?, build("empty-fmu", "empty_fmu")?);
    if let Some(core) = core_affinity::get_core_ids().unwrap_or_default().last() {
        core_affinity::set_for_current(*core);
    }
    let ports = Ports::all();
    let mut all: [Vec<Round>; 3] = Default::default();
    for _ in 0..rounds {
        all[0].push(measure::fmu(&hammer, &ports)?);
        all[1].push(measure::fmu(&empty, &ports)?);
        all[2].push(measure::engine(&ports)?);
    }
    let row = |(row, name): (usize, &&str)| {
        let [fmu, empty, engine] = all.each_ref().map(|rounds| Spread::of(rounds, row));
        Some(Row { name: (*name).into(), fmu: fmu?, empty: empty?, engine })
    };
    let rows = ROWS.iter().enumerate().filter_map(row).collect();
    Ok(Data { processor: bench::processor(), rounds, ports: ports.count(), rows })
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let folder =
        if arguments.short { target(&root()).join("bench-face") } else { root().join("docs") };
    std::fs::create_dir_all(&folder)?;
    let data = measure(if arguments.short { 11 } else { arguments.rounds })?;
    let name = folder.join("face-cost");
    std::fs::write(name.with_extension("json"), serde_json::to_string_pretty(&data)? + "\n")?;
    std::fs::write(name.with_extension("md"), report::text(&data))?;
    println!("{}", name.with_extension("md").display());
    Ok(())
}
