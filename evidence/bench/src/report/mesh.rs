//! `reports/whole-error.md`: cost of a settled cycle against the whole error, in time and space.

use crate::studies::PERIOD;
use crate::{Written, timed};
use bench::Failure;
use bench::engine::machine;
use bench::schema::{Answer, Peer, Task};
use bench::tabulated::Tabulated;
use hammer::{Machine, Parameters};
use indicatif::ProgressBar;
use oracles::law::Event;
use oracles::model::Model;
use oracles::reference::stored;
use oracles::scene::{Fidelity, Scene};
use serde::Serialize;
use std::fmt::Write as _;

/// Spans per body by degree; the first is the cost's unit.
const MESHES: [(usize, &[usize]); 4] = [
    (1, &[20, 40, 80, 160]),
    (3, &[10, 16, 24, 32, 48, 64, 96, 128]),
    (5, &[10, 16, 24, 32, 48, 64, 96, 128]),
    (7, &[10, 16, 24, 32, 48, 60, 64, 96]),
];
/// What errors are against: the finest mesh, and the finest on which the tip is turned early.
const EXACT: (usize, usize) = (7, 128);
const TURNED: (usize, usize) = (7, 80);
/// The peers' meshes, degree (1: linear elements) and elements, with scan steps (s).
const TABULATED: [(usize, usize); 6] = [(1, 20), (1, 40), (4, 5), (4, 8), (8, 4), (8, 6)];
const SCANS: [f64; 2] = [1e-6, 5e-7];
/// Cycles until the response repeats itself, cycles timed, rounds; cycles of a peer, and those read.
const SETTLE: f64 = 80.0;
const TIMED: usize = 8;
const CYCLES: usize = 20;
const READ: usize = 5;
const STEP: f64 = 1e-3;
const QUANTITIES: [&str; 5] = [
    "period",
    "rate of penetration",
    "impact speed",
    "largest contact force",
    "largest rock force",
];

/// A settled hammer on one mesh.
struct Case {
    mesh: (usize, usize),
    machine: Machine,
    seconds: f64,
    values: [f64; 5],
    /// Events of a cycle, and those in it from a blow to nine tenths of the wave's way to the tip.
    events: [f64; 2],
}

/// A row of the table: ours, or a peer's, whose period and rate alone are read.
#[derive(Serialize)]
struct Row {
    solver: &'static str,
    degree: usize,
    elements: usize,
    setting: f64,
    cost: f64,
    events: [f64; 2],
    errors: Vec<f64>,
}

impl Case {
    fn new(mesh: (usize, usize)) -> Result<Self, Failure> {
        let mut parameters = Parameters::default();
        parameters.mesh.degree = mesh.0;
        (parameters.piston.elements, parameters.bit.elements) = (mesh.1, mesh.1);
        let mut machine = machine(&parameters);
        machine.advance(SETTLE * PERIOD)?;
        Ok(Self { mesh, machine, seconds: f64::INFINITY, values: [0.0; 5], events: [0.0; 2] })
    }

    /// Steps of a millisecond over some cycles.
    fn run(&mut self, cycles: usize, mut sample: impl FnMut(&Machine)) -> Result<(), Failure> {
        for _ in 0..(cycles as f64 * PERIOD / STEP).round() as usize {
            self.machine.advance(self.machine.time() + STEP)?;
            sample(&self.machine);
        }
        Ok(())
    }

    fn time(&mut self) -> Result<(), Failure> {
        let (done, seconds) = timed(|| self.run(TIMED, |_| {}));
        self.seconds = self.seconds.min(seconds / TIMED as f64);
        done
    }

    /// The settled response, its peaks over two cycles.
    fn read(&mut self) -> Result<(), Failure> {
        let before = self.machine.counters();
        let mut peaks = [0.0f64; 2];
        self.run(2, |machine| {
            let now = machine.peaks();
            peaks = [peaks[0].max(now.contact_force), peaks[1].max(now.rock_force)];
        })?;
        let after = self.machine.counters();
        let blow = self.machine.blow().ok_or("no blow")?;
        self.values = [blow.period, blow.tip_rate, blow.speed, peaks[0], peaks[1]];
        let blows = (after.blows - before.blows) as f64;
        self.events = [(after.events - before.events) as f64 / blows, self.early()?];
        Ok(())
    }

