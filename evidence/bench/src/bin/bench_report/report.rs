//! The report's text, from what was measured and nothing else.

use crate::Data;
use crate::contest::{Point, SAMPLED};
use std::fmt::Write as _;

const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-8];
const OURS: &str = "this engine, fmi2DoStep";
const OURS_ALONE: &str = "this engine";

/// `docs/speed-against-error.md`.
pub fn text(data: &Data) -> String {
    let mut out = head(data);
    ratios(&mut out, data);
    every(&mut out, data);
    proof(&mut out, data);
    vectors(&mut out, data);
    sizes(&mut out, data);
    steps(&mut out, data);
    grades(&mut out, data);
    rest(&mut out, data);
    out
}

/// `1.23 ms` and the like.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.3} ms", s * 1e3),
        s if s >= 1e-6 => format!("{:.1} us", s * 1e6),
        s => format!("{:.0} ns", s * 1e9),
    }
}

fn head(data: &Data) -> String {
    let instants: Vec<String> =
        data.instants.iter().map(|t| format!("{}", (t * 1e5).round() / 100.0)).collect();
    format!(
        "# Speed against error\n\n\
         Written by `cargo bench-report`; every number below was measured in one run on one core \
         ({processor}), all solvers in turn, {rounds} round(s), the fastest of each counting. \
         Times are CPU times.\n\n\
         **Task.** The reference hammer, 20 elements per bar (84 states and the viscous work), from \
         rest over the first {cycle:.3} ms: one pressure cycle, {events} events. \
         **Error** of a solution `(u, v)` against the reference `(u*, v*)`:\n\n\
         ```text\n\
         e = max over t, i of max(|u_i(t) - u*_i(t)| / 1 mm, |v_i(t) - v*_i(t)| / 1 m/s)\n\
         ```\n\n\
         over all nodes `i` and the instants `t` = {instants} ms (the blow begins at 13.676 ms, the \
         rebound at 14.392 ms). The FMU's outputs are not of nodes: the `e` of `fmi2DoStep` is over \
         piston mean, bit mean, tip and gap. (The error over nodes is up to {factor:.0} times that \
         over these.) The \
         reference is a Taylor series of order 40 in double-double arithmetic \
         (`evidence/oracles/src/reference.rs`, `evidence/oracles/data/reference_20.json`), whose own error by two orders \
         and tolerances is below 1e-20. An event is found if one of its kind lies within 0.2 us.\n\n\
         Set-up (decompositions, tables, factors) is not in the time of a cycle for any solver; it \
         is listed. Each solver detects events itself and makes the same transitions; guards start \
         a mode on their surface, so peers with their own root finding see them lowered by the \
         resolution (1e-9 m/s, 1e-14 m).\n\n\
         ![error against CPU time](speed-against-error.svg)\n\n",
        processor = data.processor,
        rounds = data.rounds,
        cycle = data.cycle * 1e3,
        events = data.events,
        instants = instants.join(", "),
        factor = shown_factor(data).ceil(),
    )
}

/// Largest ratio of the error over nodes to that over what is shown.
fn shown_factor(data: &Data) -> f64 {
    let verdicts = data.points.iter().filter_map(|p| p.verdict);
    let small = verdicts.filter(|v| v.shown > 0.0 && v.error < 1e-2);
    small.fold(1.0, |max, v| f64::max(max, v.error / v.shown))
}

/// The solvers in the order of the contest.
fn solvers(data: &Data) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for point in &data.points {
        if !names.contains(&point.solver.as_str()) {
            names.push(&point.solver);
        }
    }
    names
}

