//! What a settled cycle costs the best peers on each mesh, and what it comes to there:
//! one JSON line, for `whole_error.py`.
//!
//! A peer pays for the mesh as the engine does, so its own best mesh is not the engine's: linear
//! elements for Radau IIA-5, whose systems must stay tridiagonal; spectral elements too for the
//! tabulated propagators, whose matrices are full anyway.

use bench::engine::machine;
use bench::hybrid;
use bench::radau::Radau;
use bench::tabulated::Tabulated;
use bench::trajectory::{Peer, Task, Trajectory};
use cpu_time::ThreadTime;
use hammer::Parameters;
use indicatif::ProgressBar;
use oracles::law::Event;
use oracles::model::Model;
use oracles::reference::stored;
use oracles::scene::{Fidelity, Scene};
use serde::Serialize;

/// Cycles from rest: each brings the response four times closer to the stationary one.
const CYCLES: usize = 20;
/// Of these the last ones are measured.
const MEASURED: usize = 5;
/// About a period, s: only how long to run.
const PERIOD: f64 = 45.5e-3;
/// Wall-clock seconds after which a run is given up.
const PATIENCE: f64 = 120.0;
/// Meshes: degree (1: linear elements) and elements per body, by solver.
const TABULATED: [(usize, usize); 7] = [(1, 20), (1, 40), (4, 5), (4, 8), (6, 6), (8, 4), (8, 6)];
const RADAU: [(usize, usize); 4] = [(1, 20), (1, 40), (1, 80), (1, 160)];
/// Scan steps (s) and tolerances.
const SCANS: [f64; 2] = [1e-6, 5e-7];
const TOLERANCES: [f64; 2] = [1e-4, 1e-6];

/// One peer, one mesh, one setting.
#[derive(Serialize)]
struct Row {
    solver: &'static str,
    degree: usize,
    elements: usize,
    setting: f64,
    /// CPU time per cycle over that of the engine on twenty linear elements.
    cost: f64,
    /// s.
    period: f64,
    /// m/s.
    rop: f64,
}

fn meshed(degree: usize, elements: usize) -> Result<Scene, std::io::Error> {
    let mut scene = stored(20)?.scene;
    scene.fidelity = if degree == 1 { Fidelity::Elastic } else { Fidelity::Spectral(degree) };
    for body in &mut scene.bodies {
        body.sections[0].elements = elements;
    }
    Ok(scene)
}

/// Instants at which the piston is turned upwards, one per cycle.
fn turns(done: &Trajectory) -> Vec<f64> {
    done.events.iter().filter(|(_, event)| *event == Event::Q9).map(|&(time, _)| time).collect()
}

/// CPU time per cycle, period and rate of penetration: two runs, for the second asks for the tip
/// a whole number of the first's periods apart.
fn settled(
    model: &Model<f64>,
    mut solve: impl FnMut(&Task) -> Result<Trajectory, String>,
) -> Result<[f64; 3], String> {
    let end = CYCLES as f64 * PERIOD;
    let clock = ThreadTime::now();
    let first = solve(&Task { instants: Vec::new(), end, patience: PATIENCE })?;
    let cost = clock.elapsed().as_secs_f64() / CYCLES as f64;
    let turns = turns(&first);
    let [.., last] = turns[..] else { return Err("no cycle".into()) };
    let before = *turns.iter().rev().nth(MEASURED).ok_or("too few cycles")?;
    let again = solve(&Task { instants: vec![before, last], end, patience: PATIENCE })?;
    let tip = |k: usize| again.states[k].u[model.nodes() - 1];
    let span = last - before;
    Ok([cost, span / MEASURED as f64, (tip(1) - tip(0)) / span])
}

/// CPU time of a settled cycle of the engine on twenty linear elements, s.
fn engine() -> f64 {
    let mut machine = machine(&Parameters::default());
    let mut run = |cycles: usize| {
        let (clock, begin) = (ThreadTime::now(), machine.time());
        for step in 1..=cycles * 45 {
            machine.advance(begin + 1e-3 * step as f64).expect("the reference hammer runs");
        }
        clock.elapsed().as_secs_f64() / (45e-3 * cycles as f64 / PERIOD)
    };
    run(CYCLES);
    (0..5).map(|_| run(CYCLES)).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ours = engine();
    let bar = ProgressBar::new((TABULATED.len() * 2 + RADAU.len() * 2) as u64);
    let mut rows = Vec::new();
    let mut keep = |solver, (degree, elements), setting, found: Result<[f64; 3], String>| {
        bar.inc(1);
        match found {
            Ok([cost, period, rop]) => {
                let cost = cost / ours;
                rows.push(Row { solver, degree, elements, setting, cost, period, rop });
            }
            Err(why) => bar.println(format!("{solver}, {elements} elements: {why}")),
        }
    };
    for mesh in TABULATED {
        let model = Model::new(&meshed(mesh.0, mesh.1)?);
        for scan in SCANS {
            let mut peer = Tabulated::new(&model, scan);
            keep("tabulated propagators", mesh, scan, settled(&model, |task| peer.run(task)));
        }
    }
    for mesh in RADAU {
        let model = Model::new(&meshed(mesh.0, mesh.1)?);
        for tolerance in TOLERANCES {
            let solve =
                |task: &Task| hybrid::run(&model, &mut Radau::adaptive(&model, tolerance), task);
            keep("Radau IIA-5, adaptive", mesh, tolerance, settled(&model, solve));
        }
    }
    bar.finish_and_clear();
    println!("{}", serde_json::to_string(&rows)?);
    Ok(())
}
