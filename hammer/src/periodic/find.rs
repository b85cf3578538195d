//! The fixed point of the return map, its multipliers and its gradients.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::Machine;
use crate::machine::state::State;
use crate::numerics::kernel::norm;
use crate::numerics::math;
use crate::periodic::error::CycleError;
use crate::periodic::krylov::{Solver, leading};
use crate::periodic::point::Point;
use crate::periodic::response::Response;
use crate::periodic::return_map::{Image, ReturnMap, Schedule, Section};
use crate::scene::Scene;
use crate::sensitivity::{Argument, Derivative, NonSmooth, differentiate, reach};
use num_complex::Complex64;

/// How a cycle is sought.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Returns to the section (or periods of the drive) that the cycle closes after.
    pub returns: usize,
    /// Inputs over a period, where the drive has no section of its own.
    pub schedule: Option<Schedule>,
    /// Where to begin: a cycle found before, of a scene with as many modes. Otherwise, the start
    /// of the scene.
    pub start: Option<Orbit>,
    /// Returns that are simulated before Newton's method begins.
    pub settle: usize,
    /// Steps at the most.
    pub steps: usize,
    /// Largest distance of `P(x)` from `x`, over the size of `x` (roots of energies).
    pub accuracy: f64,
    /// A return that takes longer is none, s.
    pub limit: f64,
    /// Most Krylov vectors spent on multipliers; 0: none are wanted.
    pub multipliers: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self {
            returns: 1,
            schedule: None,
            start: None,
            settle: 4,
            steps: 60,
            accuracy: 1e-10,
            limit: 10.0,
            multipliers: 24,
        }
    }
}

impl Search {
    pub(super) fn section(&self) -> Section {
        let (schedule, returns) = (self.schedule.clone(), self.returns.max(1));
        Section { schedule, returns, limit: self.limit }
    }
}

/// The point of a cycle on its section.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit(pub(super) Point);

/// Derivatives of a cycle by one argument.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// Derivatives of what the cycle gives.
    pub values: Response,
    /// Their errors, estimated.
    pub errors: Response,
    /// Why they may hold on one side only; empty at a smooth point.
    pub nonsmooth: Vec<NonSmooth>,
    /// Least change of the argument that would turn the order of two events, to first order.
    pub reach: f64,
}

/// A stationary cycle.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// What it gives.
    pub response: Response,
    /// The events of a period, in their order.
    pub sequence: Vec<Event>,
    /// Leading Floquet multipliers, largest first.
    pub multipliers: Vec<Complex64>,
    /// Errors of these, estimated.
    pub multiplier_errors: Vec<f64>,
    /// How far the map still moves the point, over its size.
    pub distance: f64,
    /// Steps made, and how many of them were Newton's.
    pub steps: [usize; 2],
    /// Derivatives, in the order of the arguments.
    pub gradients: Vec<Gradient>,
    /// The point on the section, to begin another search from.
    pub orbit: Orbit,
    /// The state there, to go on from.
    pub state: State,
}

impl Cycle {
    /// True if nearby motions come closer: every multiplier found is within the unit circle by
    /// more than its error, and there is one.
    pub fn is_stable(&self) -> bool {
        let sizes = self.multipliers.iter().map(|m| math::norm(*m));
        let mut list = sizes.zip(&self.multiplier_errors);
        !self.multipliers.is_empty() && list.all(|(size, error)| size + error < 1.0)
    }

    /// A number that cycles of another order of events hardly share (FNV-1a of 32 bits).
    pub fn fingerprint(&self) -> f64 {
        let byte = |hash: u32, byte: u8| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        let names = self.sequence.iter().map(|event| format!("{event},"));
        f64::from(names.fold(0x811c_9dc5, |hash, name| name.bytes().fold(hash, byte)))
    }
}

