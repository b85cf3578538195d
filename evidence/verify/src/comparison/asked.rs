//! The error that air reaches, over the error that was asked for.
//!
//! The engine solves drawn hammers under air for each error asked, and the reference solves them once in extended
//! precision. The error reached is their largest difference at any instant, over the scale of its kind ([`Scales`])
//! and over the error asked; the effect of rounding is subtracted, which the account of the smallest error shows. It
//! is measured a second time over the difference of the reference's perturbed runs, whose air is off by the error
//! asked, where that is larger: a hammer that amplifies a small error is not solved worse for it. A blow amplifies an
//! error, and so does the next one, so instants after the first different event are not compared.

use crate::comparison::compare::{ROUNDING, ROUNDING_PER_ENTRY, engine};
use crate::comparison::known::{Account, FACTOR, Known};
use crate::comparison::observables::{OBSERVABLES, Scales};
use crate::comparison::tally::{Name, batches};
use crate::drawn::scenes::{RandomScene, airy};
use crate::scene;
use hammer::Fidelity;
use oracles::linear::Real;
use proptest::strategy::Strategy;
use std::fmt::Write;

/// Errors asked.
pub const ASKED: [f64; 8] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11];
/// Kinds of numbers, in the order of [`OBSERVABLES`].
const KINDS: [&str; 6] = ["places", "speeds", "forces", "energies", "pressures", "mass of air"];
const GROUPS: [&str; 4] = ["bare, rigid", "bare, elastic", "cased, rigid", "cased, elastic"];
/// Distinguishes these scenes from those drawn for other uses.
const STREAM: u8 = 3;

/// Error reached by one hammer for each kind of number: over the error asked, and over the effect of that in
/// perturbed runs.
type Over = [[f64; 2]; KINDS.len()];
/// The same for each error asked.
type Reached = [Over; ASKED.len()];

/// Errors that drawn hammers reached.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// By group of [`GROUPS`].
    reached: [Vec<(Name, Reached)>; GROUPS.len()],
    /// Number of drawn hammers.
    pub drawn: u32,
}

fn group(case: &RandomScene) -> usize {
    let p = &case.parameters;
    2 * usize::from(p.has_casing()) + usize::from(p.fidelity == Fidelity::Elastic)
}

fn asking(case: &RandomScene, error: f64) -> RandomScene {
    let mut case = case.clone();
    case.parameters.air.error = error;
    case
}

/// The errors of a hammer for one error asked; none if the engine refuses it, or if no instant can be compared.
fn of(account: &Account, asked: f64) -> Option<Over> {
    let Account { case, schedule, known } = account;
    let Known { instants, reference, others, until, .. } = known;
    let own = engine(&asking(case, asked), schedule, instants, (*until, &[])).ok()?;
    let (mut scales, mut reached, mut compared) = (Scales::new(case), Over::default(), 0);
    for (i, &time) in instants.iter().enumerate().take(own.observed.len()) {
        let before = reference.events.partition_point(|e| e.0.to_f64() <= time);
        let alike = |k: usize| own.events.get(k).is_some_and(|e| e.1 == reference.events[k].1);
        if own.events.partition_point(|e| e.0.to_f64() <= time) != before || !(0..before).all(alike)
        {
            break;
        }
        compared += 1;
        scales.grow(&reference.observed[i]);
        let rounding = ROUNDING + ROUNDING_PER_ENTRY * (before + schedule.len()) as f64;
        for (q, (_, kind)) in OBSERVABLES.into_iter().enumerate() {
            let known = reference.observed[i][q];
            let spread = others.iter().map(|o| (o.observed[i][q] - known).abs());
            let spread = spread.fold(0.0, f64::max);
            let rounded = FACTOR * spread + rounding * scales.of(kind);
            let error = ((own.observed[i][q] - known).abs() - rounded).max(0.0);
            let unit = asked * scales.of(kind);
            let perturbed = unit.max(spread * asked / case.parameters.air.error);
            let over = reached[kind].iter_mut().zip([unit, perturbed]);
            over.for_each(|(most, unit)| *most = most.max(error / unit));
        }
    }
    (compared > 0).then_some(reached)
}

