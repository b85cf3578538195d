//! Cycles along an argument, through folds and changes of the order of events: continuation by
//! pseudo-arclength.
//!
//! A branch is a curve of points `y = (x, p)` with `P(x; p) = x`; `x` is measured by the roots of
//! its energies over those of the start, `p` by its start value. From a point `y0` of it the next is
//! sought at a step `s` along the tangent `t`:
//!
//! ```text
//! P(x; p) - x = 0,     t . (y - y0) = s,        (P_x - I, P_p) t = 0,  |t| = 1
//! ```
//!
//! so that `p` may turn back (a fold) where the curve does not. Steps become shorter as a fold needs
//! it. Where the order of events changes, the map and its derivatives are other ones (another
//! *chart*) and the curve has a kink: Newton's method goes on in the chart that the simulated map is
//! in. Where a kink is so sharp that the curve turns back, the tangent is taken from the chart
//! beyond. Where the map jumps, or what it does is finer than steps are, the next point is sought at
//! a fixed argument beyond; where there is none nearby the branch ends, and says so.

use crate::bodies::bar::Bar;
use crate::laws::event::Event;
use crate::modal::model::Model;
use crate::numerics::kernel::{inner_product, norm};
use crate::periodic::error::CycleError;
use crate::periodic::find::{Cycle, Orbit, Search, find};
use crate::periodic::krylov::Solver;
use crate::periodic::point::Point;
use crate::periodic::return_map::{Image, ReturnMap, Section};
use crate::scene::Scene;
use crate::sensitivity::{Argument, differentiate};

/// Newton's steps to a point.
const NEWTON: usize = 8;
/// Least step, over the longest.
const LEAST: f64 = 1.0 / 64.0;
/// The same before a branch is said to end.
const FINEST: f64 = LEAST / 1024.0;
/// How far off the tangent a step may end, over the step: of any curve, and for a turn by a small
/// angle (several kinks within a step may turn to and fro).
const FAINT: f64 = 0.05;
const BENT: f64 = 2.0;
/// Steps beyond a kink, over the least.
const BEYOND: [f64; 3] = [1.0, 4.0, 16.0];
/// How far an unresolved stretch may lead, over the longest step.
const JUMP: f64 = 0.5;
/// A state's change is measured in parts of the state this many times as large: most cycles move by
/// some times the relative change of an argument, and steps should be of the latter.
const LARGER: f64 = 10.0;

/// A point of the curve, on the branch or near it.
#[derive(Clone, Debug)]
struct Position {
    /// Its discrete state.
    chart: Point,
    /// Measured state, then the argument over its start value.
    y: Vec<f64>,
}

impl Position {
    fn along(&self, tangent: &[f64], step: f64) -> Self {
        let y = self.y.iter().zip(tangent).map(|(y, t)| y + step * t).collect();
        Self { y, ..self.clone() }
    }

    fn from(&self, other: &Self) -> Vec<f64> {
        self.y.iter().zip(&other.y).map(|(a, b)| a - b).collect()
    }

    /// Measured state, and argument.
    fn parts(&self) -> (&[f64], f64) {
        let (x, p) = self.y.split_at(self.y.len() - 1);
        (x, p[0])
    }
}

/// What is known of the curve at a spot.
#[derive(Clone, Debug, Default)]
struct Local {
    /// The way on, of length 1.
    tangent: Vec<f64>,
    /// `P_p`. Newton's method makes do with it nearby: it corrects the state above all.
    slope: Vec<f64>,
    sequence: Vec<Event>,
}

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct BranchPoint {
    /// The argument's value.
    pub value: f64,
    /// True if the argument rises where the branch goes on.
    pub rising: bool,
    /// True if the way to it was not resolved: a kink, or a jump that ends near.
    pub unresolved: bool,
    /// The cycle there.
    pub cycle: Cycle,
}

/// A branch of cycles, followed from a cycle on.
#[derive(Clone, Debug)]
pub struct Branch {
    scene: Scene,
    along: Argument,
    search: Search,
    section: Section,
    /// The argument's value at the start.
    unit: f64,
    /// What measures a state, over the modes' amplitudes.
    metric: Vec<f64>,
    here: Position,
    local: Local,
    /// The last step that went well.
    step: f64,
}

fn unit(mut x: Vec<f64>) -> Vec<f64> {
    let size = norm(&x);
    x.iter_mut().for_each(|x| *x /= size);
    x
}

/// Amplitudes by which a state's coordinates become displacements and velocities, over the modes'
/// shapes: what stays as it is where the argument changes the masses.
fn amplitudes(model: &Model, count: usize) -> Vec<f64> {
    let per_mode = |bar: &Bar| vec![1.0 / bar.mass.sqrt(); bar.len()];
    let per_mode: Vec<f64> = model.graph.bodies.iter().flat_map(per_mode).collect();
    let mut all = [&per_mode[..], &per_mode].concat();
    all.resize(count, 1.0);
    all
}

