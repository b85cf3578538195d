//! The report: the same rows that the tests assert, as Markdown.

use crate::hard::Case;
use crate::long::{Mark, Run};
use crate::row::Row;
use crate::study::{self, KAPPAS, MESHES, Point, RATIOS, Refined};
use crate::{assembly, closed, cycle};
use hammer::Error;
use std::fmt::Write;

/// A section of rows: its title, the test that asserts it, and its rows.
pub type Section = (&'static str, &'static str, fn() -> Result<Vec<Row>, Error>);

/// Closed forms, benchmarks, cycles.
pub const SECTIONS: [Section; 11] = [
    ("Two equal-section bars", "closed_forms two_bars", closed::two_bars),
    ("A free bar on a spring", "closed_forms a_bar_on_a_spring", closed::springs),
    ("One rectangular pulse on bilinear rock", "closed_forms one_rectangular", closed::pulses),
    ("One blow on virgin rock", "closed_forms one_blow", closed::blows),
    ("Relay against a fixed bit, viscous piston", "cycles viscous_piston", cycle::relay_viscous),
    ("Relay against a fixed bit, e near 0", "cycles stops_dead", cycle::relay_dead),
    ("Mean forces over a cycle", "cycles mean_forces", cycle::mean_forces),
    ("SDNL111", "benchmarks sdnl111", assembly::clamped_bar),
    ("SDND101", "benchmarks sdnd101", assembly::mass_and_stop),
    ("The published stationary response", "cycles published_cycle", cycle::stationary),
    ("A whole cycle against exact waves", "cycles exact_waves", cycle::first_cycle),
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

/// A section of rows.
pub fn rows(text: &mut String, section: &Section, rows: &[Row]) {
    let _ = writeln!(text, "\n### {}\n\n`cargo test -p verify --test {}`\n", section.0, section.1);
    *text += "| case | quantity | reference | source | ours | difference | tolerance | holds |\n";
    *text += "|---|---|---|---|---|---|---|---|\n";
    for r in rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.2e} | {:.2e} | {} |",
            r.case,
            r.quantity,
            number(r.reference),
            r.source,
            number(r.ours),
            r.difference(),
            r.tolerance,
            if r.holds() { "yes" } else { "**no**" }
        );
    }
    let mut reasons: Vec<&str> = rows.iter().map(|r| r.why).collect();
    reasons.sort_unstable();
    reasons.dedup();
    let _ = writeln!(text, "\nTolerances: {}.", reasons.join("; "));
}

/// One hard case.
pub fn hard(text: &mut String, case: &Case) -> bool {
    let command = format!("`{}`", case.name);
    match case.run() {
        Ok(o) => {
            let [residual, bound, _] = o.energy;
            let c = o.counters;
            let _ = writeln!(
                text,
                "| {command} | {} | {} | {} | {residual:.1e} | {bound:.1e} | {} | {} | {} |",
                case.setting, o.words, c.events, c.samples, c.windows, c.undecided
            );
            true
        }
        Err(fault) => {
            let _ = writeln!(text, "| {command} | {} | **{fault}** | | | | | | |", case.setting);
            false
        }
    }
}

/// The mesh study.
pub fn convergence(text: &mut String, meshes: &[Refined]) {
    *text += "\n## Convergence with the mesh\n\n`cargo verify`\n\n\
        One blow of equal bars (`kappa` 0.3, `gamma` 5, `beta` 0, `KC` twice `E A / h`) and a \
        bar on a spring (`k` 1) against exact waves; errors in units of the closed forms, and \
        the order observed from the mesh before.\n\n";
    let _ = writeln!(
        text,
        "| elements | {} | events |",
        study::QUANTITIES.join(" | order | ") + " | order"
    );
    *text += "|---|---|---|---|---|---|---|---|---|---|\n";
    for (i, m) in meshes.iter().enumerate() {
        let cells: Vec<String> = (0..4)
            .map(|q| {
                let order = i
                    .checked_sub(1)
                    .map_or("".into(), |c| format!("{:.1}", study::order(&meshes[c], m, q)));
                format!("{:.2e} | {order}", m.errors[q])
            })
            .collect();
        let _ = writeln!(text, "| {} | {} | {} |", m.elements, cells.join(" | "), m.events);
    }
    *text += "\n![Errors over elements](verification/convergence.png)\n\n\
        The smooth problem (a bar on a spring) converges fast, though not evenly: the error \
        changes sign. A blow does not converge at a clean order: every front opens and closes small \
        drilling cycles on its way, their number grows with the mesh, and the penalty \
        delays the contact by `Z / (2 KC)`, which is first order in `h`.\n\n\
        Stationary cycle of the reference hammer (thirty blows):\n\n\
        | elements | period, ms | ROP, mm/s |\n|---|---|---|\n";
    for m in meshes {
        let [period, rop] = m.stationary;
        let _ = writeln!(text, "| {} | {period:.4} | {rop:.4} |", m.elements);
    }
    let (last, before) = (meshes[meshes.len() - 1], meshes[meshes.len() - 2]);
    let _ = writeln!(
        text,
        "\nFrom {} to {} elements the period changes by {:.4} ms and the ROP by {:.3} mm/s.",
        before.elements,
        last.elements,
        last.stationary[0] - before.stationary[0],
        last.stationary[1] - before.stationary[1]
    );
    debug_assert_eq!(meshes.len(), MESHES.len());
}

