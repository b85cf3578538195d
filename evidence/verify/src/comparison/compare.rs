//! The engine against the extended-precision reference on any scene and script.
//!
//! The allowed difference is not chosen but measured. The reference solves the scene again with every number changed
//! by a few units in the last place ([`oracles::perturb`]), with every state after a transition and every guard
//! changed by as much of its own terms ([`oracles::guard_perturbation`]), and with guards of four times and a quarter
//! of the resolution that these terms permit; and once more unchanged, with guards that count what the engine's
//! guards certainly count. What these runs disagree about, no arithmetic of double precision can know; where they
//! have different events the comparison ends. Up to there the engine must have the same events, and each number may
//! differ by [`FACTOR`] times the difference of the perturbed runs, plus rounding of the largest number of its kind
//! so far.
//!
//! The engine integrates air to a stated error, so in the perturbed runs every number of air is changed by that error
//! too. A force at one instant may differ by ten times the error, since a window may leave out a part with zero mean;
//! other numbers by three times, and a position by once the error. The study of `--asked` shows what drawn hammers
//! need in addition to perturbed runs.

use crate::comparison::bodies;
use crate::comparison::known::{Account, FACTOR, Known, Trajectory};
use crate::comparison::observables::{OBSERVABLES, Scales, of_engine};
use crate::drawn::actions::{self, Action};
use crate::drawn::scenes::RandomScene;
use crate::scene;
use hammer::{Error, Machine};
use oracles::dd::Dd;
use oracles::law::{Event, Mode};
use oracles::linear::Real;
use serde::{Deserialize, Serialize};

/// Allowed rounding of each number, over the scale of its kind ([`Scales`]).
pub const ROUNDING: f64 = 256.0 * f64::EPSILON;
/// Allowed rounding for each previous event and action: the state goes through two products with a basis, each a sum
/// of a few rounded terms.
pub const ROUNDING_PER_ENTRY: f64 = 16.0 * f64::EPSILON;

/// The largest difference of one kind.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Worst {
    /// Name of the number.
    pub what: String,
    /// Its time, s.
    pub time: f64,
    /// The difference.
    pub error: f64,
    /// What was allowed.
    pub allowed: f64,
}

impl Worst {
    /// The difference over the allowed one.
    pub fn ratio(&self) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error / self.allowed }
    }

    pub(crate) fn note(&mut self, other: Self) {
        if other.ratio().is_nan() || other.ratio() > self.ratio() {
            *self = other;
        }
    }
}

/// Result of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Events compared.
    pub events: usize,
    /// Instants compared.
    pub instants: usize,
    /// The largest difference of a number.
    pub observed: Worst,
    /// The largest difference of an event's time.
    pub timing: Worst,
    /// The first event that differs from the reference's.
    pub unlike: Option<String>,
    /// Its time, s.
    pub parted: f64,
    /// From when on a guard rests at its level within rounding, neither beyond its resolution nor back, until an
    /// input changes or the run ends, s.
    pub rests: f64,
    /// The excess over the allowed difference, relative to the possible effect of the bases by their largest
    /// [mismatch](bodies::mismatch): each change of basis has an error of that share of all that moves.
    pub rough: f64,
    /// The largest excess, relative to the resolution of the engine's guards ([`Scales::resolved`]), once for each
    /// event and once more.
    pub unresolved: f64,
}

impl Differences {
    /// True if every allowance is a number.
    fn is_judged(&self) -> bool {
        !self.observed.ratio().is_nan() && !self.timing.ratio().is_nan()
    }

    /// The largest difference over the allowed one.
    pub fn ratio(&self) -> f64 {
        self.observed.ratio().max(self.timing.ratio())
    }

    /// True if all differences are allowed.
    pub fn none(&self) -> bool {
        self.unlike.is_none() && self.observed.ratio() <= 1.0 && self.timing.ratio() <= 1.0
    }

    /// True if the first different event follows a guard that rests within rounding of its level, or leaves it:
    /// whether it has crossed is undetermined.
    pub fn from_guard_at_rest(&self) -> bool {
        self.unlike.is_some() && self.rests <= self.parted
    }

    /// True if the excess is explained by the engine's own measure of its bases.
    pub fn from_rough_bases(&self) -> bool {
        self.is_judged() && self.unlike.is_none() && self.rough <= 1.0
    }