/// Accuracy of multipliers, over the largest.
const MULTIPLIERS: f64 = 1e-5;
/// Relative error of a product with `P_x`: rounding and curvature over its steps.
const PRODUCT: f64 = 1e-7;
/// A Newton step is worth a try if this part of its equation is left at most.
const SOLVED: f64 = 0.1;

/// The cycle that a scene is near, and its derivatives by the arguments. It may be unstable: see
/// [`Cycle::is_stable`].
///
/// # Errors
/// See [`CycleError`].
pub fn find(scene: &Scene, search: &Search, by: &[Argument]) -> Result<Cycle, CycleError> {
    let mut machine = scene.machine()?;
    if let Some(Orbit(point)) = &search.start {
        point.place(&mut machine)?;
    }
    let settle = if search.start.is_some() { search.settle } else { search.settle.max(1) };
    find_from(machine, scene, &Search { settle, ..search.clone() }, by)
}

/// The cycle that a machine of a scene is near, whatever [`Search::start`].
pub(super) fn find_from(
    mut machine: Machine,
    scene: &Scene,
    search: &Search,
    by: &[Argument],
) -> Result<Cycle, CycleError> {
    let section = search.section();
    section.check(&scene.parameters)?;
    let once = Section { returns: 1, ..section.clone() };
    for _ in 0..search.settle {
        once.run(&mut machine, false)?;
    }
    machine.settle()?;
    let start = Point::of(&machine);
    let fixed = seek(&mut ReturnMap::new(machine, &section), search, start)?;
    finish(scene, &section, search, by, fixed)
}

/// A fixed point, how far the map still moves it, and what it took.
struct Found {
    point: Point,
    distance: f64,
    steps: [usize; 2],
    weights: Vec<f64>,
}

/// Newton's method, and the map itself where that does not help.
fn seek(map: &mut ReturnMap, search: &Search, start: Point) -> Result<Found, CycleError> {
    let mut point = start;
    let mut image = map.image(&point)?;
    let (mut apart, mut distance) = map.defect(&point, &image);
    let (mut newton, mut step) = (0, 0);
    // Rounding is reached where a step no longer helps.
    while step < search.steps && distance > 0.01 * search.accuracy {
        let mut best: Option<(Point, Image, Vec<f64>, f64, bool)> = None;
        for (candidate, by_newton) in candidates(map, &point, &image, &apart, distance) {
            let Ok(next) = map.image(&candidate) else { continue };
            let (a, d) = map.defect(&candidate, &next);
            if best.as_ref().is_none_or(|b| d < b.3) {
                best = Some((candidate, next, a, d, by_newton));
            }
            if d < 0.3 * distance {
                break;
            }
        }
        let Some(best) = best else { break };
        if distance <= search.accuracy && best.3 >= distance {
            break;
        }
        newton += usize::from(best.4);
        step += 1;
        (point, image, apart, distance) = (best.0, best.1, best.2, best.3);
    }
    if distance <= search.accuracy {
        let weights = map.weights.clone();
        return Ok(Found { point, distance, steps: [step, newton], weights });
    }
    Err(CycleError::NotFound { returns: map.section.returns, steps: step, distance })
}

/// Where to try next: Newton's point, points short of it, and where the map leads.
fn candidates(
    map: &mut ReturnMap,
    point: &Point,
    image: &Image,
    defect: &[f64],
    distance: f64,
) -> Vec<(Point, bool)> {
    let mapped = (image.end.clone(), false);
    if !distance.is_finite() {
        return vec![mapped];
    }
    let (step, residual) = Solver::default().solve(defect, |u| map.times(point, image, u));
    if residual.is_nan() || residual > SOLVED || step.iter().any(|x| !x.is_finite()) {
        return vec![mapped];
    }
    let moved = |part: f64| {
        let mut y = point.weighted(&map.weights);
        y.iter_mut().zip(&step).for_each(|(y, s)| *y += part * s);
        (point.with(&y, &map.weights), true)
    };
    vec![moved(1.0), mapped, moved(0.3), moved(0.1), moved(0.02)]
}

