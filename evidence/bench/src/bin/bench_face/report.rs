//! `docs/face-cost.md`, from what was measured and nothing else.

use crate::measure::ROWS;
use crate::{Data, Row, Spread};
use std::fmt::Write as _;

/// Goals: ns that a step of the FMU may take beyond the engine's.
const STEP_GOAL: f64 = 100.0;
/// ns from dlopen to the end of the first step.
const START_GOAL: f64 = 2e6;

/// The page.
pub fn text(data: &Data) -> String {
    let mut out = format!(
        "# Cost of the face\n\n\
         Written by `cargo bench-face`: what a call of the FMU costs, beside the same call of an \
         FMU whose functions do nothing (`evidence/bench/empty`) and, where there is the like, of the \
         engine alone. All are called from Rust, the libraries through their C symbols; one core \
         ({processor}), {rounds} rounds of each in turn. The median of the rounds, and in brackets \
         their quartiles. The reference hammer with 20 elements per bar; {inputs} inputs, {outputs} \
         outputs; the quiet stretch is 4 ms before the first blow in steps of 1 us, and that no \
         event falls in it is checked. What the face costs is the first column less the third.\n\n\
         | calls | this FMU | an empty FMU | the engine alone | the face |\n\
         |---|---|---|---|---|\n",
        processor = data.processor,
        rounds = data.rounds,
        inputs = data.ports[0],
        outputs = data.ports[1],
    );
    for row in &data.rows {
        let cell = |spread: &Option<Spread>| spread.as_ref().map_or("".into(), shown);
        let face = own(row).map_or(String::new(), duration);
        let (fmu, empty) = (shown(&row.fmu), shown(&row.empty));
        let engine = cell(&row.engine);
        // Writing to a String cannot fail.
        let _ = writeln!(out, "| {} | {fmu} | {empty} | {engine} | {face} |", row.name);
    }
    goals(&mut out, data);
    out
}

/// The face's own part of the cost, ns.
fn own(row: &Row) -> Option<f64> {
    row.engine.as_ref().map(|engine| row.fmu.median - engine.median)
}

fn goals(out: &mut String, data: &Data) {
    let find = |name: &str| data.rows.iter().find(|row| row.name == name);
    let verdict = |value: f64, goal: f64| if value <= goal { "met" } else { "missed" };
    let step = find(ROWS[0]).and_then(own);
    let start = find(ROWS[ROWS.len() - 1]).map(|row| row.fmu.median);
    for (what, value, goal) in [
        ("A step beyond the engine's own", step, STEP_GOAL),
        ("From dlopen to the end of the first step", start, START_GOAL),
    ] {
        let Some(value) = value else { continue };
        let (shown, limit) = (duration(value), duration(goal));
        let _ = write!(out, "\n{what}: {shown}; the goal, {limit}, is {}.\n", verdict(value, goal));
    }
}

fn shown(spread: &Spread) -> String {
    let [low, high] = spread.quartiles.map(duration);
    format!("{} ({low} to {high})", duration(spread.median))
}

/// `12.3 us` and the like.
fn duration(ns: f64) -> String {
    match ns.abs() {
        x if x >= 1e6 => format!("{:.2} ms", ns / 1e6),
        x if x >= 1e3 => format!("{:.1} us", ns / 1e3),
        x if x >= 10.0 => format!("{ns:.0} ns"),
        _ => format!("{ns:.1} ns"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(median: f64) -> Spread {
        Spread { median, quartiles: [median; 2] }
    }

    #[test]
    fn a_goal_that_is_missed_is_called_so() {
        let row = |name: &str, fmu| Row {
            name: name.into(),
            fmu: spread(fmu),
            empty: spread(1.0),
            engine: Some(spread(10.0)),
        };
        let text = |step, start| {
            let rows = vec![row(ROWS[0], step), row(ROWS[ROWS.len() - 1], start)];
            text(&Data { processor: String::new(), rounds: 1, ports: [4, 42], rows })
        };
        let fast = text(110.0, 2e6);
        assert!(fast.contains("100 ns; the goal, 100 ns, is met") && !fast.contains("missed"));
        assert_eq!(text(111.0, 2.1e6).matches("is missed").count(), 2);
    }
}