/// Least CPU time at error `e`: along the envelope of a solver's points, straight in
/// log-log between two of them.
fn cost(points: &[&Point], e: f64) -> Option<f64> {
    let mut pairs: Vec<(f64, f64)> = points
        .iter()
        .filter_map(|p| Some((p.verdict?.error.max(1e-16), p.cpu)))
        .filter(|(error, _)| *error < f64::MAX)
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Going to larger errors a point must be cheaper to be worth anything.
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

fn ratios(out: &mut String, data: &Data) {
    let of = |solver: &str| -> Vec<&Point> {
        data.points.iter().filter(|p| p.solver == solver).collect()
    };
    out.push_str(
        "## Time of a cycle at a stated error, and its ratio to ours\n\n\
         Interpolated between settings; *not reached*: by none of the settings tried. Ours is \
         `fmi2DoStep` with 1 ms steps.\n\n\
         | solver | 1e-3 | 1e-6 | 1e-8 |\n|---|---|---|---|\n",
    );
    for solver in solvers(data) {
        write!(out, "| {solver} |").expect("a String takes it");
        for target in TARGETS {
            let cell = match (cost(&of(solver), target), cost(&of(OURS), target)) {
                (Some(own), Some(ours)) => format!("{} ({:.0}x)", duration(own), own / ours),
                (Some(own), None) => duration(own),
                (None, _) => "not reached".into(),
            };
            write!(out, " {cell} |").expect("a String takes it");
        }
        out.push('\n');
    }
    for (solver, reason) in &data.absent {
        writeln!(out, "\n{solver} was left out: {reason}.").expect("a String takes it");
    }
}

fn every(out: &mut String, data: &Data) {
    out.push_str(
        "\n## Every setting\n\n\
         | solver | setting | CPU time | slowest round | set-up | error | found | missed | spurious |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for p in &data.points {
        write!(out, "| {} | {} |", p.solver, p.setting).expect("a String takes it");
        let setup = if p.setup > 0.0 { duration(p.setup) } else { "-".into() };
        match (&p.verdict, &p.failure) {
            (Some(v), _) => {
                // The FMU counts its events and does not list them.
                let events = match p.solver.as_str() {
                    OURS => "- | - | -".into(),
                    _ => format!("{} | {} | {}", v.found, v.missed, v.spurious),
                };
                let (cpu, slowest) = (duration(p.cpu), duration(p.slowest));
                writeln!(out, " {cpu} | {slowest} | {setup} | {:.1e} | {events} |", v.error)
            }
            (None, Some(reason)) => writeln!(out, " failed: {reason} | | | | | | |"),
            (None, None) => Ok(()),
        }
        .expect("a String takes it");
    }
    out.push_str(
        "\nSettings: tolerance (relative; absolute over 1 mm, 1 m/s, 1 J), step (s) of \
         generalised-alpha (spectral radius 0.8) and fixed Radau, scan step (s) of the tabulated \
         propagators; the exponential integrator looks for events every 0.25 us; longest stride (s) between \
         samples of the guards, rounded down to a tabulated rotation. Set-up of this engine: from parameters to the end of a first cycle, which \
         decomposes every system it meets.\n",
    );
}

/// What the engine takes with its certification and without it.
fn proof(out: &mut String, data: &Data) {
    let Some(ours) = data.points.iter().find(|p| p.solver == OURS_ALONE) else { return };
    let sampled = || data.points.iter().filter(|p| p.solver == SAMPLED);
    let whole = |p: &&Point| p.verdict.is_some_and(|v| v.missed + v.spurious == 0);
    let cheapest = sampled().filter(whole).min_by(|a, b| a.cpu.total_cmp(&b.cpu));
    let Some(best) = cheapest else { return };
    let lossy = sampled().filter(|p| p.verdict.is_some_and(|v| v.missed > 0));
    let quickest = lossy.min_by(|a, b| a.cpu.total_cmp(&b.cpu));
    write!(
        out,
        "\n## What the proof costs\n\n\
         *{SAMPLED}* has the engine's propagation, guards and transitions, but looks at the guards \
         in strides of fixed length and finds a zero where one has risen: no bounds, no proof. The \
         longest of the strides tried that loses no event is {} s: {}, {:.1} times what the engine \
         takes with its proof ({}). The bounds that prove a stride clear also say how far the next \
         may go, and most of a cycle is silence.",
        best.setting,
        duration(best.cpu),
        best.cpu / ours.cpu,
        duration(ours.cpu),
    )
    .expect("a String takes it");
    if let Some((p, v)) = quickest.and_then(|p| Some((p, p.verdict?))) {
        write!(
            out,
            " In strides of {} s it takes {} ({:.1} times), finds {} of the events, misses {} and \
             makes {} up.",
            p.setting,
            duration(p.cpu),
            p.cpu / ours.cpu,
            v.found,
            v.missed,
            v.spurious
        )
        .expect("a String takes it");
    }
    out.push('\n');
}

fn vectors(out: &mut String, data: &Data) {
    out.push_str(
        "\n## Cost by the vectors of the processor\n\n\
         A settled cycle in the engine, 1 ms steps; the results are the same to the last bit. Works and \
         losses are worked off when an energy is asked for, and from some 120 cycles on.\n\n\
         | vectors | of 20 cycles, no energy asked for | of 400 | with the energies after every step |\n\
         |---|---|---|---|\n",
    );
    for s in &data.studies.vectors {
        let [cycle, long, energies] = [s.cycle, s.long, s.with_energies].map(duration);
        writeln!(out, "| {} | {cycle} | {long} | {energies} |", s.vectors)
            .expect("a String takes it");
    }
}

fn sizes(out: &mut String, data: &Data) {
    out.push_str(
        "\n## Cost against the number of elements\n\n\
         From rest, 1 ms steps. The first cycle decomposes the systems it meets; again, they are there.\n\n\
         | elements per bar | new | first cycle | the same again | events |\n|---|---|---|---|---|\n",
    );
    for s in &data.studies.sizes {
        writeln!(
            out,
            "| {} | {} | {} | {} | {} |",
            s.elements,
            duration(s.setup),
            duration(s.first),
            duration(s.again),
            s.events
        )
        .expect("a String takes it");
    }
}

fn steps(out: &mut String, data: &Data) {
    out.push_str(
        "\n## Cost against the communication step\n\n\
         A cycle. The FMI face is what `fmi2DoStep` takes beyond the engine; reading is one \
         `fmi2GetReal` of eleven outputs per step. Call by call, and beside an FMU that does nothing: \
         [cost of the face](face-cost.md), by `cargo bench-face`.\n\n\
         | step | engine | fmi2DoStep | the FMI face, a step | with reading |\n|---|---|---|---|---|\n",
    );
    for s in &data.studies.steps {
        let face = (s.fmi - s.engine) / (data.cycle / s.step).ceil();
        let face = if face > 0.0 { duration(face) } else { "below the noise".into() };
        writeln!(
            out,
            "| {} | {} | {} | {face} | {} |",
            duration(s.step),
            duration(s.engine),
            duration(s.fmi),
            duration(s.reading)
        )
        .expect("a String takes it");
    }
}

fn grades(out: &mut String, data: &Data) {
    let Some(truth) = data.studies.grades.last() else { return };
    write!(
        out,
        "\n## Which fidelity a scene needs\n\n\
         Stationary response, cost of a cycle in 1 ms steps with the peaks read; differences from \
         {}. Rigid bodies serve where the period and the mean power matter; the advance needs \
         waves, on any mesh; peak forces need as many elements as the percentages ask. Splines, \
         and error against cost of every degree: [speed against whole error](whole-error.md).\n\n\
         | fidelity | CPU time | period | ROP | peak contact force | peak rock force |\n\
         |---|---|---|---|---|---|\n",
        truth.name
    )
    .expect("a String takes it");
    let percent = |a: f64, b: f64| format!("{:+.2} %", 100.0 * (a / b - 1.0));
    for g in &data.studies.grades {
        writeln!(
            out,
            "| {} | {} | {:.3} ms ({}) | {:.2} mm/s ({}) | {:.1} kN ({}) | {:.1} kN ({}) |",
            g.name,
            duration(g.cpu),
            g.period * 1e3,
            percent(g.period, truth.period),
            g.rop * 1e3,
            percent(g.rop, truth.rop),
            g.contact / 1e3,
            percent(g.contact, truth.contact),
            g.rock / 1e3,
            percent(g.rock, truth.rock),
        )
        .expect("a String takes it");
    }
}

fn rest(out: &mut String, data: &Data) {
    let s = &data.studies;
    out.push_str("\n## The engine's error, and its footprint\n\n");
    let mut line = |text: String| writeln!(out, "* {text}").expect("a String takes it");
    let [first, second] = s.blows;
    line(format!(
        "worst error at the instants of the reference: {first:.1e} up to the second blow, \
         {second:.1e} in the 12 ms after it"
    ));
    if let Some((new, later)) = s.memory {
        let kib = |bytes: u64| bytes as f64 / 1024.0;
        line(format!(
            "heap of an instance: {:.0} KiB new, {:.0} KiB after a cycle",
            kib(new),
            kib(later)
        ));
    }
    match &s.instructions {
        Ok(count) => line(format!(
            "instructions of a cycle, 1 ms steps, counted by callgrind: {:.2} million",
            *count as f64 / 1e6
        )),
        Err(reason) => line(format!("instructions not counted: {reason}")),
    }
    for (i, rate) in s.throughput.iter().enumerate() {
        line(format!(
            "{} core(s) at once: {rate:.0} stationary cycles per second of their CPU time, {:.0} s of drilling",
            i + 1,
            rate * 45.389e-3
        ));
    }
}
