//! The report: the same rows that the tests assert, as Markdown.

use crate::comparison::tally::{Kept, Tally};
use crate::laws::properties::{Checked, Property, REFUSALS};
use crate::rows::row::Row;
use crate::rows::{
    assembly, casing, catalogue, closed, continuum, cycle, graze, joints, measured, order, shapes,
    string,
};
use clap::ValueEnum;
use hammer::datasheet::DatasheetError;
use std::fmt::Write;

/// A section of rows: its title, the test that asserts it, and its rows.
pub type Section = (&'static str, &'static str, fn() -> Result<Vec<Row>, DatasheetError>);

/// Closed forms, benchmarks, cycles.
pub const SECTIONS: [Section; 22] = [
    ("Two equal-section bars", "rows::two_bars", || Ok(closed::two_bars()?)),
    ("A free bar on a spring", "rows::a_bar_on_a_spring", || Ok(closed::springs()?)),
    ("One rectangular pulse on bilinear rock", "rows::one_rectangular", || Ok(closed::pulses()?)),
    ("One blow on virgin rock", "rows::one_blow", || Ok(closed::blows()?)),
    ("One blow, its front resolved", "rows::front", || Ok(order::resolved_blows()?)),
    ("Relay against a fixed bit, viscous piston", "rows::viscous_piston", || {
        Ok(cycle::relay_viscous()?)
    }),
    ("Relay against a fixed bit, e near 0", "rows::stops_dead", || Ok(cycle::relay_dead()?)),
    ("A casing: waves", "rows::waves", || Ok(casing::waves()?)),
    ("SDNL111", "rows::sdnl111", || Ok(assembly::clamped_bar()?)),
    ("Lundberg's efficiency", "rows::shaped_pistons", || Ok(shapes::efficiencies()?)),
    ("A stepped piston on a stepped bit", "rows::stepped", || Ok(shapes::stepped_impact()?)),
    ("Drawn drill strings", "rows::characteristics", || Ok(string::characteristics()?)),
    ("Loose joints: waves", "rows::wave", || Ok(joints::waves()?)),
    ("Loose joints: momentum trapped", "rows::slack", || Ok(joints::momentum_trapped()?)),
    ("One insert on two rocks", "rows::one_insert", || Ok(measured::rows()?)),
    ("Five hammers of a catalogue", "rows::five_hammers", catalogue::rows),
    ("SDND101", "rows::sdnd101", || Ok(assembly::mass_and_stop()?)),
    ("The stationary response of two earlier solvers", "rows::earlier_solvers", || {
        Ok(cycle::stationary()?)
    }),
    ("The first impact", "rows::first_impact", || Ok(cycle::first_impact()?)),
    ("Fifteen cycles against the continuum", "rows::continuum", || Ok(continuum::rows()?)),
    ("Grazes", "rows::what_is_just_reached", || Ok(graze::rows()?)),
    ("Orders of convergence", "rows::observed", || Ok(order::rows()?)),
];

fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (6 - size.log10().floor() as i32).clamp(0, 9) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.5e}")
    }
}

/// Head of the table that [`rows`] fills.
pub const ROWS: &str = "\nA line a test, `cargo test -p verify --test all ...`, with the row that comes \
    nearest to its tolerance; the tolerances are derived beside each row's code.\n\n\
    | section | test | rows | nearest | reference, source | ours | tolerance |\n\
    |---|---|---|---|---|---|---|\n";

/// One line about a section of rows.
pub fn rows(text: &mut String, section: &Section, rows: &[Row]) {
    let part =
        |r: &Row| if r.difference() == 0.0 { 0.0 } else { r.difference().abs() / r.tolerance };
    let Some(r) = rows.iter().max_by(|a, b| part(a).total_cmp(&part(b))) else { return };
    let failed = rows.iter().filter(|r| !r.holds()).count();
    let failed = if failed > 0 { format!(", **{failed} fail**") } else { String::new() };
    let _ = writeln!(
        text,
        "| {} | `{}` | {}{failed} | {}: {} | {}, {} | {} | {:.1e} |",
        section.0,
        section.1,
        rows.len(),
        r.case,
        r.quantity,
        number(r.reference),
        r.source,
        number(r.ours),
        r.tolerance,
    );
}

/// One line about a property.
pub fn property(text: &mut String, property: &Property, checked: &Checked) {
    let refused: Vec<String> = REFUSALS
        .iter()
        .zip(&checked.refused)
        .filter(|(_, n)| **n > 0)
        .map(|(why, n)| format!("{n} {why}"))
        .collect();
    let refused = if refused.is_empty() { "none".into() } else { refused.join(", ") };
    let words = if checked.failures.is_empty() {
        "holds".into()
    } else {
        format!("**{}**", checked.failures.join("; ").replace('\n', " "))
    };
    let _ = writeln!(text, "| {} | {} | {refused} | {words} |", property.0, checked.scenes);
}

/// Results of drawn scenes that `cargo compare --keep` stored.
pub fn compared(text: &mut String, kept: Option<Kept>) {
    *text += "\n## Everything together, in extended precision\n\n\
        Scenes drawn with everything that may occur together: any drive, air inside as well \
        (edges outside the stroke, dead volumes down to 1e-6 m3), the return chamber's push on the bit, rigid or elastic bodies of any sections on linear elements or splines, a casing, a drill string \
        of loose joints, reloading, retuning, inputs of order 0 to 4. How far engine and reference may be apart \
        is what the reference itself changes by if every number is off by a few units in the last place.\n\n";
    for (kind, batches) in kept.unwrap_or_default() {
        let mut whole = Tally::default();
        batches.values().for_each(|batch| whole.join(batch.clone()));
        let kind = kind.to_possible_value().expect("none is skipped");
        let _ = writeln!(
            text,
            "`cargo compare --kind {} --keep`: {}.\n",
            kind.get_name(),
            whole.line()
        );
        whole.failures.iter().for_each(|failure| *text += &format!("* {failure}\n"));
    }
}

/// The study of air's error that `cargo compare --asked --keep` stored.
pub fn asked(text: &mut String, kept: Option<String>) {
    *text += "\n### What `air.error` is kept to\n\n\
        Drawn hammers under air, bare and cased, rigid and elastic, for each error asked: how far anything that is \
        shown is off from the reference, over the scale of its kind and over the error asked. Several blows pass an \
        error on from one to the next, so that a number above 1 is no window's error.\n\n";
    *text += &kept.unwrap_or_else(|| "Not made yet: `cargo compare --asked --keep`.\n".into());
}

/// What the engine does not decide, and where the model ends.
pub const LIMITS: &str = include_str!("limits.md");
