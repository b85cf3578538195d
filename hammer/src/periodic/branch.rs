//! Cycles along a parameter, through folds and changes of the order of events.
//!
//! A branch is a curve of points `y = (x, p)` with `P(x; p) = x`; `x` is measured by the roots of
//! its energies over those of the start, `p` by its start value. From a point of it the next is
//! sought at a stride `s` along the heading `t`:
//!
//! ```text
//! P(x; p) - x = 0,     t . (y - y0) = s,        (P_x - I, P_p) t = 0,  |t| = 1
//! ```
//!
//! so that `p` may turn back (a fold) where the curve does not. Where the order of events
//! changes, the return map has an edge and the curve a kink: Newton's method goes on in the chart
//! that the simulated map is in. Where a kink is so sharp that the curve turns back against the
//! heading, the heading is taken from the chart beyond. Strides become shorter as a fold
//! needs it. Where the map jumps, or what it does is
//! finer than strides are, the next point is sought at a fixed parameter beyond; where there is
//! none nearby the branch ends, and says so.

use crate::bodies::bar::Bar;
use crate::error::Error;
use crate::laws::event::Event;
use crate::laws::mode::Mode;
use crate::machine::Machine;
use crate::modal::model::Model;
use crate::numerics::kernel::inner_product;
use crate::periodic::fault::CycleError;
use crate::periodic::krylov::Solver;
use crate::periodic::lap::{Course, Lap};
use crate::periodic::newton::{Cycle, Orbit, Search, Seeker, stationary};
use crate::periodic::point::Point;
use crate::quantities::inputs::Input;
use crate::quantities::parameters::{InputValues, Parameters};
use crate::tangent::Seed;

/// Newton's steps to a point.
const STEPS: usize = 8;
/// Least stride, over the longest.
const LEAST: f64 = 1.0 / 64.0;
/// The same before a branch is said to end.
const FINEST: f64 = LEAST / 1024.0;
/// How far off the heading a stride may end, over the stride: of any curve, and for a turn by a
/// small angle (several kinks within a stride may turn to and fro).
const FAINT: f64 = 0.05;
const BENT: f64 = 2.0;
/// Strides beyond a kink, over the least.
const BEYOND: [f64; 3] = [1.0, 4.0, 16.0];
/// How far a step over may lead, over the longest stride.
const OVER: f64 = 0.5;

/// A state's change is measured in parts of the state this many times as large: most cycles
/// move by some times the relative change of a parameter, and strides should be of the latter.
const LARGER: f64 = 10.0;

/// A point of the curve.
#[derive(Clone, Debug)]
struct Spot {
    mode: Mode,
    /// Measured state, then the parameter over its start value.
    y: Vec<f64>,
}

impl Spot {
    fn along(&self, heading: &[f64], stride: f64) -> Self {
        let y = self.y.iter().zip(heading).map(|(y, t)| y + stride * t).collect();
        Self { mode: self.mode, y }
    }

    fn from(&self, other: &Self) -> Vec<f64> {
        self.y.iter().zip(&other.y).map(|(a, b)| a - b).collect()
    }
}

/// Heading, `P_p` and order of events.
type Turn = (Vec<f64>, Vec<f64>, Vec<Event>);

/// What a look at a spot tells Newton's method.
enum Look {
    /// The map leads to another mode: go on from there.
    Elsewhere(Spot),
    /// How far off, and where next.
    Near(f64, Vec<Event>, Option<Vec<f64>>),
}

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct Waypoint {
    /// The parameter's value.
    pub value: f64,
    /// True if the parameter rises where the branch goes on.
    pub rising: bool,
    /// True if the way to it was not resolved: a kink, or a jump that ends near.
    pub over: bool,
    /// The cycle there.
    pub cycle: Cycle,
}

/// A branch of cycles, followed from a cycle on.
#[derive(Clone, Debug)]
pub struct Branch {
    parameters: Parameters,
    inputs: InputValues,
    along: Seed,
    search: Search,
    course: Course,
    /// The parameter's value at the start.
    unit: f64,
    /// What measures a state, over the modes' amplitudes.
    metric: Vec<f64>,
    here: Spot,
    sequence: Vec<Event>,
    /// The way on, of length 1.
    heading: Vec<f64>,
    /// `P_p` here. Newton's method makes do with it: it corrects the state above all.
    slope: Vec<f64>,
    /// The last stride that went well.
    stride: f64,
}

