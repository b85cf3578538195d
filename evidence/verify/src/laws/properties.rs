//! Properties of every scene: proptest draws a scene, log-uniformly over the domain, and a monitored machine must keep them.
//!
//! The engine may refuse a scene, but only by name and only where this file allows it ([`refusal`]); any other error
//! fails the property.

use crate::comparison::bodies;
use crate::drawn::scaling::{heavier, larger};
use crate::drawn::scenes::{RandomScene, meshed, mixed};
use crate::laws::monitor::{Monitored, Violation};
use crate::scene::is_loose;
use hammer::{Body, Error, Kinematics, Machine, Parameters, Source, State, WorkLimit};
use proptest::strategy::{BoxedStrategy, Strategy};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use std::cell::Cell;

/// Samples that a scene may take. Each unit of its time is some radians of its fastest mode, that of the mesh or of
/// the penalty, and the search takes a few samples per radian; a chattering contact multiplies this by its events.
pub fn allowed(case: &RandomScene) -> u64 {
    let p = &case.parameters;
    let (chuck, casing) = tie(p);
    let (joint, rods) = joint(p);
    let springs = p.contact.stiffness.max(p.rock.unloading_ratio * p.rock.stiffness);
    let springs = springs.max(chuck).max(joint);
    let ends = [(Body::Piston, true), (Body::Bit, false), (Body::Bit, true)];
    let light =
        ends.map(|(body, lower)| bodies::lightness(p, body, lower)).into_iter().sum::<f64>()
            + casing
            + rods;
    let fastest = bodies::fastest_wave(p) + (springs * light).sqrt();
    20_000 + (40.0 * fastest * case.end()) as u64
}

/// Stiffness of the chuck, N/m, and response of the casing to a sudden force, 1/kg; 0 without one.
fn tie(p: &Parameters) -> (f64, f64) {
    if p.has_casing() { (p.chuck.stiffness, 1.0 / p.casing_mass()) } else { (0.0, 0.0) }
}

/// Stiffness of a loose joint, N/m, and response of its faces to a sudden force, 1/kg; 0 without one.
fn joint(p: &Parameters) -> (f64, f64) {
    if !is_loose(p) {
        return (0.0, 0.0);
    }
    (p.drill.joint.stiffness, 2.0 * bodies::lightest_span(p, Body::Bit))
}

/// Transitions per second that the scene's fastest spring or dashpot can cause.
pub fn fastest_rate(case: &RandomScene) -> f64 {
    let p = &case.parameters;
    let [piston, shoulder] = [(Body::Piston, true), (Body::Bit, false)]
        .map(|(body, lower)| bodies::lightness(p, body, lower));
    let bit = bodies::lightness(p, Body::Bit, true);
    let contact = (p.meeting_stiffness() * (piston + shoulder)).sqrt();
    let rock = (p.rock.unloading_ratio * p.rock.stiffness * bit).sqrt();
    let dashpot = p.rock.viscosity * bit;
    let (stiffness, casing) = tie(p);
    let chuck = (stiffness * (shoulder + casing)).sqrt();
    let (stiffness, faces) = joint(p);
    let joint = (stiffness * faces).sqrt();
    // Two transitions in a period.
    [contact, rock, dashpot, chuck, joint].into_iter().fold(0.0, f64::max) / std::f64::consts::PI
}

/// Springs and dashpots from this rate on can make a node chatter within a guard's resolution, 1/s.
const CHATTER: f64 = 1e7;

/// Why the engine may refuse a scene; none if it must not. It may refuse overwork if a spring or dashpot is fast
/// enough to chatter, and joined bodies whose modes are not found to working accuracy because three springs change
/// them. It may never refuse a cascade of events.
pub fn refusal(case: &RandomScene, error: &Error) -> Option<&'static str> {
    match error {
        Error::Overwork { limit: WorkLimit::Transitions, .. } => {
            (fastest_rate(case) > CHATTER).then_some(REFUSALS[0])
        }
        Error::Spectrum { .. } => case.parameters.has_casing().then_some(REFUSALS[1]),
        Error::TiePulled { .. } => Some(REFUSALS[3]),
        Error::Air { place, range: [top, bottom], .. } => {
            let least = (place - top).min(bottom - place);
            (least < EMPTY * (bottom - top)).then_some(REFUSALS[2])
        }
        _ => None,
    }
}

/// Share of the piston's way to where a chamber has no volume, from which on the engine may refuse: the air is then
/// more than a hundred thousand times as dense as at the start.
const EMPTY: f64 = 1e-6;

/// The accepted refusals, in words.
pub const REFUSALS: [&str; 4] = [
    "overwork, where a node can move at 1e7/s",
    "modes of piston, bit and casing joined not found to working accuracy",
    "a chamber of air left without volume",
    "a drill string that the loads at the start pull apart",
];

