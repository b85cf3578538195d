//! The engine's derivatives and their stated errors, against central differences in extended precision.
//!
//! Over a step of `2^-36` of a parameter the difference of two runs of the reference, in double-double arithmetic,
//! has some twenty digits, and truncation (the square of the step times the radians of the fastest motion) is below
//! rounding. The difference is therefore the derivative to all digits of a double, if both sides have the same
//! events.
//!
//! The allowed difference is not chosen but measured: the same difference about a scene whose every number is changed
//! by a few units in the last place shows what double precision can know.
//!
//! How often the stated error holds the true one is counted separately ([`Held`]) for bare hammers, those in a
//! casing, those that are retuned or whose inputs change on the way, and under air.

use crate::comparison::bodies;
use crate::comparison::compare::ROUNDING;
use crate::comparison::known::{ACCURACY, FACTOR, PATIENCE};
use crate::comparison::observables::{MOTIONS, OBSERVABLES, Scales, exactly, motions};
use crate::comparison::tally::batches;
use crate::drawn::actions::{self, Action};
use crate::drawn::scenes::{RandomScene, mixed};
use crate::scene;
use hammer::Scene as Start;
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::{Fidelity, Parameters, Source};
use oracles::dd::Dd;
use oracles::linear::Real;
use oracles::perturb::perturbed;
use oracles::run::Run;
use oracles::scene::{Scene, Schedule};
use proptest::strategy::Strategy;
use std::fmt::Write;

/// Step of a difference, over the parameter.
const STEP: f64 = 1.0 / (1u64 << 36) as f64;
/// Rounding of the difference itself, over the scale of its kind: `2^-100`, sixteen units in the last place of
/// double-double arithmetic, over the step. (A bit at rest has no speed, and there a derivative of 1e-20.)
const SHARP: f64 = 1.0 / (1u128 << 64) as f64;
/// Parameters examined in a scene; the next scene has others.
const EACH: usize = 4;

/// How often the stated errors hold.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// Derivatives compared.
    pub compared: usize,
    /// Derivatives whose true error is at most the stated one.
    pub within: usize,
    /// Other derivatives whose error is below the rounding of the differentiated number, over the engine's step.
    pub rounded: usize,
}

/// The groups that are counted separately.
pub const GROUPS: [&str; 4] = [
    "bare hammer, left alone",
    "in a casing, left alone",
    "retuned, or inputs change",
    "driven by air",
];

/// Results of many scenes.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Scenes drawn.
    pub scenes: u32,
    /// Derivatives compared.
    pub compared: usize,
    /// Derivatives by a section of a body.
    pub sections: usize,
    /// Pairs of a scene and an argument whose two sides have different events.
    pub parted: usize,
    /// Pairs that the engine reports as non-smooth.
    pub nonsmooth: usize,
    /// Derivatives that are right to a millionth of themselves or of the number's size.
    pub fine: usize,
    /// Derivatives whose difference is explained by the engine's own measure of its bases.
    pub rough: usize,
    /// How often the stated errors hold, by [`GROUPS`].
    pub held: [Held; GROUPS.len()],
    /// The largest difference over the allowed one, among those that are allowed.
    pub worst: f64,
    /// The disagreements.
    pub failures: Vec<String>,
}

impl Tally {
    /// A summary in one line.
    pub fn line(&self) -> String {
        let mut names: Vec<_> =
            self.failures.iter().filter_map(|text| text.split(':').next()).collect();
        names.dedup();
        let names =
            if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
        format!(
            "{} scenes, {} derivatives ({} by sections), {} to a millionth, {} pairs of other \
             events, {} non-smooth: {} disagree{names}, {} by rough bases; of the others {:.3} of what is allowed at most",
            self.scenes,
            self.compared,
            self.sections,
            self.fine,
            self.parted,
            self.nonsmooth,
            self.failures.len(),
            self.rough,
            self.worst
        )
    }