    fn early(&mut self) -> Result<f64, Failure> {
        let (blows, mut state) = (self.machine.counters().blows, self.machine.state());
        while self.machine.counters().blows == blows {
            state = self.machine.state();
            self.machine.advance(self.machine.time() + STEP)?;
        }
        let strike = self.machine.blow().ok_or("no blow")?.time;
        let p = *self.machine.parameters();
        self.machine.restore(&state)?;
        self.machine.advance(strike + 1e-12)?;
        let before = self.machine.counters().events;
        let speed = (p.material.youngs_modulus / p.material.density).sqrt();
        self.machine.advance(strike + 0.9 * p.bit.length / speed)?;
        Ok((self.machine.counters().events - before) as f64)
    }

    fn row(&self, exact: &Self, unit: f64) -> Row {
        let errors = self.values.iter().zip(exact.values).map(|(a, b)| a / b - 1.0).collect();
        let (solver, (degree, elements)) = ("this engine", self.mesh);
        let cost = self.seconds / unit;
        Row { solver, degree, elements, setting: 0.0, cost, events: self.events, errors }
    }
}

/// CPU time per cycle, period and rate of penetration of a peer: two runs, for the second asks for
/// the tip a whole number of the first's periods apart.
fn peer(peer: &mut dyn Peer, nodes: usize) -> Result<[f64; 3], String> {
    let task = |instants| Task { instants, end: CYCLES as f64 * PERIOD, patience: 120.0 };
    let (first, cpu) = timed(|| peer.run(&task(Vec::new())));
    let turns = |done: &Answer| -> Vec<f64> {
        done.events.iter().filter(|e| e.1 == Event::Q9).map(|e| e.0).collect()
    };
    let turns = turns(&first?);
    let ends = turns.last().zip(turns.iter().rev().nth(READ));
    let (&last, &before) = ends.ok_or("too few cycles")?;
    let again = peer.run(&task(vec![before, last]))?;
    let span = last - before;
    let advance = again.states[1][nodes - 1] - again.states[0][nodes - 1];
    Ok([cpu / CYCLES as f64, span / READ as f64, advance / span])
}

fn meshed((degree, elements): (usize, usize)) -> Result<Scene, std::io::Error> {
    let mut scene = stored(20)?.scene;
    scene.fidelity = if degree == 1 { Fidelity::Elastic } else { Fidelity::Spectral(degree) };
    scene.bodies.iter_mut().for_each(|body| body.sections[0].elements = elements);
    Ok(scene)
}

/// The fastest peer, on meshes of its own.
fn peers(short: bool, exact: &Case, unit: f64) -> Result<Vec<Row>, Failure> {
    let few = if short { 1 } else { usize::MAX };
    let mut rows = Vec::new();
    let mut keep = |solver, mesh: (usize, usize), setting, found: Result<[f64; 3], String>| {
        let Ok([cost, period, tip_rate]) = found else { return };
        let errors = vec![period / exact.values[0] - 1.0, tip_rate / exact.values[1] - 1.0];
        let ((degree, elements), events) = (mesh, [0.0; 2]);
        rows.push(Row { solver, degree, elements, setting, cost: cost / unit, events, errors });
    };
    for &mesh in TABULATED.iter().take(few) {
        let model = Model::new(&meshed(mesh)?);
        for scan in SCANS {
            let found = peer(&mut Tabulated::new(&model, scan), model.nodes());
            keep("tabulated propagators", mesh, scan, found);
        }
    }
    Ok(rows)
}