/// The map of rigid bodies.
pub fn map(text: &mut String, points: &[Point]) {
    *text += "\n## Rigid or elastic\n\n`cargo verify`\n\n\
        One bare blow, rigid against elastic bodies: relative error in percent of the energy \
        that the rock keeps / of its largest force.\n\n";
    let head: Vec<String> = KAPPAS.iter().map(|k| format!("kappa {k}")).collect();
    let _ =
        writeln!(text, "| Lp/Lb | {} |\n|---|{}", head.join(" | "), "---|".repeat(KAPPAS.len()));
    for (ratio, line) in RATIOS.iter().zip(points.chunks(KAPPAS.len())) {
        let cells: Vec<String> = line
            .iter()
            .map(|p| format!("{:+.1} / {:+.1}", 100.0 * p.energy, 100.0 * p.force))
            .collect();
        let _ = writeln!(text, "| {ratio} | {} |", cells.join(" | "));
    }
    let worst = points.iter().map(|p| p.energy.abs()).fold(0.0, f64::max);
    let near: Vec<String> = points
        .iter()
        .filter(|p| p.energy.abs() < 0.1 && p.force.abs() < 0.1)
        .map(|p| format!("({}, {})", p.ratio, p.kappa))
        .collect();
    let _ = writeln!(
        text,
        "\n![Error of rigid bodies](verification/rigid.png)\n\n\
         Both errors are below 10 % only at (Lp/Lb, kappa) = {}; the worst energy is off by \
         {:.0} %. Rigid bodies are enough for equal bars on soft rock. Bodies of unequal length do \
         not part as rigid ones do: waves leave energy in the longer bar and restitution \
         falls to the ratio of lengths, however soft the rock. There, and on stiff rock, \
         choose elastic bodies.",
        if near.is_empty() { "no point of the map".into() } else { near.join(", ") },
        100.0 * worst
    );
}

/// The long run, as last made.
pub fn long(text: &mut String, run: Option<&Run>) {
    *text += "\n## Long run\n\n`cargo verify --long --minutes 5`\n\n";
    let Some(r) = run else {
        *text += "Not made yet.\n";
        return;
    };
    let _ = writeln!(
        text,
        "{} blows of the reference hammer in {:.0} s of the {} minutes given \
         ({:.0} blows a second, one thread, on a machine shared with other work).\n",
        r.end.blows,
        r.seconds,
        r.minutes,
        r.end.blows as f64 / r.seconds
    );
    *text += "| | at the start | at the end |\n|---|---|---|\n";
    type Line = (&'static str, fn(&Mark) -> String);
    let lines: [Line; 7] = [
        ("blows", |m| m.blows.to_string()),
        ("simulated time, s", |m| format!("{:.1}", m.time)),
        ("period, ms", |m| format!("{:.12}", m.period)),
        ("ROP, mm/s", |m| format!("{:.12}", m.rop)),
        ("hole depth, m", |m| format!("{:.6}", m.depth)),
        ("energy residual / work done", |m| format!("{:.2e}", m.residual / m.work)),
        ("resident memory, kB", |m| m.memory.to_string()),
    ];
    for (name, value) in lines {
        let _ = writeln!(text, "| {name} | {} | {} |", value(&r.start), value(&r.end));
    }
}

/// What the engine does not decide, and where the model ends.
pub const LIMITS: &str = include_str!("limits.md");
