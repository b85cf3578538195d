//! The engine's derivatives against central differences in extended precision.
//!
//! Over a step of `2^-36` of a parameter the reference, in double-double arithmetic, differs by
//! some twenty digits, and truncation (the square of the step times the radians that the fastest
//! motion has turned by) is below rounding: the difference is the derivative to all digits that a
//! double holds, wherever both sides see the same events. It is no differentiated code: nothing
//! of the engine's tangents is in it.
//!
//! What may differ is not chosen: the same difference about a scene whose every number is off by
//! a few units in the last place says what double precision can know.

use crate::compare::{ACCURACY, FACTOR, PATIENCE, ROUNDING};
use crate::draw::{Draw, draw};
use crate::scene;
use crate::shown::{MOTIONS, SHOWN, Scales, exactly, motions};
use crate::tally::batches;
use hammer::tangent::{Parameter, Seed, Tangents};
use hammer::{Fidelity, Machine, Parameters};
use oracles::dd::Dd;
use oracles::linear::Real;
use oracles::perturb::perturbed;
use oracles::run::Run;
use oracles::scene::Scene;

/// Step of a difference, over the parameter.
const STEP: f64 = 1.0 / (1u64 << 36) as f64;
/// What rounding grows by in the quotients of a tangent: the engine divides by differences of
/// eigenvalues down to a thousandth of them (`CLOSE` in `hammer/src/tangent/response.rs`).
const QUOTIENT: f64 = 1e3;
/// Parameters looked at in a scene: others in the next.
const EACH: usize = 4;

/// What came of many scenes.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Scenes drawn.
    pub scenes: u32,
    /// Derivatives compared.
    pub compared: usize,
    /// Those of them that are by a section of a body.
    pub sections: usize,
    /// Pairs of a scene and a parameter whose two sides see other events.
    pub parted: usize,
    /// Pairs about which the engine itself warns.
    pub warned: usize,
    /// The largest difference over what is allowed, of those that hold.
    pub worst: f64,
    /// What does not agree.
    pub failures: Vec<String>,
}

impl Tally {
    /// In a line.
    pub fn line(&self) -> String {
        format!(
            "{} scenes, {} derivatives ({} by sections), {} pairs of other events, {} warned of: {} disagree; of the \
             others {:.3} of what is allowed at most",
            self.scenes,
            self.compared,
            self.sections,
            self.parted,
            self.warned,
            self.failures.len(),
            self.worst
        )
    }
}

/// Rigid bodies meet through a stiffness that the oracle is told in double precision.
fn is_told_exactly(p: &Parameters, parameter: Parameter) -> bool {
    use Parameter::{
        BitLength, ContactStiffness, CrossSection, Density, PistonLength, YoungsModulus,
    };
    let meeting = [BitLength, ContactStiffness, CrossSection, Density, PistonLength, YoungsModulus];
    let section = matches!(parameter, Parameter::Section(..));
    p.fidelity == Fidelity::Elastic || !(section || meeting.contains(&parameter))
}

/// A solved scene: what it shows at its end, and its events.
struct Solved {
    shown: [Dd; SHOWN.len()],
    events: Vec<(oracles::law::Event, oracles::law::Mode)>,
}

/// None if the scene is not decided to its end.
fn solve(scene: &Scene, end: f64) -> Option<Solved> {
    let mut run = Run::<Dd>::new(scene, ACCURACY);
    run.patience = PATIENCE;
    run.through(&[end], &Vec::new()).ok()?;
    if run.undecided() <= end {
        return None;
    }
    let events = run.events.iter().map(|e| (e.event, e.mode)).collect();
    Some(Solved { shown: exactly(&run, &run.samples[0]), events })
}