fn unit(mut x: Vec<f64>) -> Vec<f64> {
    let size = inner_product(&x, &x).sqrt();
    x.iter_mut().for_each(|x| *x /= size);
    x
}

/// Amplitudes by which a state's coordinates become displacements and velocities, over the
/// modes' shapes: what stays as it is where a parameter changes (see `tangent`).
fn amplitudes(model: &Model) -> Vec<f64> {
    let own = |bar: &Bar| vec![1.0 / bar.mass.sqrt(); bar.len()];
    let own = [own(&model.piston), own(&model.bit)].concat();
    [&own[..], &own, &[1.0; 3]].concat()
}

impl Branch {
    /// From a cycle of a scene, along a parameter or constant input that is not zero, the way it
    /// rises or falls.
    ///
    /// # Errors
    /// [`CycleError::NoScale`] for a value of zero; those of [`stationary`].
    pub fn new(
        parameters: &Parameters,
        inputs: &InputValues,
        along: Seed,
        search: &Search,
        orbit: &Orbit,
        rising: bool,
    ) -> Result<Self, CycleError> {
        let mut branch = Self {
            parameters: *parameters,
            inputs: *inputs,
            along,
            search: Search { start: None, settle: 0, steps: 0, ..search.clone() },
            course: search.course(),
            unit: 1.0,
            metric: Vec::new(),
            here: Spot { mode: orbit.0.mode, y: Vec::new() },
            sequence: Vec::new(),
            heading: Vec::new(),
            slope: Vec::new(),
            stride: f64::INFINITY,
        };
        let value = branch.value_of(parameters, inputs);
        if value == 0.0 || !value.is_finite() {
            return Err(CycleError::NoScale { value });
        }
        branch.unit = value;
        let mut machine = branch.machine(1.0)?;
        branch.course.check(&machine)?;
        if orbit.0.body_state().len() != machine.motion().whole_state().len() {
            return Err(Error::Foreign.into());
        }
        let amplitudes = amplitudes(machine.motion().model());
        machine.settle()?;
        let mut seeker = Seeker::new(&mut machine, branch.course.clone())?;
        seeker.lap_from(&orbit.0)?;
        let plain = &seeker.weights;
        let measured: Vec<f64> = orbit.0.x.iter().zip(plain).map(|(x, w)| x * w).collect();
        let size = LARGER * inner_product(&measured, &measured).sqrt();
        branch.metric = plain.iter().zip(amplitudes).map(|(w, a)| w / (size * a)).collect();
        branch.here.y = measured.iter().map(|x| x / size).chain([1.0]).collect();
        let mut way = vec![0.0; branch.here.y.len()];
        way[branch.here.y.len() - 1] = if rising == (value > 0.0) { 1.0 } else { -1.0 };
        (branch.heading, branch.slope, branch.sequence) = branch.turn(&branch.here, &way)?;
        Ok(branch)
    }

    /// The next point, at most `longest` of the parameter's start value further.
    ///
    /// # Errors
    /// [`CycleError::Edge`] where no way on is found; those of [`stationary`].
    pub fn next(&mut self, longest: f64, seeds: &[Seed]) -> Result<Waypoint, CycleError> {
        let (least, finest) = (LEAST * longest, FINEST * longest);
        let stride = self.stride.min(longest);
        let known_tight = stride < least;
        if self.stride_on(stride, if known_tight { finest } else { least }) {
            return self.waypoint(false, seeds);
        }
        let found = self.around(least).or_else(|| self.over(longest));
        if let Some((spot, sequence)) = found {
            let turn = self.turn(&spot, &unit(spot.from(&self.here)))?;
            self.stride = 0.25 * longest;
            self.stand(spot, sequence, turn);
            return self.waypoint(true, seeds);
        }
        // A fold may be tighter than that.
        if !known_tight && self.stride_on(0.5 * least, finest) {
            return self.waypoint(false, seeds);
        }
        let value = self.here.y[self.here.y.len() - 1] * self.unit;
        Err(CycleError::Edge { value, stride: finest })
    }

    /// Goes on by a stride, or by a half of it, a quarter, and so on to the least.
    fn stride_on(&mut self, mut stride: f64, least: f64) -> bool {
        while stride >= least {
            let guess = self.here.along(&self.heading, stride);
            if let Some((spot, sequence)) = self.correct(&guess, &self.heading)
                && let Ok(turn) = self.turn(&spot, &unit(spot.from(&self.here)))
                && self.is_led_to(&spot, stride, &turn.0)
            {
                self.stride = 2.0 * stride;
                self.stand(spot, sequence, turn);
                return true;
            }
            stride *= 0.5;
        }
        false
    }

