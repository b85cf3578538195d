//! What the extended-precision reference determines of a scene and its script, independently of the engine.

use crate::comparison::observables::{Observed, Scales, of_reference};
use crate::drawn::actions::{self, Action};
use crate::drawn::scenes::RandomScene;
use crate::scene;
use hammer::Error;
use oracles::dd::Dd;
use oracles::guard_perturbation::GuardPerturbation;
use oracles::law::{Event, Mode};
use oracles::linear::Real;
use oracles::perturb::{Near, perturbed};
use oracles::record::GivenUp;
use oracles::run::Run;
use oracles::scene::{Action as Given, Scene, Schedule};
use oracles::taylor::Accuracy;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Accuracy of the reference's series: their last term is a millionth of a double's last digit.
pub(crate) const ACCURACY: Accuracy = Accuracy { order: 36, tolerance: 1e-24 };
/// Largest number of series of a run, in which it passes some thousand radians of the fastest motion.
pub(crate) const PATIENCE: usize = 700;
/// Perturbed runs. Their numbers are changed in drawn directions. The chance that four runs all show less than a
/// tenth of a normally distributed change is 4e-5 (two runs: 6e-3), and many numbers of many scenes are compared.
const SEEDS: [u64; 4] = [1, 2, 3, 4];
/// Resolution of the perturbed runs' guards, over the least possible.
const COARSER: [f64; 4] = [4.0, 0.25, 4.0, 0.25];
/// Share of the engine's resolution from which a crossing may count; between this and the resolution it may or may
/// not (`hammer/src/search/tracker.rs`, statements 1 and 2).
const COUNTED: f64 = 3.0 / 8.0;
/// Instants compared.
pub(crate) const INSTANTS: usize = 12;
/// Allowed multiple of the effect of a change of four units in the last place: in a transition a state goes through
/// some tens of products, each rounded.
pub const FACTOR: f64 = 32.0;
/// Solution of a scene by an engine or a reference.
#[derive(Serialize, Deserialize)]
pub(crate) struct Trajectory {
    pub events: Vec<(Dd, Event, Mode)>,
    /// Rates of the guards at these events, from a reference.
    pub rates: Vec<f64>,
    pub observed: Vec<Observed>,
    /// Largest [mismatch](crate::comparison::bodies::mismatch) of a basis, from an engine.
    pub mismatch: f64,
}

/// What the reference and its perturbed runs determine of a scene.
#[derive(Serialize, Deserialize)]
pub(crate) struct Known {
    pub instants: Vec<f64>,
    /// Times at which inputs are set, s.
    set: Vec<f64>,
    /// Events of the reference about which the runs disagree after an input was set: the guard was at rest at its
    /// level then, and the order of such events is undetermined.
    pub vague: BTreeSet<usize>,
    pub reference: Trajectory,
    pub others: Vec<Trajectory>,
    /// Until when the runs go and agree, and from when on a guard is undecided, s.
    pub until: f64,
    pub rests: f64,
}

impl Known {
    /// Adds another run: its solution, when it was given up, and from when on it was undecided.
    fn add(&mut self, (other, given_up, pending): (Trajectory, f64, f64)) {
        self.rests = self.rests.min(pending);
        let own = &self.reference.events;
        let same = alike(own, &other.events);
        let next =
            [own, &other.events].map(|list| list.get(same).map_or(f64::INFINITY, |e| e.0.to_f64()));
        let parted = next[0].min(next[1]);
        self.vague.extend((0..same).filter(|&i| {
            let events = [own[i].0, other.events[i].0];
            let last = |set: &&f64| events.iter().all(|event| Dd::from(**set) <= *event);
            let set = self.set.iter().rfind(last).map_or(Dd::default(), |set| Dd::from(*set));
            is_another(events, [set; 2])
        }));
        self.until = self.until.min(given_up).min(parted);
        self.others.push(other);
    }
}

/// A drawn scene, shortened to the reference's patience, and its translation.
fn exact_scene(case: &RandomScene, patience: usize) -> (RandomScene, Scene) {
    let scene = scene::finite_elements(&case.parameters, &case.inputs);
    // One unit of time for each series, which is conservative, since events take more series.
    let span = patience as f64 * Run::<f64>::new(&scene, ACCURACY).unit_time();
    (case.within(span), scene)
}

/// Solutions of the reference and of its perturbed runs. `near` are events at which the scene is retuned.
fn known(
    scene: &Scene,
    schedule: &Schedule,
    (instants, patience): (&[f64], usize),
    near: &[Near],
) -> Known {
    let solve = |run, schedule: &Schedule| solve(run, schedule, instants, patience);
    let (reference, given_up, pending) = solve(Run::new(scene, ACCURACY), schedule);
    let set = schedule.iter().filter(|(_, action)| matches!(action, Given::Set(..)));
    let mut known = Known {
        instants: instants.to_vec(),
        set: set.map(|(time, _)| *time).collect(),
        vague: BTreeSet::new(),
        others: Vec::new(),
        until: given_up.min(pending),
        rests: f64::INFINITY,
        reference,
    };
    let mut finer = Run::new(scene, ACCURACY);
    finer.finer = COUNTED;
    known.add(solve(finer, schedule));
    for (seed, coarser) in SEEDS.into_iter().zip(COARSER) {
        let at = known.reference.events.iter().map(|e| Near { at: e.0.to_f64(), known: 0.0 });
        let near: Vec<Near> = at.chain(near.iter().copied()).collect();
        let (scene, schedule) = perturbed(scene, schedule, seed, &near);
        let settles = seed % 2 == 0;
        let run = Run::<Dd>::new(&scene, ACCURACY).perturbed_guards(GuardPerturbation {
            seed,
            coarser,
            settles,
        });
        known.add(solve(run, &schedule));
    }
    known
}