    /// True if the excess is less than the engine's guards resolve. Where a guard grazes, an event may differ by as
    /// much, and events are not claimed to be known more closely: 2e-13 of the bodies' travel
    /// ([`Parameters::resolutions`](hammer::Parameters::resolutions)); outputs are read to nine digits. It cannot
    /// grow unnoticed, since all later instants are compared too.
    pub fn is_invisible(&self) -> bool {
        self.is_judged() && self.unlike.is_none() && self.unresolved <= 1.0
    }
}

/// Compares the engine with the reference.
///
/// # Errors
/// The engine's, if it refuses the scene before the scene is undecided.
pub fn compare(account: &Account) -> Result<Differences, Error> {
    let Account { case, schedule, known } = account;
    let Known { instants, reference, others, until, rests, .. } = known;
    let passed: Vec<f64> = reference.events.iter().map(|e| e.0.to_f64()).collect();
    let engine = engine(case, schedule, instants, (*until, &passed))?;
    let accounts = (&engine, reference, &**others);
    let found = judge(accounts, schedule, instants, Scales::new(case));
    let at_rest = known.vague.contains(&found.events);
    Ok(Differences { rests: if at_rest { found.parted } else { *rests }, ..found })
}

/// The events of the engine, the reference and its perturbed runs side by side, one on a line, with the actions
/// before them.
pub fn beside(account: &Account) -> String {
    let Account { case, schedule, known } = account;
    let Known { reference, others, instants, .. } = known;
    let engine = engine(case, schedule, instants, (f64::INFINITY, &[]));
    let engine = engine.map(|trajectory| trajectory.events).unwrap_or_default();
    let mut lines: Vec<String> =
        schedule.iter().map(|(time, action)| format!("at {time:.16e} {action:?}")).collect();
    let lists: Vec<_> = [&engine, &reference.events]
        .into_iter()
        .chain(others.iter().map(|other| &other.events))
        .collect();
    for i in 0..lists.iter().map(|list| list.len()).max().unwrap_or(0) {
        let cells = lists.iter().map(|list| {
            list.get(i).map_or(String::from("-"), |(time, event, mode)| {
                format!("{:.16e} {event:?} to {:?}", time.to_f64(), mode.rock)
            })
        });
        lines.push(format!("{i}: {}", cells.collect::<Vec<_>>().join(" | ")));
    }
    lines.join("\n")
}

pub(crate) fn engine(
    case: &RandomScene,
    schedule: &[(f64, Action)],
    instants: &[f64],
    (until, passed): (f64, &[f64]),
) -> Result<Trajectory, Error> {
    let p = &case.parameters;
    let mut machine = Machine::new(p, &case.inputs, 0.0)?;
    machine.keep_journal(true);
    let (mut observed, mut mismatch) = (Vec::new(), 0.0f64);
    for &instant in instants.iter().filter(|&&instant| instant < until) {
        let from = machine.time();
        let on_the_way = passed.iter().filter(|&&time| from < time && time < instant);
        for &time in on_the_way.chain([&instant]) {
            actions::follow(&mut machine, p, schedule, time)?;
            mismatch = mismatch.max(bodies::mismatch(&machine));
        }
        observed.push(of_engine(&machine));
    }
    let event = |r: &hammer::Record| {
        (
            Dd { hi: r.time, lo: r.time_rest },
            scene::event(r, p.has_casing()),
            scene::mode(p, r.mode),
        )
    };
    let events = machine.take_journal().iter().map(event).collect();
    Ok(Trajectory { events, rates: Vec::new(), observed, mismatch })
}