impl Study {
    /// Studies so many drawn hammers, without drill strings, for which the reference would take minutes. Reports
    /// after each.
    pub fn of(hammers: u32, from: u32, mut tell: impl FnMut(&Self)) {
        let short = airy().prop_filter("string", |drawn| !scene::is_loose(&drawn.parameters));
        let mut study = Self::default();
        for (batch, list) in batches(&short, STREAM, from, hammers) {
            for (place, case) in list.into_iter().enumerate() {
                study.drawn += 1;
                let least = ASKED[ASKED.len() - 1];
                if let Ok(account) = Account::of(&asking(&case, least)) {
                    let reached: Vec<_> =
                        ASKED.iter().filter_map(|asked| of(&account, *asked)).collect();
                    if let Ok(reached) = Reached::try_from(reached) {
                        study.reached[group(&case)].push((Name { batch, place }, reached));
                    }
                }
                tell(&study);
            }
        }
    }

    /// Tables of median and worst, by kind of number and by kind of hammer.
    pub fn table(&self) -> String {
        let all: Vec<&(Name, Reached)> = self.reached.iter().flatten().collect();
        let mut text = format!(
            "{} hammers drawn, {} compared; median and worst of the error reached over the error asked, and in brackets \
             the worst over what the reference differs by whose air is off by the error asked, where that is more.\n\n\
             | asked | {} |\n|---|{}\n",
            self.drawn,
            all.len(),
            KINDS.join(" | "),
            "---|".repeat(KINDS.len())
        );
        for (k, asked) in ASKED.iter().enumerate() {
            let cells = (0..KINDS.len()).map(|kind| cell(all.iter().map(|(_, r)| r[k][kind])));
            let _ = writeln!(text, "| {asked:e} | {} |", cells.collect::<Vec<_>>().join(" | "));
        }
        let heads = GROUPS.iter().zip(&self.reached);
        let heads: Vec<_> = heads.map(|(name, list)| format!("{name} ({})", list.len())).collect();
        let _ =
            write!(text, "\nOf all kinds together:\n\n| asked | {} |\n|---|", heads.join(" | "));
        let _ = writeln!(text, "{}", "---|".repeat(GROUPS.len()));
        for (k, asked) in ASKED.iter().enumerate() {
            let cells =
                self.reached.iter().map(|list| cell(list.iter().map(|(_, r)| most(&r[k..=k]))));
            let _ = writeln!(text, "| {asked:e} | {} |", cells.collect::<Vec<_>>().join(" | "));
        }
        let worst = |which: usize| {
            let names = all.iter().map(|(name, r)| (most(r)[which], name));
            names
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .map_or_else(String::new, |(_, name)| name.to_string())
        };
        let _ = writeln!(text, "\nThe worst is hammer {}, in brackets {}.", worst(0), worst(1));
        text
    }
}

/// The largest over all kinds of numbers and errors asked.
fn most(reached: &[Over]) -> [f64; 2] {
    let all = reached.as_flattened().iter();
    all.fold([0.0; 2], |most, over| [0, 1].map(|k| f64::max(most[k], over[k])))
}

/// Median and worst.
fn cell(numbers: impl Iterator<Item = [f64; 2]>) -> String {
    let (mut list, excused): (Vec<f64>, Vec<f64>) = numbers.map(|[a, b]| (a, b)).unzip();
    list.sort_by(f64::total_cmp);
    let Some(worst) = list.last() else { return String::from("-") };
    let excused = excused.into_iter().fold(0.0, f64::max);
    format!("{:.2}, {worst:.2} ({excused:.2})", list[list.len() / 2])
}