/// Result of a property on a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds.
    Holds,
    /// The engine refused the scene, for one of the [`REFUSALS`].
    Refused(&'static str),
}

/// Why a property does not hold.
#[derive(Debug, thiserror::Error)]
enum Broken {
    #[error(transparent)]
    Violation(#[from] Violation),
    #[error("{0}")]
    Differs(&'static str),
    #[error("{0}")]
    Refused(&'static str),
}

impl From<Error> for Broken {
    fn from(error: Error) -> Self {
        Self::Violation(error.into())
    }
}

fn verdict(outcome: Result<(), Broken>) -> Result<Verdict, String> {
    match outcome {
        Ok(()) => Ok(Verdict::Holds),
        Err(Broken::Refused(why)) => Ok(Verdict::Refused(why)),
        Err(other) => Err(other.to_string()),
    }
}

/// Runs machines of a drawn scene. Their errors become refusals where these are accepted.
struct Run<'a> {
    case: &'a RandomScene,
    machine: Machine,
}

impl<'a> Run<'a> {
    fn new(case: &'a RandomScene) -> Result<Self, Broken> {
        Ok(Self { case, machine: Machine::new(&case.parameters, &case.inputs, 0.0)? })
    }

    fn to(&mut self, time: f64) -> Result<&mut Self, Broken> {
        match self.machine.advance(time) {
            Ok(()) => Ok(self),
            Err(error) => match refusal(self.case, &error) {
                Some(why) => Err(Broken::Refused(why)),
                None => Err(error.into()),
            },
        }
    }
}

/// True if air drives it. Air is known only to its own error, and cannot be scaled.
fn is_aired(case: &RandomScene) -> bool {
    case.parameters.drive.source == Source::Air
}

/// Signs, monotone losses, energy, momentum and work, checked in forty slices.
fn keeps_the_laws(case: &RandomScene) -> Result<(), Broken> {
    if is_aired(case) {
        return Ok(());
    }
    let mut monitored = Monitored::new(&case.parameters, &case.inputs, allowed(case))?;
    monitored.observe()?;
    match monitored.run(case.end(), 40) {
        Err(Violation::Engine(error)) => match refusal(case, &error) {
            Some(why) => Err(Broken::Refused(why)),
            None => Err(error.into()),
        },
        other => Ok(other?),
    }
}

/// The state as bytes: it distinguishes signs of zeros, and everything that a comparison of floats does not.
///
/// # Panics
/// If a state cannot be serialised.
pub fn bits(m: &mut Machine) -> Vec<u8> {
    postcard::to_allocvec(&m.state().without_step()).expect("a state is plain data")
}

fn alike(a: &[u8], b: &[u8]) -> Result<(), Broken> {
    if a == b { Ok(()) } else { Err(Broken::Differs("the states differ")) }
}

/// One step and many give the same state, bit for bit.
fn slices_alike(case: &RandomScene) -> Result<(), Broken> {
    let (mut one, mut many) = (Run::new(case)?, Run::new(case)?);
    one.to(case.end())?;
    for cut in &case.cuts {
        many.to(cut * case.end())?;
        // Reading outputs must change nothing.
        many.machine.kinematics();
        many.machine.energies();
        many.machine.peaks();
    }
    many.to(case.end())?;
    alike(&bits(&mut one.machine), &bits(&mut many.machine))
}

/// A state saved at a cut, serialised and read again, continues bit for bit, both in a new machine and in one that
/// has gone on.
fn restores(case: &RandomScene) -> Result<(), Broken> {
    let (mut run, end) = (Run::new(case)?, case.end());
    let state = run.to(case.cuts[0] * end)?.machine.state();
    let json = serde_json::to_string(&state).expect("a state can be written");
    let read: State = serde_json::from_str(&json).expect("a state can be read");
    let packed = postcard::to_allocvec(&state).expect("a state can be packed");
    let unpacked: State = postcard::from_bytes(&packed).expect("a state can be unpacked");
    let straight = bits(&mut run.to(end)?.machine);
    let mut fresh = Run::new(case)?;
    fresh.machine.restore(&read)?;
    alike(&bits(&mut fresh.to(end)?.machine), &straight)?;
    run.machine.restore(&unpacked)?;
    alike(&bits(&mut run.to(end)?.machine), &straight)
}

/// With masses, stiffnesses, viscosities and forces times a power of four, the motion is the same bit for bit (masses
/// enter by their square roots).
fn heavier_alike(case: &RandomScene) -> Result<(), Broken> {
    let factor = 4f64.powi((case.cuts[0] * 12.0) as i32 - 6);
    moves_alike(case, &heavier(case, factor), 1.0)
}

/// With displacements, velocities and forces times a power of two, the motion is that much larger, bit for bit:
/// resolutions are shares of the travel.
fn larger_alike(case: &RandomScene) -> Result<(), Broken> {
    let factor = 2f64.powi((case.cuts[0] * 12.0) as i32 - 6);
    let mut case = case.clone();
    let travel = |case: &RandomScene| case.parameters.travel();
    if travel(&larger(&case, 2.0)) != 2.0 * travel(&case) {
        // Its parameters have no length but those of the bodies, which stay.
        case.parameters.contact.initial_gap = 1e-3 * travel(&case);
    }
    moves_alike(&case, &larger(&case, factor), factor)
}

fn moves_alike(case: &RandomScene, other: &RandomScene, factor: f64) -> Result<(), Broken> {
    if is_aired(case) {
        return Ok(());
    }
    let (mut one, mut two) = (Run::new(case)?, Run::new(other)?);
    one.machine.keep_journal(true);
    two.machine.keep_journal(true);
    for cut in case.cuts.iter().chain(&[1.0]) {
        let (x, y) = (one.to(cut * case.end()), two.to(cut * case.end()));
        let (x, y) = (*x?.machine.kinematics(), *y?.machine.kinematics());
        let places = |k: &Kinematics| {
            [k.piston.displacement, k.piston.velocity, k.tip.displacement, k.tip.velocity]
        };
        if places(&x).map(|v| factor * v) != places(&y) {
            return Err(Broken::Differs("the motions differ"));
        }
    }
    if one.machine.take_journal() == two.machine.take_journal() {
        Ok(())
    } else {
        Err(Broken::Differs("the events differ"))
    }
}

/// A property's name and its test on one drawn scene.
pub type Property = (&'static str, fn(&RandomScene) -> Result<Verdict, String>);

/// All properties.
pub const PROPERTIES: [Property; 5] = [
    (
        "F_C and F_R never pull, uu and losses never fall, energy and momentum balance, work is bounded",
        |d| verdict(keeps_the_laws(d)),
    ),
    ("the trajectory does not depend on communication points, bit for bit", |d| {
        verdict(slices_alike(d))
    }),
    ("a saved state, written out and read back, continues bit for bit", |d| verdict(restores(d))),
    ("masses, stiffnesses and forces times 4^k: the same motion and events, bit for bit", |d| {
        verdict(heavier_alike(d))
    }),
    (
        "displacements, velocities and forces times 2^k: that motion, the same events, bit for bit",
        |d| verdict(larger_alike(d)),
    ),
];

/// Results of a property.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Scenes drawn.
    pub scenes: u32,
    /// Number of refused scenes, for each of the [`REFUSALS`].
    pub refused: [u32; REFUSALS.len()],
    /// The smallest failing scene of each batch with a failure, and the reason.
    pub failures: Vec<String>,
}

/// Scenes that one seed draws. A failure ends only its batch.
const BATCH: u32 = 100;

/// Draws `cases` scenes for a property, on any mesh; they are the same in every run.
pub fn check(property: &Property, cases: u32) -> Checked {
    check_on(property, cases, || meshed().boxed())
}

/// The same with scenes that combine everything, but without actions.
pub fn check_mixed(property: &Property, cases: u32) -> Checked {
    check_on(property, cases, || mixed().boxed())
}

fn check_on(
    property: &Property,
    cases: u32,
    scenes: impl Fn() -> BoxedStrategy<RandomScene>,
) -> Checked {
    let mut checked = Checked { scenes: cases, ..Checked::default() };
    for batch in 0..cases.div_ceil(BATCH) {
        let count = BATCH.min(cases - batch * BATCH);
        let config = Config { cases: count, failure_persistence: None, ..Config::default() };
        let mut seed = [0; 32];
        seed[..4].copy_from_slice(&batch.to_le_bytes());
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let refused = [const { Cell::new(0) }; REFUSALS.len()];
        let outcome = TestRunner::new_with_rng(config, rng).run(&scenes(), |d| {
            match property.1(&d).map_err(TestCaseError::fail)? {
                Verdict::Holds => {}
                Verdict::Refused(why) => {
                    let which = REFUSALS.iter().position(|r| *r == why).unwrap_or(0);
                    refused[which].set(refused[which].get() + 1);
                }
            }
            Ok(())
        });
        for (sum, count) in checked.refused.iter_mut().zip(&refused) {
            *sum += count.get();
        }
        if let Err(failure) = outcome {
            checked.failures.push(report(batch, &failure));
        }
    }
    checked
}

fn report(batch: u32, failure: &TestError<RandomScene>) -> String {
    match failure {
        TestError::Fail(reason, scene) => format!("seed {batch}: {reason}: {scene:?}"),
        TestError::Abort(reason) => format!("seed {batch}: {reason}"),
    }
}