/// What is determined of a scene and its script.
fn known_of(
    case: &RandomScene,
    scene: &Scene,
    schedule: &[(f64, Action)],
    patience: usize,
) -> Result<Known, Error> {
    let instants: Vec<f64> =
        (1..=INSTANTS).map(|i| case.end() * i as f64 / INSTANTS as f64).collect();
    let solve = |schedule: &[(f64, Action)], near: &[Near]| {
        let translated = actions::translated_actions(&case.parameters, schedule);
        known(scene, &translated, (&instants, patience), near)
    };
    if case.actions.at_event.is_none() {
        return Ok(solve(schedule, &[]));
    }
    // The uncertainty of the event at which the scene is retuned is found without retuning.
    let mut before = case.clone();
    before.actions.at_event = None;
    let Known { reference, others, .. } = solve(&before.schedule()?, &[]);
    let scales = Scales::new(case);
    let near = reference.events.iter().enumerate().map(|(i, event)| {
        let spread = others.iter().filter_map(|other| other.events.get(i));
        let spread = spread.filter(|own| own.1 == event.1).map(|own| (own.0 - event.0).to_f64());
        // The engine's event may be earlier or later by what its air is allowed.
        let air = scales.of_air(Scales::kind_of_guard(event.1)) / reference.rates[i].abs();
        let known = spread.map(f64::abs).fold(air / FACTOR, f64::max);
        Near { at: event.0.to_f64(), known }
    });
    Ok(solve(schedule, &near.collect::<Vec<_>>()))
}

/// A scene with what is determined of it.
#[derive(Serialize, Deserialize)]
pub struct Account {
    /// The scene, no longer than the reference follows it.
    pub case: RandomScene,
    pub(crate) schedule: Vec<(f64, Action)>,
    pub(crate) known: Known,
}

impl Account {
    /// The account of a drawn scene.
    ///
    /// # Errors
    /// The engine's, if it refuses the scene before it could be retuned at an event.
    pub fn of(case: &RandomScene) -> Result<Self, Error> {
        // Waves take a long time down a drill string and back.
        let times = if scene::is_loose(&case.parameters) { 4 } else { 1 };
        Self::over(case, times * PATIENCE)
    }

    /// The same with so many series of the reference.
    ///
    /// # Errors
    /// See [`Account::of`].
    pub fn over(case: &RandomScene, patience: usize) -> Result<Self, Error> {
        let (case, scene) = exact_scene(case, patience);
        let schedule = case.schedule()?;
        let known = known_of(&case, &scene, &schedule, patience)?;
        Ok(Self { case, schedule, known })
    }
}

/// Length of the common start of two sequences of events. An event is another one if the time since the previous
/// event differs by a share of 1 / [`FACTOR`], since the allowance would exceed that time.
fn alike(a: &[(Dd, Event, Mode)], b: &[(Dd, Event, Mode)]) -> usize {
    let before = |list: &[(Dd, Event, Mode)], i: usize| {
        i.checked_sub(1).map_or(Dd::default(), |before| list[before].0)
    };
    let alike = |&i: &usize| {
        let since = [before(a, i), before(b, i)];
        a[i].1 == b[i].1 && a[i].2 == b[i].2 && !is_another([a[i].0, b[i].0], since)
    };
    (0..a.len().min(b.len())).take_while(alike).count()
}

/// True if two events come at times since these so different that they are not the same event.
fn is_another(events: [Dd; 2], since: [Dd; 2]) -> bool {
    let [x, y] = [0, 1].map(|run| (events[run] - since[run]).to_f64());
    let together = hammer::TIME_RESOLUTION + f64::EPSILON * events[0].to_f64();
    FACTOR * ((x - y).abs() - together) > x.max(y)
}

/// The reference's solution, until when it goes, and from when on a guard is undecided.
fn solve(
    mut run: Run<Dd>,
    schedule: &Schedule,
    instants: &[f64],
    patience: usize,
) -> (Trajectory, f64, f64) {
    run.patience = patience;
    let given_up = match run.through(instants, schedule) {
        Ok(()) => f64::INFINITY,
        Err(GivenUp::Zeno(time) | GivenUp::Long(time)) => time,
    };
    let events = run.events.iter().map(|e| (e.time, e.event, e.mode)).collect();
    let rates = run.events.iter().map(|e| e.rate.to_f64()).collect();
    let observed = run.samples.iter().map(|sample| of_reference(&run, sample)).collect();
    (Trajectory { events, rates, observed, mismatch: 0.0 }, given_up, run.near_miss())
}