    /// A table of how often the stated errors hold.
    pub fn table(&self) -> String {
        let mut text = String::from(
            "| scenes | derivatives | within the error told | beyond it, by rounding alone | beyond |\n\
             |---|---|---|---|---|\n",
        );
        for (name, Held { compared, within, rounded }) in GROUPS.iter().zip(self.held) {
            let part = 100.0 * within as f64 / compared.max(1) as f64;
            let beyond = compared - within - rounded;
            let row =
                format!("| {name} | {compared} | {within} ({part:.1} %) | {rounded} | {beyond} |");
            let _ = writeln!(text, "{row}");
        }
        text
    }
}

/// False for an argument that changes the stiffness of rigid contacts, which the oracle is given in double precision.
fn is_told_exactly(p: &Parameters, argument: Argument) -> bool {
    let name = argument.name();
    let meeting = ["material.", "piston.", "bit.", "cross_section", "contact.stiffness"];
    let start = name == "piston.initial_velocity" || name == "material.damping_time";
    p.fidelity == Fidelity::Elastic || start || !meeting.iter().any(|m| name.starts_with(m))
}

/// A solved scene: its numbers at the end, and its events.
struct Solved {
    observables: [Dd; OBSERVABLES.len()],
    events: Vec<(oracles::law::Event, oracles::law::Mode)>,
}

/// None if the scene is not determined to its end.
fn solve(scene: &Scene, schedule: &Schedule, end: f64) -> Option<Solved> {
    let mut run = Run::<Dd>::new(scene, ACCURACY);
    run.patience = PATIENCE;
    run.through(&[end], schedule).ok()?;
    if run.near_miss() <= end {
        return None;
    }
    let events = run.events.iter().map(|e| (e.event, e.mode)).collect();
    Some(Solved { observables: exactly(&run, &run.samples[0]), events })
}

/// Central difference by the logarithm of a parameter, about a scene that is `near` the drawn one: itself, or one
/// that is changed by rounding. Retuning follows the parameter.
fn difference(
    (case, schedule): (&RandomScene, &[(f64, Action)]),
    argument: Argument,
    end: f64,
    near: &impl Fn(&Scene, &Schedule) -> (Scene, Schedule),
    events: &[(oracles::law::Event, oracles::law::Mode)],
) -> Option<[f64; MOTIONS]> {
    let start = Start { parameters: case.parameters, inputs: case.inputs };
    let own = argument.value(&start);
    let ends = [1.0 - STEP, 1.0 + STEP].map(|part| own * part);
    // The actual step after rounding, since neighbouring numbers differ exactly.
    let step = (ends[1] - ends[0]) / own;
    let side = |value: f64| {
        let Start { parameters, inputs } = argument.at(&start, value);
        let mut scene = scene::finite_elements(&parameters, &inputs);
        scene.resolutions = case.parameters.resolutions();
        let done = actions::translated_actions(&parameters, schedule);
        let (scene, done) = near(&scene, &done);
        solve(&scene, &done, end).filter(|solved| solved.events == events)
    };
    let (low, high) = (side(ends[0])?, side(ends[1])?);
    Some(std::array::from_fn(|k| {
        let change = (high.observables[k] - low.observables[k]).to_f64();
        change / step
    }))
}

/// Changes every number by a few units in the last place, by the same draws on both sides.
fn off(scene: &Scene, schedule: &Schedule) -> (Scene, Schedule) {
    let (mut near, done) = perturbed(scene, schedule, 1, &[]);
    near.resolutions = scene.resolutions;
    (near, done)
}