fn judge(
    (engine, reference, others): (&Trajectory, &Trajectory, &[Trajectory]),
    schedule: &[(f64, Action)],
    instants: &[f64],
    mut scales: Scales,
) -> Differences {
    let count = engine.observed.len().min(reference.observed.len());
    let last = count.checked_sub(1).map_or(-1.0, |i| instants[i]);
    let mut found = Differences { instants: count, ..Default::default() };
    for (i, &time) in instants.iter().enumerate().take(count) {
        scales.grow(&reference.observed[i]);
        let acted = schedule.partition_point(|(at, _)| *at <= time);
        let before = acted + reference.events.partition_point(|e| e.0.to_f64() <= time);
        let rounding = ROUNDING + ROUNDING_PER_ENTRY * before as f64;
        for (q, (what, kind)) in OBSERVABLES.into_iter().enumerate() {
            let known = reference.observed[i][q];
            let apart = |other: &Trajectory| (other.observed[i][q] - known).abs();
            let spread = others.iter().map(apart).fold(0.0, f64::max);
            let error = (engine.observed[i][q] - known).abs();
            let mut allowed = FACTOR * spread + rounding * scales.of(kind);
            allowed += scales.of_air(kind);
            if error > allowed {
                let basis = engine.mismatch * (1 + before) as f64 * scales.of(kind);
                found.rough = found.rough.max((error - allowed) / basis);
                let resolved = (1 + before) as f64 * scales.resolved(kind);
                found.unresolved = found.unresolved.max(error / resolved);
            }
            found.observed.note(Worst { what: what.into(), time, error, allowed });
        }
    }
    times((engine, reference, others), last, &scales, &mut found);
    found
}

/// True if the next two events are simultaneous and in the opposite order.
fn tied(own: &[(Dd, Event, Mode)], known: &[(Dd, Event, Mode)]) -> bool {
    let ([a, b, ..], [x, y, ..]) = (own, known) else { return false };
    let apart = |p: Dd, q: Dd| (p - q).to_f64().abs();
    let reach = hammer::TIME_RESOLUTION + f64::EPSILON * x.0.to_f64();
    let together = apart(a.0, b.0).max(apart(x.0, y.0)).max(apart(a.0, x.0)) <= reach;
    together && a.1 == y.1 && b.1 == x.1 && b.2 == y.2
}

/// Compares the times of events before the last compared instant.
fn times(
    (engine, reference, others): (&Trajectory, &Trajectory, &[Trajectory]),
    last: f64,
    scales: &Scales,
    found: &mut Differences,
) {
    let wanted = reference.events.iter().filter(|e| e.0.to_f64() <= last);
    let mut skipped = 0;
    for (i, known) in wanted.enumerate() {
        if tied(&engine.events[i.min(engine.events.len())..], &reference.events[i..]) {
            skipped = 2;
        }
        if skipped > 0 {
            (skipped, found.events) = (skipped - 1, found.events + 1);
            continue;
        }
        let spread = others.iter().map(|o| (o.events[i].0 - known.0).to_f64().abs());
        let spread = spread.fold(0.0, f64::max);
        let Some(own) = engine.events.get(i).filter(|own| own.1 == known.1 && own.2 == known.2)
        else {
            let own = engine.events.get(i);
            if own.is_none() && known.0.to_f64() + FACTOR * spread > last {
                return; // It may come later than all that is compared.
            }
            let first = own.map_or(f64::INFINITY, |own| own.0.to_f64());
            found.parted = first.min(known.0.to_f64());
            found.unlike = Some(format!("event {i} is {own:?} instead of {known:?}"));
            return;
        };
        let kind = Scales::kind_of_guard(known.1);
        let rate = reference.rates[i].abs();
        // A guard that does not move when its event comes, as a barrier of 0 at rest, was passed with the event before.
        let over_rate = |size: f64| if rate > 0.0 { size / rate } else { 0.0 };
        let off = over_rate(scales.of(kind));
        let (time, error) = (known.0.to_f64(), (own.0 - known.0).to_f64().abs());
        let least = hammer::TIME_RESOLUTION + f64::EPSILON * time;
        let allowed = FACTOR * spread + least + ROUNDING * off + over_rate(scales.of_air(kind));
        if error > allowed {
            let basis = engine.mismatch * (1 + i) as f64 * off;
            found.rough = found.rough.max((error - allowed) / basis);
            let resolved = (1 + i) as f64 * over_rate(scales.resolved(kind));
            found.unresolved = found.unresolved.max(error / resolved);
        }
        found.timing.note(Worst { what: format!("{:?}", known.1), time, error, allowed });
        found.events += 1;
    }
    if engine.events.len() > found.events {
        let own = &engine.events[found.events];
        if own.0.to_f64() < last {
            found.parted = own.0.to_f64();
            found.unlike = Some(format!("event {} is {own:?}, too many", found.events));
        }
    }
}
