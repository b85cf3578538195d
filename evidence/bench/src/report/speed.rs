//! `reports/speed-against-error.md`: work against precision of the engine and its peers.

use crate::contest::{Contest, ELEMENTS, Point, aired};
use crate::{Written, duration};
use bench::Failure;
use bench::schema::Task;
use hammer::{InputValues, Parameters};
use oracles::model::Model;
use oracles::reference::solve;
use oracles::taylor::Accuracy;
use serde::Serialize;
use std::fmt::Write as _;
use verify::reference::overdamped;
use verify::scene::finite_elements;

const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-8];
const OURS: &str = "this engine";
/// A pressure cycle of the hammer that all solve, s.
const CYCLE: f64 = 45.389e-3;
const ROUNDS: usize = 3;

/// Everything measured.
#[derive(Serialize)]
struct Data {
    processor: String,
    rounds: usize,
    instants: Vec<f64>,
    /// To what the reference is known.
    known: f64,
    events: usize,
    points: Vec<Point>,
    absent: Vec<(&'static str, String)>,
}

/// Measures: all solvers in turn on one core, the fastest round counts.
///
/// # Errors
/// No reference, or no folder for the C program.
pub fn page() -> Result<Written, Failure> {
    // Child processes and threads inherit the core.
    if let Some(&core) = core_affinity::get_core_ids().unwrap_or_default().last() {
        core_affinity::set_for_current(core);
    }
    let instants = [10e-3, 13.72e-3, 14e-3, 15e-3, 17e-3, 20e-3, CYCLE];
    let orders = [(40, 1e-31), (34, 1e-30)];
    let data = contest(&overdamped(ELEMENTS), &instants, orders, |field| field.of_steel())?;
    let text = head(&data) + &ratios(&data) + &every(&data) + &of_air()?;
    Ok(Written { text, json: serde_json::to_string(&data)?, figure: true })
}

/// A contest from rest over some instants, the last of which is its end. The reference is computed by series of two
/// orders and tolerances.
fn contest(
    p: &Parameters,
    instants: &[f64],
    orders: [(usize, f64); 2],
    field: fn(Contest) -> Result<Contest, Failure>,
) -> Result<Data, Failure> {
    let scene = finite_elements(p, &InputValues::default());
    let accuracies = orders.map(|(order, tolerance)| Accuracy { order, tolerance });
    let exact = solve(&scene, instants, accuracies)?;
    let (end, instants) = instants.split_last().ok_or("no end")?;
    let task = Task { instants: instants.to_vec(), end: *end, patience: 60.0 };
    let model = Model::new(&scene);
    let mut contest = field(Contest::new(&model, &exact, &task))?;
    let points = contest.run(ROUNDS);
    Ok(Data {
        processor: bench::processor(),
        rounds: ROUNDS,
        instants: task.instants.clone(),
        known: exact.uncertainty,
        events: exact.events.len(),
        points,
        absent: contest.absent,
    })
}

/// The part of the page about a hammer driven by air.
fn of_air() -> Result<String, Failure> {
    let instants = [10e-3, 20e-3, 30e-3, 40e-3, 50e-3];
    let data = contest(&aired(), &instants, [(30, 1e-24), (26, 1e-22)], |field| field.of_air())?;
    let head = format!(
        "\n# With air\n\nThe reference hammer with rigid bodies, driven by air (nine states: place and speed of two \
         bodies, the viscous work, mass and energy of two chambers), from rest over 50 ms: {events} events. The error as above, at 10, 20, 30 and 40 ms, \
         against Taylor series in double-double arithmetic, good to {known:.0e}. The peers pass the edges of ports and \
         from one formula of a flow to another by their root finding, and start anew there. Our setting is \
         `air.error`, theirs the tolerance. heyoka, a Taylor integrator whose steps LLVM compiles for each mode (its \
         set-up), is called from Python; its time is that inside its own loop, without our transitions.\n",
        events = data.events,
        known = data.known,
    );
    Ok(head + &ratios(&data) + &every(&data))
}

fn head(data: &Data) -> String {
    let instants: Vec<String> =
        data.instants.iter().map(|t| format!("{}", (t * 1e5).round() / 100.0)).collect();
    format!(
        "# Speed against error: `cargo bench-report speed`\n\n\
         One run on one core ({processor}), all solvers in turn, {rounds} round(s), the fastest of \
         each counting; CPU times. The reference hammer in very viscous rock (preset `overdamped`), on \
         20 linear elements per bar (84 states and the viscous work), from rest over the first {cycle:.3} ms: one pressure cycle, {events} \
         events. The error is the worst over all nodes and the instants {instants} ms (the blow \
         begins at 13.676 ms, the rebound at 14.392 ms), displacements over 1 mm and velocities \
         over 1 m/s, against a Taylor series of order 40 in double-double arithmetic, itself good to {known:.0e}. \
         An event is found if one of its kind lies within 0.2 us.\n\n\
         Set-up (decompositions, tables, factors) is in no solver's time; it is listed. Each finds \
         its events itself and makes the same transitions. Peers with their own root finding see \
         guards lowered by 1e-14 m and 1e-12 m/s (diffsol's by 1e-9 m/s), for a guard begins its mode on its \
         surface. IDA and diffsol's implicit methods have the equation of motion with its mass, and its \
         exact derivative, banded or sparse; the explicit methods have the factors of the mass, which is \
         tridiagonal. Every one starts anew at an event, where loads and springs jump.\n\n![error against CPU time](speed-against-error.png)\n",
        processor = data.processor,
        rounds = data.rounds,
        cycle = CYCLE * 1e3,
        known = data.known,
        events = data.events,
        instants = instants.join(", "),
    )
}

/// Least CPU time at error `e`: on the lower envelope of a solver's points, linear in log-log between two of them.
fn cost(points: &[&Point], e: f64) -> Option<f64> {
    let mut pairs: Vec<(f64, f64)> = points
        .iter()
        .filter_map(|p| Some((p.verdict?.error.max(1e-16), p.cpu)))
        .filter(|(error, _)| *error < f64::MAX)
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A point of larger error belongs to the envelope only if it is cheaper.
    let mut envelope: Vec<(f64, f64)> = Vec::new();
    for pair in pairs {
        if envelope.last().is_none_or(|last| pair.1 < last.1) {
            envelope.push(pair);
        }
    }
    let within = envelope.iter().rposition(|p| p.0 <= e)?;
    let (a, Some(b)) = (envelope[within], envelope.get(within + 1)) else {
        return Some(envelope[within].1);
    };
    let share = (e / a.0).ln() / (b.0 / a.0).ln();
    Some(a.1 * (b.1 / a.1).powf(share))
}

fn ratios(data: &Data) -> String {
    let of = |solver| data.points.iter().filter(|p| p.solver == solver).collect::<Vec<_>>();
    let whole = |solver: &'static str| -> Vec<Point> {
        of(solver).into_iter().map(|p| Point { cpu: p.cpu + p.setup, ..p.clone() }).collect()
    };
    let mut out = String::from(
        "\n## Time of a cycle at a stated error, and its ratio to ours\n\n\
         Interpolated between settings; *not reached*: by none of the settings tried. Ours is in \
         1 ms steps; what the FMU adds to them is in [cost of the face](face-cost.md).\n\n\
         | solver | 1e-3 | 1e-6 | 1e-8 | 1e-6, with set-up |\n|---|---|---|---|---|\n",
    );
    let ratio = |own: &[&Point], ours: &[&Point], e: f64| match (cost(own, e), cost(ours, e)) {
        (Some(own), Some(ours)) => {
            let digits = usize::from(own < 10.0 * ours);
            format!("{} ({:.digits$}x)", duration(own), own / ours)
        }
        (Some(own), None) => duration(own),
        (None, _) => "not reached".into(),
    };
    let ours = whole(OURS);
    let ours: Vec<&Point> = ours.iter().collect();
    let mut solvers: Vec<&'static str> = data.points.iter().map(|p| p.solver).collect();
    solvers.dedup();
    for solver in solvers {
        let mut cells = TARGETS.map(|e| ratio(&of(solver), &of(OURS), e)).to_vec();
        cells.push(ratio(&whole(solver).iter().collect::<Vec<_>>(), &ours, 1e-6));
        let _ = writeln!(out, "| {solver} | {} |", cells.join(" | "));
    }
    for (solver, reason) in &data.absent {
        let _ = writeln!(out, "\n{solver} was left out: {reason}.");
    }
    out
}

fn every(data: &Data) -> String {
    let mut out = String::from(
        "\n## Every setting\n\n\
         Settings: tolerance (relative; absolute over 1 mm, 1 m/s, 1 J).\n\n\
         | solver | setting | CPU time | slowest round | set-up | error | found | missed | spurious |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for p in &data.points {
        let _ = write!(out, "| {} | {} | ", p.solver, p.setting);
        let _ = match (&p.verdict, &p.failure) {
            (Some(v), None) => {
                let times = [p.cpu, p.slowest, p.setup].map(duration).join(" | ");
                let events = format!("{} | {} | {}", v.found, v.missed, v.spurious);
                writeln!(out, "{times} | {:.1e} | {events} |", v.error)
            }
            (_, reason) => {
                writeln!(out, "failed: {} | | | | | | |", reason.as_deref().unwrap_or("no answer"))
            }
        };
    }
    out
}