    fn stand(&mut self, spot: Spot, sequence: Vec<Event>, (heading, slope, _): Turn) {
        (self.here, self.sequence, self.heading, self.slope) = (spot, sequence, heading, slope);
    }

    /// Whether the curve leads from here to a spot: where it bends, or has a kink, by an angle, the
    /// spot is off the heading by less than the stride times that. Beyond a jump it is off, and
    /// the heading is what it was.
    fn is_led_to(&self, spot: &Spot, stride: f64, heading: &[f64]) -> bool {
        let off = spot.from(&self.here.along(&self.heading, stride));
        let bent: Vec<f64> = heading.iter().zip(&self.heading).map(|(a, b)| a - b).collect();
        let [aside, bent] = [&off, &bent].map(|x| inner_product(x, x).sqrt());
        aside <= stride * (FAINT + BENT * bent) && aside <= stride
    }

    fn waypoint(&self, over: bool, seeds: &[Seed]) -> Result<Waypoint, CycleError> {
        let last = self.here.y.len() - 1;
        let mut machine = self.machine(self.here.y[last])?;
        let orbit = Orbit(self.point(&self.here, machine.motion().model()));
        let search = Search { start: Some(orbit), ..self.search.clone() };
        let cycle = stationary(&mut machine, &search, seeds)?;
        let rising = self.heading[last] * self.unit > 0.0;
        Ok(Waypoint { value: self.here.y[last] * self.unit, rising, over, cycle })
    }

    /// Beyond a kink at which the curve turns back: by the heading of the chart there.
    fn around(&self, least: f64) -> Option<(Spot, Vec<Event>)> {
        let mut beyond = None;
        for part in BEYOND {
            let guess = self.here.along(&self.heading, part * least);
            let Ok((heading, _, sequence)) = self.turn(&guess, &self.heading) else { continue };
            if sequence != self.sequence {
                beyond = Some((guess, heading, sequence));
                break;
            }
        }
        let (guess, heading, sequence) = beyond?;
        for (part, way) in BEYOND.into_iter().flat_map(|part| [(part, -1.0), (part, 1.0)]) {
            let heading: Vec<f64> = heading.iter().map(|t| way * t).collect();
            let found = self.correct(&guess.along(&heading, part * least), &heading);
            // In the chart before the kink it is where we came from.
            if let Some((spot, seen)) = found
                && seen == sequence
            {
                return Some((spot, seen));
            }
        }
        None
    }

    /// Over a jump of the map, or what is finer than strides are: the cycle nearby at the next
    /// values of the parameter.
    fn over(&self, longest: f64) -> Option<(Spot, Vec<Event>)> {
        let last = self.here.y.len() - 1;
        let mut way = vec![0.0; last + 1];
        way[last] = self.heading[last].signum();
        [0.25, 0.5, 1.0].into_iter().find_map(|part| {
            let found = self.correct(&self.here.along(&way, part * longest), &way)?;
            let moved = found.0.from(&self.here);
            (inner_product(&moved, &moved).sqrt() <= OVER * longest).then_some(found)
        })
    }

    fn value_of(&self, parameters: &Parameters, inputs: &InputValues) -> f64 {
        match self.along {
            Seed::Parameter(parameter) => *parameter.slot(&mut parameters.clone()),
            Seed::Input(input, _) => *slot(input, &mut inputs.clone()),
            Seed::State => 0.0,
        }
    }

    /// The scene with the parameter at this multiple of its start value.
    fn machine(&self, multiple: f64) -> Result<Machine, CycleError> {
        let (mut parameters, mut inputs) = (self.parameters, self.inputs);
        match self.along {
            Seed::Parameter(parameter) => *parameter.slot(&mut parameters) = multiple * self.unit,
            Seed::Input(input, _) => *slot(input, &mut inputs) = multiple * self.unit,
            Seed::State => {}
        }
        Ok(Machine::new(&parameters, &inputs, 0.0)?)
    }

    fn weights(&self, model: &Model) -> Vec<f64> {
        self.metric.iter().zip(amplitudes(model)).map(|(w, a)| w * a).collect()
    }

    fn point(&self, spot: &Spot, model: &Model) -> Point {
        let x = spot.y.iter().zip(self.weights(model)).map(|(y, w)| y / w).collect();
        Point { mode: spot.mode, x }
    }

