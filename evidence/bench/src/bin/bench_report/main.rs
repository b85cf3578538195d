//! `cargo bench-report`: work-precision of the engine beside general solvers.
//!
//! One run, one core, all solvers in turn, several rounds; CPU time; errors against the
//! extended-precision reference. Writes `docs/speed-against-error.{md,json,svg}`, in
//! `--short` form only under the target folder.

mod contest;
mod fmu;
mod outside;
mod report;
mod studies;

use bench::trajectory::Task;
use clap::Parser;
use contest::{Contest, Point};
use oracles::model::Model;
use oracles::reference::stored;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Why the report was not written.
pub type Failure = Box<dyn std::error::Error>;

#[derive(Parser)]
#[command(about = "Measures speed against error and writes the report")]
struct Arguments {
    /// One round and the quick settings only, for CI; nothing is written into `docs`
    #[arg(long)]
    short: bool,
    /// Rounds of the contest; the fastest counts
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Leave SciPy out
    #[arg(long)]
    without_scipy: bool,
    /// Measure nothing: write text and figure anew from the data in `docs`
    #[arg(long)]
    rewrite: bool,
}

/// Everything measured.
#[derive(Serialize, Deserialize)]
pub struct Data {
    /// Name of the processor.
    pub processor: String,
    /// Rounds.
    pub rounds: usize,
    /// Length of the integration, s.
    pub cycle: f64,
    /// Instants of the error, s.
    pub instants: Vec<f64>,
    /// Events of the reference within the cycle.
    pub events: usize,
    /// The work-precision points.
    pub points: Vec<Point>,
    /// Solvers that were left out, with the reason.
    pub absent: Vec<(String, String)>,
    /// The engine's own studies.
    pub studies: studies::Studies,
}

/// The workspace.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("bench is a member of a workspace").to_path_buf()
}

/// Where cargo builds, and what the report needs is kept.
pub fn target() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").map_or("target".into(), PathBuf::from))
}

fn measure(arguments: &Arguments) -> Result<Data, Failure> {
    // Children and threads inherit it: everything alternates on one core.
    let cores = core_affinity::get_core_ids().unwrap_or_default();
    if let Some(&core) = cores.last() {
        core_affinity::set_for_current(core);
    }
    let rounds = if arguments.short { 1 } else { arguments.rounds };
    let record = stored(20)?;
    let task = Task::cycle(&record);
    let model = Model::new(&record.scene);
    let library = fmu::unpack()?;
    let mut contest = Contest::new(&model, &record, &task, arguments.short);
    contest.add_engine(&library)?;
    contest.add_compiled();
    contest.add_sundials();
    if !arguments.without_scipy {
        contest.add_scipy()?;
    }
    let (points, absent) = contest.run(rounds);
    Ok(Data {
        processor: bench::processor(),
        rounds,
        cycle: task.end,
        instants: task.instants.clone(),
        events: record.events.iter().filter(|e| e.time <= task.end).count(),
        points,
        absent,
        studies: studies::all(&library, (&model, &record), &cores, arguments.short)?,
    })
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let folder = if arguments.short { target().join("bench-report") } else { root().join("docs") };
    std::fs::create_dir_all(&folder)?;
    let name = folder.join("speed-against-error");
    let data = if arguments.rewrite {
        serde_json::from_str(&std::fs::read_to_string(name.with_extension("json"))?)?
    } else {
        measure(&arguments)?
    };
    std::fs::write(name.with_extension("json"), serde_json::to_string_pretty(&data)? + "\n")?;
    std::fs::write(name.with_extension("md"), report::text(&data))?;
    outside::draw(&name)?;
    println!("{}", name.with_extension("md").display());
    Ok(())
}