/// Measures all meshes in turn, the fastest round of each counting.
///
/// # Errors
/// The engine's own.
pub fn page(short: bool) -> Result<Written, Failure> {
    let few = if short { 2 } else { usize::MAX };
    let meshes = MESHES.iter().flat_map(|(d, list)| list.iter().take(few).map(move |&n| (*d, n)));
    let mut cases = meshes.map(Case::new).collect::<Result<Vec<_>, _>>()?;
    let rounds = if short { 1 } else { 5 };
    let bar = ProgressBar::new(rounds * cases.len() as u64);
    for _ in 0..rounds {
        for case in &mut cases {
            case.time()?;
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let (mut exact, mut turned) = (Case::new(EXACT)?, Case::new(TURNED)?);
    cases.iter_mut().chain([&mut exact, &mut turned]).try_for_each(Case::read)?;
    let unit = cases[0].seconds;
    let ours: Vec<Row> = cases.iter().map(|case| case.row(&exact, unit)).collect();
    let kind = cases.iter().filter(|case| case.events == turned.events);
    let own: Vec<Row> = kind.map(|case| case.row(&turned, unit)).collect();
    let theirs = peers(short, &exact, unit)?;
    let apart = turned.row(&exact, unit).errors;
    let mut text = format!(
        "# Speed against whole error: `cargo bench-report mesh`\n\n\
         The reference hammer, settled, in steps of 1 ms with nothing read. In time the engine errs \
         by 1e-12 ([speed against error](speed-against-error.md)); what is left is the mesh. Errors \
         are relative, against degree {} on {} spans per body; cost is CPU time of a cycle over that \
         of twenty linear elements in the same run, the fastest of {rounds} rounds in turn ({}), \
         without set-up.\n\n![error against cost](whole-error.png)\n\n",
        EXACT.0,
        EXACT.1,
        bench::processor(),
    );
    table(&mut text, &ours);
    let _ = write!(
        text,
        "\n**Which of two cycles.** When the piston strikes, the bit still creeps into the rock at \
         some 1e-15 m/s. A mesh lets a little of the wave run ahead of its front; while that is \
         enough to turn the tip, the law ends the old drilling cycle before the front arrives and \
         begins a new one, whose energy barrier is to be paid once more. *Early* counts these \
         events. The two cycles are {:.1e} apart in the period, {:.1e} in the rate of penetration \
         and {:.1e} in the largest rock force: what the law itself leaves open. Against the \
         converged cycle of the kind that turns, degree {} on {} spans:\n\n",
        apart[0].abs(),
        apart[1].abs(),
        apart[4].abs(),
        TURNED.0,
        TURNED.1,
    );
    table(&mut text, &own);
    text += "\n## Peers, each on its own meshes\n\n\
        The fastest of the [other solvers](speed-against-error.md), tabulated propagators that are our own, over twenty cycles from \
        rest, the last five read. Degree 1 is linear elements, a higher one spectral elements on \
        Legendre-Gauss-Lobatto nodes. The setting is the scan step (s).\n\n\
        | solver | degree | elements | setting | cost | period | rate of penetration |\n\
        |---|---|---|---|---|---|---|\n";
    for row in &theirs {
        let Row { solver, degree, elements, setting, cost, errors, .. } = row;
        let errors: Vec<String> = errors.iter().map(|e| format!("{e:+.1e}")).collect();
        let errors = errors.join(" | ");
        let _ = writeln!(
            text,
            "| {solver} | {degree} | {elements} | {setting:e} | {cost:.0} | {errors} |"
        );
    }
    let rows: Vec<Row> = ours.into_iter().chain(theirs).collect();
    let json = serde_json::to_string(&serde_json::json!({"quantities": QUANTITIES, "rows": rows}))?;
    Ok(Written { text, json, figure: true })
}

fn table(text: &mut String, rows: &[Row]) {
    let _ = writeln!(
        text,
        "| degree | spans | cost | events per cycle | early | {} |\n|---|---|---|---|---|{}",
        QUANTITIES.join(" | "),
        "---|".repeat(QUANTITIES.len())
    );
    for row in rows {
        let Row { degree, elements, cost, events: [events, early], errors, .. } = row;
        let errors: Vec<String> = errors.iter().map(|e| format!("{e:+.1e}")).collect();
        let errors = errors.join(" | ");
        let _ = writeln!(
            text,
            "| {degree} | {elements} | {cost:.2} | {events:.0} | {early} | {errors} |"
        );
    }
}