/// Central difference by the logarithm of a parameter, of a scene that is `near` (the drawn one,
/// or one that is off by rounding).
fn difference(
    draw: &Draw,
    parameter: Parameter,
    end: f64,
    near: &impl Fn(&Scene) -> Scene,
    events: &[(oracles::law::Event, oracles::law::Mode)],
) -> Option<[f64; MOTIONS]> {
    let mut ends = [draw.parameters; 2];
    let [below, above] = ends.each_mut().map(|p| parameter.slot(p));
    (*below, *above) = (*below * (1.0 - STEP), *above * (1.0 + STEP));
    // What the step came to by rounding: neighbours differ exactly.
    let step = (*above - *below) / *parameter.slot(&mut draw.parameters.clone());
    let side = |p: Parameters| {
        let mut scene = scene::finite_elements(&p, &draw.inputs);
        scene.resolutions = draw.parameters.resolutions();
        solve(&near(&scene), end).filter(|solved| solved.events == events)
    };
    let (low, high) = (side(ends[0])?, side(ends[1])?);
    Some(std::array::from_fn(|k| {
        let change = (high.shown[k] - low.shown[k]).to_f64();
        change / step
    }))
}

/// Every number off by a few units in the last place, by the same draws on both sides.
fn off(scene: &Scene) -> Scene {
    let mut near = perturbed(scene, &Vec::new(), 1, &[]).0;
    near.resolutions = scene.resolutions;
    near
}

/// Compares derivatives of a scene by some parameters.
fn compare(name: &str, draw: &Draw, first: usize, tally: &mut Tally) -> Option<()> {
    let whole = scene::finite_elements(&draw.parameters, &draw.inputs);
    let pace = Run::<f64>::new(&whole, ACCURACY).pace();
    let draw = &draw.within(0.5 * PATIENCE as f64 * pace);
    let end = draw.end();
    let base = solve(&whole, end)?;
    let turned = 1.0 + end / pace;
    let mut scales = Scales::new(draw);
    scales.grow(&base.shown.map(Real::to_f64));
    let read = |q: &&Parameter| q.is_read(&draw.parameters);
    let list: Vec<Parameter> = Parameter::ALL.iter().filter(read).copied().collect();
    for parameter in (first..first + EACH).map(|k| list[k % list.len()]) {
        let own = *parameter.slot(&mut draw.parameters.clone());
        if own == 0.0 || !is_told_exactly(&draw.parameters, parameter) {
            continue;
        }
        let mut machine = Machine::new(&draw.parameters, &draw.inputs, 0.0).ok()?;
        let mut tangents = Tangents::of_scene(&machine, &[Seed::Parameter(parameter)]).ok()?;
        tangents.advance(&mut machine, end).ok()?;
        let ours = motions!(&tangents.look(&machine)[0].kinematics);
        if tangents.cautious() > 0 {
            tally.warned += 1;
            continue;
        }
        let exact = difference(draw, parameter, end, &Scene::clone, &base.events);
        let near = difference(draw, parameter, end, &off, &base.events);
        let (Some(exact), Some(near)) = (exact, near) else {
            tally.parted += 1;
            continue;
        };
        for k in 0..MOTIONS {
            let (what, kind) = SHOWN[k];
            // A phase turns by as many radians a part of a frequency.
            let allowed = FACTOR * (near[k] - exact[k]).abs()
                + ROUNDING * QUOTIENT * turned * scales.of(kind);
            let error = (ours[k] * own - exact[k]).abs();
            tally.compared += 1;
            tally.sections += usize::from(matches!(parameter, Parameter::Section(..)));
            if error <= allowed {
                tally.worst = tally.worst.max(error / allowed);
            } else {
                tally.failures.push(format!(
                    "{name}: d {what} / d ln {}: {:e} instead of {:e}, off by {error:e}, allowed \
                     {allowed:e}",
                    parameter.name(),
                    ours[k] * own,
                    exact[k],
                ));
            }
        }
    }
    Some(())
}

/// Compares so many drawn scenes, always the same ones; what disagrees is told at once.
pub fn tally(scenes: u32, from: u32, mut tell: impl FnMut(&str)) -> Tally {
    let mut tally = Tally::default();
    for (batch, list) in batches(&draw(), 2, from, scenes) {
        for (index, drawn) in list.iter().enumerate() {
            let known = tally.failures.len();
            tally.scenes += 1;
            // A scene that is refused or not decided shows nothing.
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