/// Compares derivatives of a scene by some parameters.
fn compare(name: &str, case: &RandomScene, first: usize, tally: &mut Tally) -> Option<()> {
    let whole = scene::finite_elements(&case.parameters, &case.inputs);
    let unit = Run::<f64>::new(&whole, ACCURACY).unit_time();
    let case = &case.within(0.5 * PATIENCE as f64 * unit);
    let end = case.end();
    let schedule = case.schedule().ok()?;
    let done = actions::translated_actions(&case.parameters, &schedule);
    let base = solve(&whole, &done, end)?;
    let group = match case.parameters.drive.source {
        Source::Air => 3,
        _ if schedule.is_empty() => usize::from(case.parameters.has_casing()),
        _ => 2,
    };
    let mut scales = Scales::new(case);
    scales.grow(&base.observables.map(Real::to_f64));
    let start = Start { parameters: case.parameters, inputs: case.inputs };
    let list: Vec<Argument> =
        Argument::all().filter(|argument| argument.is_read(&case.parameters)).collect();
    let run = |scene: &Start| {
        let mut machine = scene.machine()?;
        machine.keep_journal(true);
        actions::follow(&mut machine, &scene.parameters, &schedule, end)?;
        let events = machine.take_journal();
        let (values, passed) = (motions!(machine.kinematics()).to_vec(), vec![events.len()]);
        Ok(Sample { values, events, passed })
    };
    let mut machine = start.machine().ok()?;
    actions::follow(&mut machine, &case.parameters, &schedule, end).ok()?;
    let mismatch = bodies::mismatch(&machine);
    for argument in (first..first + EACH).map(|k| list[k % list.len()]) {
        let own = argument.value(&start);
        if own == 0.0 || !is_told_exactly(&case.parameters, argument) {
            continue;
        }
        let ours = derivatives(&start, &[argument], &run).ok()?.pop()?;
        if !ours.nonsmooth.is_empty() {
            tally.nonsmooth += 1;
            continue;
        }
        let same = |scene: &Scene, done: &Schedule| (scene.clone(), done.clone());
        let exact = difference((case, &schedule), argument, end, &same, &base.events);
        let near = difference((case, &schedule), argument, end, &off, &base.events);
        let (Some(exact), Some(near)) = (exact, near) else {
            tally.parted += 1;
            continue;
        };
        for k in 0..MOTIONS {
            let (what, kind) = OBSERVABLES[k];
            let estimated = ours.errors[k] * own.abs();
            // A gap is small compared with the positions that it is between. Its rounding is a unit in the last place
            // of its kind's scale, over the step.
            let blurred = f64::EPSILON * scales.of(kind) * own.abs() / ours.step;
            let allowed = FACTOR * ((near[k] - exact[k]).abs() + estimated)
                + ROUNDING * scales.of(kind)
                + blurred;
            let error = (ours.values[k] * own - exact[k]).abs() - SHARP * scales.of(kind);
            tally.compared += 1;
            let held = &mut tally.held[group];
            held.compared += 1;
            held.within += usize::from(error <= estimated);
            held.rounded += usize::from(error > estimated && error <= blurred);
            tally.fine += usize::from(error <= 1e-6 * exact[k].abs().max(scales.of(kind)));
            tally.sections += usize::from(argument.name().contains(".segment["));
            // The error of a basis in each mode changes both ends of the engine's difference.
            let basis = mismatch * scales.of(kind) * own.abs() / ours.step;
            if error <= allowed {
                tally.worst = tally.worst.max(error / allowed);
            } else if error <= basis {
                tally.rough += 1;
            } else {
                tally.failures.push(format!(
                    "{name}: d {what} / d ln {}: {:e} instead of {:e}, off by {error:e}, allowed \
                     {allowed:e}",
                    argument.name(),
                    ours.values[k] * own,
                    exact[k],
                ));
            }
        }
    }
    Some(())
}

/// Compares so many drawn scenes, the same in every run. Disagreements are reported at once.
pub fn tally(scenes: u32, from: u32, mut tell: impl FnMut(&str)) -> Tally {
    let mut tally = Tally::default();
    // The reference takes minutes for a drill string.
    let short = mixed().prop_filter("string", |drawn| !scene::is_loose(&drawn.parameters));
    for (batch, list) in batches(&short, 2, from, scenes) {
        for (index, drawn) in list.iter().enumerate() {
            let known = tally.failures.len();
            tally.scenes += 1;
            // A scene that is refused or undetermined shows nothing.
            let _ = compare(
                &format!("scene {batch}.{index}"),
                drawn,
                tally.scenes as usize * EACH,
                &mut tally,
            );
            tally.failures[known..].iter().for_each(|text| tell(text));
        }
        tell(&tally.line());
    }
    tally
}