impl Branch {
    /// From a cycle of a scene, along an argument that is not zero, the way it rises or falls.
    ///
    /// # Errors
    /// [`CycleError::NoScale`] for a value of zero; those of [`find`].
    pub fn new(
        scene: &Scene,
        along: Argument,
        search: &Search,
        orbit: &Orbit,
        rising: bool,
    ) -> Result<Self, CycleError> {
        let value = along.value(scene);
        if value == 0.0 || !value.is_finite() {
            return Err(CycleError::NoScale { value });
        }
        let section = search.section();
        section.check(&scene.parameters)?;
        let mut map = ReturnMap::new(scene.machine()?, &section);
        map.image(&orbit.0)?;
        let measured = orbit.0.weighted(&map.weights);
        let size = LARGER * norm(&measured);
        let amplitudes = amplitudes(map.machine.motion().model(), measured.len());
        let metric = map.weights.iter().zip(amplitudes).map(|(w, a)| w / (size * a)).collect();
        let y: Vec<f64> = measured.iter().map(|x| x / size).chain([1.0]).collect();
        let mut direction = vec![0.0; y.len()];
        direction[y.len() - 1] = if rising == (value > 0.0) { 1.0 } else { -1.0 };
        let mut branch = Self {
            scene: *scene,
            along,
            search: Search { start: None, settle: 0, steps: 0, ..search.clone() },
            section: section.clone(),
            unit: value,
            metric,
            here: Position { chart: orbit.0.clone(), y },
            local: Local::default(),
            step: f64::INFINITY,
        };
        branch.local = branch.local_at(&branch.here, &direction)?;
        Ok(branch)
    }

    /// The next point, at most `longest` of the argument's start value further, with derivatives
    /// of its cycle.
    ///
    /// # Errors
    /// [`CycleError::Edge`] where no way on is found; those of [`find`].
    pub fn next(&mut self, longest: f64, by: &[Argument]) -> Result<BranchPoint, CycleError> {
        let (least, finest) = (LEAST * longest, FINEST * longest);
        let step = self.step.min(longest);
        let known_tight = step < least;
        if self.advance(step, if known_tight { finest } else { least }) {
            return self.point_here(false, by);
        }
        let landing = self.around_kink(least).or_else(|| self.over_jump(longest));
        if let Some((position, _)) = landing {
            self.local = self.local_at(&position, &unit(position.from(&self.here)))?;
            (self.here, self.step) = (position, 0.25 * longest);
            return self.point_here(true, by);
        }
        // A fold may be tighter than that.
        if !known_tight && self.advance(0.5 * least, finest) {
            return self.point_here(false, by);
        }
        Err(CycleError::Edge { value: self.here.parts().1 * self.unit, step: finest })
    }

    /// Goes on by a step, or by a half of it, a quarter, and so on to the least.
    fn advance(&mut self, mut step: f64, least: f64) -> bool {
        while step >= least {
            let guess = self.here.along(&self.local.tangent, step);
            if let Some((position, _)) = self.correct(&guess, &self.local.tangent)
                && let Ok(local) = self.local_at(&position, &unit(position.from(&self.here)))
                && self.leads_to(&position, step, &local.tangent)
            {
                (self.here, self.local, self.step) = (position, local, 2.0 * step);
                return true;
            }
            step *= 0.5;
        }
        false
    }

    /// Whether the curve leads from here to a spot: where it bends, or has a kink, by an angle, the
    /// spot is off the tangent by less than the step times that. Beyond a jump it is off, and the
    /// tangent is what it was.
    fn leads_to(&self, position: &Position, step: f64, tangent: &[f64]) -> bool {
        let off = position.from(&self.here.along(&self.local.tangent, step));
        let bent: Vec<f64> = tangent.iter().zip(&self.local.tangent).map(|(a, b)| a - b).collect();
        let [aside, bent] = [&off, &bent].map(|x| norm(x));
        aside <= step * (FAINT + BENT * bent) && aside <= step
    }

    fn point_here(&self, unresolved: bool, by: &[Argument]) -> Result<BranchPoint, CycleError> {
        let value = self.here.parts().1 * self.unit;
        let scene = self.along.at(&self.scene, value);
        let map = self.map(self.here.parts().1)?;
        let (x, _) = self.here.parts();
        let start = Some(Orbit(self.here.chart.with(x, &map.weights)));
        let cycle = find(&scene, &Search { start, ..self.search.clone() }, by)?;
        let rising = self.local.tangent.last().is_some_and(|t| t * self.unit > 0.0);
        Ok(BranchPoint { value, rising, unresolved, cycle })
    }

    /// Beyond a kink at which the curve turns back: by the tangent of the chart there.
    fn around_kink(&self, least: f64) -> Option<(Position, Vec<Event>)> {
        let (guess, beyond) = BEYOND.into_iter().find_map(|part| {
            let guess = self.here.along(&self.local.tangent, part * least);
            let local = self.local_at(&guess, &self.local.tangent).ok()?;
            (local.sequence != self.local.sequence).then_some((guess, local))
        })?;
        BEYOND.into_iter().flat_map(|part| [(part, -1.0), (part, 1.0)]).find_map(
            |(part, direction)| {
                let tangent: Vec<f64> = beyond.tangent.iter().map(|t| direction * t).collect();
                let corrected = self.correct(&guess.along(&tangent, part * least), &tangent)?;
                // In the chart before the kink it is where we came from.
                (corrected.1 == beyond.sequence).then_some(corrected)
            },
        )
    }