    /// Goes a lap from a spot.
    fn look<R>(
        &self,
        spot: &Spot,
        then: impl FnOnce(&mut Seeker<'_>, &Lap, &[f64], f64) -> R,
    ) -> Result<R, CycleError> {
        let mut machine = self.machine(spot.y[spot.y.len() - 1])?;
        let weights = self.weights(machine.motion().model());
        let point = self.point(spot, machine.motion().model());
        let mut seeker = Seeker::new(&mut machine, self.course.clone())?;
        seeker.weights = weights;
        let lap = seeker.lap_from(&point)?;
        let (apart, distance) = seeker.defect(&point, &lap);
        seeker.start = point;
        Ok(then(&mut seeker, &lap, &apart, distance))
    }

    /// The heading at a spot, turned the way of another vector; `P_p` and the order of events
    /// there.
    fn turn(&self, spot: &Spot, way: &[f64]) -> Result<Turn, CycleError> {
        let mut b = vec![0.0; spot.y.len()];
        b[spot.y.len() - 1] = 1.0;
        let (found, slope, sequence) = self.look(spot, |seeker, lap, _, _| {
            let slope = seeker.slope(lap, self.along)?;
            let slope: Vec<f64> = slope.iter().map(|s| s * self.unit).collect();
            Ok::<_, CycleError>((solve(seeker, lap, [&slope, way], &b), slope, lap.sequence()))
        })??;
        let lost = CycleError::NoHeading { value: self.unit * spot.y[spot.y.len() - 1] };
        Ok((unit(found.ok_or(lost)?), slope, sequence))
    }

    /// Newton's method from a guess, on the plane through it across the heading.
    fn correct(&self, guess: &Spot, heading: &[f64]) -> Option<(Spot, Vec<Event>)> {
        let (mut spot, mut last) = (guess.clone(), f64::INFINITY);
        let accuracy = self.search.accuracy;
        for _ in 0..STEPS {
            let short = inner_product(heading, &guess.from(&spot));
            let looked = self.look(&spot, |seeker, lap, apart, distance| {
                if !distance.is_finite() {
                    let end = lap.end.x.iter().zip(&seeker.weights).map(|(x, w)| x * w);
                    let y = end.chain([spot.y[spot.y.len() - 1]]).collect();
                    return Look::Elsewhere(Spot { mode: lap.end.mode, y });
                }
                // Below the accuracy wanted one more step is made, as long as it helps.
                let step = (distance > 0.01 * accuracy).then(|| {
                    let b: Vec<f64> = apart.iter().copied().chain([short]).collect();
                    solve(seeker, lap, [&self.slope, heading], &b)
                });
                Look::Near(distance, lap.sequence(), step.flatten())
            });
            let (distance, sequence, step) = match looked.ok()? {
                Look::Elsewhere(there) => {
                    spot = there;
                    continue;
                }
                Look::Near(distance, sequence, step) => (distance, sequence, step),
            };
            if distance <= 0.01 * accuracy || distance <= accuracy && distance > 0.3 * last {
                return Some((spot, sequence));
            }
            // Into another chart and back: a shorter stride.
            if distance > 4.0 * last {
                return None;
            }
            last = distance;
            spot.y.iter_mut().zip(step?).for_each(|(y, s)| *y += s);
        }
        None
    }
}

/// Solves `(P_x - I, P_p) y = -b` with `row . y = r` for `(b, r)`.
fn solve(
    seeker: &mut Seeker<'_>,
    lap: &Lap,
    [slope, row]: [&[f64]; 2],
    b: &[f64],
) -> Option<Vec<f64>> {
    let n = slope.len();
    let (found, left) = Solver::default().solve(b, |u| {
        let mut image = seeker.times(lap, &u[..n]);
        image.iter_mut().zip(slope).for_each(|(y, s)| *y += s * u[n]);
        image.push(u[n] - inner_product(row, u));
        image
    });
    (left <= 1e-3 && found.iter().all(|x| x.is_finite())).then_some(found)
}

fn slot(input: Input, inputs: &mut InputValues) -> &mut f64 {
    match input {
        Input::FeedForce => &mut inputs.feed_force,
        Input::DriveForce => &mut inputs.drive_force,
        Input::DrivePressure => &mut inputs.drive_pressure,
        Input::ReturnPressure => &mut inputs.return_pressure,
    }
}
