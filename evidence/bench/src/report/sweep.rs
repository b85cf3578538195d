//! `reports/sweep-cost.md`: what a sweep of the Python package takes beyond its engine.

use crate::{Written, duration, root, timed};
use bench::Failure;
use bench::engine::machine;
use hammer::{Fidelity, Parameters, Vectors};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use support::python::{Environment, Needs};

/// Runs at a time, and the end of each, s.
const THREADS: usize = 2;
const UNTIL: f64 = 1.0;
/// The feed force runs between these, N.
const FEEDS: [f64; 2] = [3e3, 9e3];
/// Most that a sweep by threads may take of the engine's own time.
const GOAL: f64 = 1.2;
const WAYS: [&str; 2] = ["threads", "processes"];

/// What Python is told: parameters beside the feed force, which differs from run to run.
#[derive(Serialize)]
struct Plan<'a> {
    parameters: serde_json::Value,
    feeds: &'a [f64],
    until: f64,
    workers: usize,
    scheduler: &'static str,
}

/// What it answers: CPU seconds of the sweep, its threads and processes, and the hole depths, m.
#[derive(Deserialize)]
struct Done {
    cpu: f64,
    depths: Vec<f64>,
}

/// The same runs by the engine alone: hole depths, m.
fn engine(parameters: &Parameters, feeds: &[f64]) -> Vec<f64> {
    let (next, depths) = (AtomicUsize::new(0), Mutex::new(vec![0.0; feeds.len()]));
    let work = || {
        while let Some((run, feed)) = {
            let run = next.fetch_add(1, Ordering::Relaxed);
            feeds.get(run).map(|feed| (run, *feed))
        } {
            let inputs = hammer::InputValues { feed_force: feed, ..Default::default() };
            let mut machine =
                hammer::Machine::new(parameters, &inputs, 0.0).expect("a valid scene");
            machine.advance(UNTIL).expect("the reference hammer runs");
            depths.lock().expect("no thread panics")[run] = machine.kinematics().hole_depth;
        }
    };
    std::thread::scope(|scope| (0..THREADS).for_each(|_| drop(scope.spawn(work))));
    depths.into_inner().expect("no thread panics")
}

fn python(environment: &Environment, plan: &Plan) -> Result<Done, Failure> {
    let mut command = environment.command("python");
    command.arg("evidence/bench/sweep.py").stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn()?;
    child.stdin.take().ok_or("no pipe")?.write_all(&serde_json::to_vec(plan)?)?;
    let output = child.wait_with_output()?;
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// Measures: in each round the engine, then each way; the middle of the rounds counts.
///
/// # Errors
/// If there is no Python environment, or the numbers differ.
pub fn page(short: bool) -> Result<Written, Failure> {
    let (runs, rounds) = if short { (20, 1) } else { (400, 5) };
    let environment = Environment::prepare(&root(), Needs::Suite)?;
    let feeds: Vec<f64> =
        (0..runs).map(|i| FEEDS[0] + (FEEDS[1] - FEEDS[0]) * i as f64 / runs as f64).collect();
    let rigid = Parameters { fidelity: Fidelity::Rigid, ..Default::default() };
    let scenes = [
        ("20 elements per bar", Parameters::default(), serde_json::json!({})),
        ("rigid bodies", rigid, serde_json::json!({"fidelity": 1})),
    ];
    let mut text = format!(
        "# Cost of a sweep: `cargo bench-report sweep`\n\n\
         {runs} runs of {UNTIL} s each over the feed force, on {THREADS} threads or processes \
         ({}). **Engine**: the same runs in a Rust program that knows the engine alone; the hole \
         depths are the same to the last bit. **Sweep**: CPU time from the call of \
         `dth_hammer.sweep` to its table, without the start of Python. All in turn, {rounds} \
         round(s): the middle of the ratios, and their range.\n\n\
         | bodies | engine, CPU a run | sweep by | sweep over engine |\n|---|---|---|---|\n",
        bench::processor(),
    );
    assert!(Vectors::in_use().select());
    let mut verdict = String::new();
    for (scene, parameters, given) in &scenes {
        drop(machine(parameters));
        let (mut alone, mut ratios) = (Vec::new(), vec![Vec::new(); WAYS.len()]);
        for _ in 0..rounds {
            let (depths, cpu) = timed(|| engine(parameters, &feeds));
            alone.push(cpu / f64::from(runs));
            for (scheduler, ratios) in WAYS.iter().zip(&mut ratios) {
                let (parameters, workers) = (given.clone(), THREADS);
                let plan = Plan { parameters, feeds: &feeds, until: UNTIL, workers, scheduler };
                let done = python(&environment, &plan)?;
                if done.depths != depths {
                    return Err(format!("{scene}, {scheduler}: other numbers").into());
                }
                ratios.push(done.cpu / cpu);
            }
        }
        let middle = |list: &mut Vec<f64>| {
            list.sort_by(f64::total_cmp);
            list[list.len() / 2]
        };
        let own = duration(middle(&mut alone));
        for (way, ratios) in WAYS.iter().zip(&mut ratios) {
            let median = middle(ratios);
            let (low, high) = (ratios[0], ratios[ratios.len() - 1]);
            let _ =
                writeln!(text, "| {scene} | {own} | {way} | {median:.2} ({low:.2} to {high:.2}) |");
            if verdict.is_empty() {
                let met = if median <= GOAL { "met" } else { "missed" };
                verdict = format!(
                    "\nThe reference hammer by {way}: {median:.2}; the goal, {GOAL}, is {met}.\n"
                );
            }
        }
    }
    Ok(Written { text: text + &verdict, json: String::new(), figure: false })
}