    /// Over a jump of the map, or what is finer than steps are: the cycle nearby at the next values
    /// of the argument.
    fn over_jump(&self, longest: f64) -> Option<(Position, Vec<Event>)> {
        let last = self.here.y.len() - 1;
        let mut direction = vec![0.0; last + 1];
        direction[last] = self.local.tangent[last].signum();
        [0.25, 0.5, 1.0].into_iter().find_map(|part| {
            let corrected =
                self.correct(&self.here.along(&direction, part * longest), &direction)?;
            let moved = corrected.0.from(&self.here);
            (norm(&moved) <= JUMP * longest).then_some(corrected)
        })
    }

    /// The map with the argument at this multiple of its start value, of measured states.
    fn map(&self, multiple: f64) -> Result<ReturnMap<'_>, CycleError> {
        let scene = self.along.at(&self.scene, multiple * self.unit);
        let mut map = ReturnMap::new(scene.machine()?, &self.section);
        let amplitudes = amplitudes(map.machine.motion().model(), self.metric.len());
        map.weights = self.metric.iter().zip(amplitudes).map(|(w, a)| w * a).collect();
        Ok(map)
    }

    /// The map at a spot, the spot's point of it, and where that leads.
    fn evaluate(&self, position: &Position) -> Result<(ReturnMap<'_>, Point, Image), CycleError> {
        let (x, multiple) = position.parts();
        let mut map = self.map(multiple)?;
        let point = position.chart.with(x, &map.weights);
        let image = map.image(&point)?;
        Ok((map, point, image))
    }

    /// The tangent at a spot, turned the way of another vector; `P_p` and the order of events.
    fn local_at(&self, position: &Position, direction: &[f64]) -> Result<Local, CycleError> {
        let (mut map, point, image) = self.evaluate(position)?;
        let multiple = position.parts().1;
        let base = image.sample(&map.weights);
        let derivative = differentiate(&base, 1.0, &mut |h| {
            let mut near = position.clone();
            *near.y.last_mut().unwrap_or(&mut 0.0) = multiple + h;
            let (map, _, image) = self.evaluate(&near)?;
            Ok::<_, CycleError>(Some(image.sample(&map.weights)))
        })?;
        let mut slope = derivative.values;
        slope.truncate(map.weights.len());
        let mut b = vec![0.0; position.y.len()];
        b[slope.len()] = 1.0;
        let lost = CycleError::NoTangent { value: self.unit * multiple };
        let tangent = solve(&mut map, &point, &image, [&slope, direction], &b).ok_or(lost)?;
        Ok(Local { tangent: unit(tangent), slope, sequence: image.sequence() })
    }

    /// Newton's method from a guess, on the plane through it across the tangent; with the order of
    /// events there.
    fn correct(&self, guess: &Position, tangent: &[f64]) -> Option<(Position, Vec<Event>)> {
        let (mut position, mut last) = (guess.clone(), f64::INFINITY);
        let accuracy = self.search.accuracy;
        for _ in 0..NEWTON {
            let (mut map, point, image) = self.evaluate(&position).ok()?;
            let (defect, distance) = map.defect(&point, &image);
            if !distance.is_finite() {
                // The map leads to another discrete state: go on from there.
                let x = image.end.weighted(&map.weights);
                let y = x.into_iter().chain([position.parts().1]).collect();
                position = Position { chart: image.end, y };
                continue;
            }
            // Below the accuracy wanted one more step is made, as long as it helps.
            if distance <= 0.01 * accuracy || distance <= accuracy && distance > 0.3 * last {
                return Some((position, image.sequence()));
            }
            // Into another chart and back: a shorter step.
            if distance > 4.0 * last {
                return None;
            }
            last = distance;
            let short = inner_product(tangent, &guess.from(&position));
            let b: Vec<f64> = defect.into_iter().chain([short]).collect();
            let step = solve(&mut map, &point, &image, [&self.local.slope, tangent], &b)?;
            position.y.iter_mut().zip(step).for_each(|(y, s)| *y += s);
        }
        None
    }
}

/// Solves `(P_x - I, P_p) y = -b` with `row . y = r` for `(b, r)`.
fn solve(
    map: &mut ReturnMap,
    point: &Point,
    image: &Image,
    [slope, row]: [&[f64]; 2],
    b: &[f64],
) -> Option<Vec<f64>> {
    let n = slope.len();
    let (solution, residual) = Solver::default().solve(b, |u| {
        let mut product = vec![0.0; n];
        if u[..n].iter().any(|u| *u != 0.0) {
            product = map.times(point, image, &u[..n]);
            product.truncate(n);
        }
        product.iter_mut().zip(slope).for_each(|(y, s)| *y += s * u[n]);
        product.push(u[n] - inner_product(row, u));
        product
    });
    (residual <= 1e-3 && solution.iter().all(|x| x.is_finite())).then_some(solution)
}