fn finish(
    scene: &Scene,
    section: &Section,
    search: &Search,
    by: &[Argument],
    Found { point, distance, steps, weights }: Found,
) -> Result<Cycle, CycleError> {
    let mut map = ReturnMap { machine: scene.machine()?, section, weights, measured: true };
    let image = map.image(&point)?;
    let mut solver = Solver::default();
    let mut gradients = Vec::with_capacity(by.len());
    for argument in by {
        let slope = slope(scene, &map, &point, &image, *argument)?;
        gradients.push(gradient(&mut map, &mut solver, &point, &image, slope));
    }
    map.measured = false;
    let mut multipliers = Vec::new();
    if search.multipliers > 0 {
        // A start with a part in everything that a cycle forgets slowly.
        let start: Vec<f64> =
            (0..map.weights.len()).map(|i| 1.0 / (1.0 + (i * 7 % 13) as f64)).collect();
        let mut start = map.times(&point, &image, &start);
        start.truncate(map.weights.len());
        let times = |u: &[f64]| map.times(&point, &image, u);
        multipliers = leading(&start, search.multipliers, MULTIPLIERS, times);
    }
    point.place(&mut map.machine)?;
    Ok(Cycle {
        sequence: image.sequence(),
        response: image.response,
        multipliers: multipliers.iter().map(|(m, _)| *m).collect(),
        multiplier_errors: multipliers.iter().map(|(m, e)| e + PRODUCT * math::norm(*m)).collect(),
        distance,
        steps,
        gradients,
        orbit: Orbit(point),
        state: map.machine.state(),
    })
}

/// The derivative by an argument of the image of a point that stays where it is.
fn slope(
    scene: &Scene,
    map: &ReturnMap,
    point: &Point,
    image: &Image,
    argument: Argument,
) -> Result<Derivative, CycleError> {
    let value = argument.value(scene);
    differentiate(&image.sample(&map.weights), argument.scale(scene), &mut |h| {
        let machine = match argument.at(scene, value + h).machine() {
            Err(Error::Parameter(_)) => return Ok(None),
            machine => machine?,
        };
        let section = map.section.shifted(argument, h);
        let weights = map.weights.clone();
        let mut near = ReturnMap { machine, section: &section, weights, measured: true };
        Ok(Some(near.image(point)?.sample(&map.weights)))
    })
}

/// The derivative of the cycle: `dx = (I - P_x)^-1 P_p` and what that does to its response.
fn gradient(
    map: &mut ReturnMap,
    solver: &mut Solver,
    point: &Point,
    image: &Image,
    slope: Derivative,
) -> Gradient {
    let (moved, own) = slope.values.split_at(map.weights.len());
    let (x, left) = solver.solve(moved, |u| map.times(point, image, u));
    let (moved_errors, own_errors) = slope.errors.split_at(map.weights.len());
    let [size, error] = [moved, moved_errors].map(norm);
    let relative = PRODUCT + left + if size > 0.0 { error / size } else { 0.0 };
    let through = x.get(map.weights.len()..).unwrap_or_default().iter().copied();
    let through: Vec<f64> = through.chain(std::iter::repeat(0.0)).take(own.len()).collect();
    let values: Vec<f64> = own.iter().zip(&through).map(|(a, b)| a + b).collect();
    let errors: Vec<f64> =
        own_errors.iter().zip(&through).map(|(e, b)| e + relative * b.abs()).collect();
    let count = image.response.len();
    let nonsmooth = slope.nonsmooth;
    let reach = reach(image.events(), |k| values[count + k]);
    Gradient {
        values: Response::of_numbers(&values[..count]),
        errors: Response::of_numbers(&errors[..count]),
        reach: if nonsmooth.is_empty() { reach } else { 0.0 },
        nonsmooth,
    }
}
