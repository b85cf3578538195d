//! Differences of runs along one argument.

use crate::allowance::Allowance;
use crate::error::Error;
use crate::interrupt::in_threads;
use crate::machine::journal::Record;
use crate::quantities::parameters::{Parameters, Source};
use crate::scene::Scene;
use crate::sensitivity::argument::Argument;
use crate::sensitivity::sample::{Change, Sample};
use std::fmt;
use std::thread;

/// First step, relative to the argument's scale.
/// For a smooth function the best step is about the cube root of a rounding, where rounding and the third derivative
/// contribute equally to the error of a central difference.
/// It is smaller here, because waves make the third derivative large.
/// (Half of it would save 11 % of the work, but some errors would exceed a millionth.)
const STEP: f64 = 2e-6;
/// Factor from one step to the next smaller one.
const FINER: f64 = 0.125;
/// Least step, at which rounding leaves three digits.
const LEAST: f64 = 1e-10;
/// Relative rounding of a run's numbers. With half of it, only 92 of 100 stated errors held in randomly drawn scenes.
const ROUNDING: f64 = 2e-13;
/// Largest `air.error` of runs whose difference is taken.
const AIR: f64 = 1e-11;
/// A derivative with this relative error is accurate enough.
const FINE: f64 = 1e-6;

/// Derivatives of a run's numbers by one argument.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Derivative {
    /// Derivatives; where the one-sided derivatives differ, their mean.
    pub values: Vec<f64>,
    /// Estimated errors; where the one-sided derivatives differ, at least half their difference.
    pub errors: Vec<f64>,
    /// Left-sided derivatives; NaN if the argument cannot be smaller.
    pub left: Vec<f64>,
    /// Right-sided derivatives; NaN if the argument cannot be larger.
    pub right: Vec<f64>,
    /// The reasons why the one-sided derivatives may differ; empty at a smooth point.
    pub nonsmooth: Vec<NonSmooth>,
    /// Least change of the argument that would make two events simultaneous, to first order. The derivative is valid
    /// for smaller changes, unless a new event appears.
    pub reach: f64,
    /// The largest step that was used.
    pub step: f64,
}

/// A reason why a point is non-smooth. A side means larger or smaller values of the argument.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NonSmooth {
    /// One side has other events than the point itself, however close to it.
    Events {
        /// True if it is the side of larger values.
        above: bool,
        /// How the events differ.
        change: Change,
    },
    /// A number has a kink although the events are the same, for example because its maximum jumps to another instant.
    Kink {
        /// Index of the number.
        index: usize,
    },
    /// One side cannot be run, because the argument is at the edge of its domain.
    Edge {
        /// True if it is the side of larger values.
        above: bool,
    },
    /// The events of one side still change at the least step.
    Unsettled {
        /// True if it is the side of larger values.
        above: bool,
    },
}

impl fmt::Display for NonSmooth {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let side = |above: &bool| if *above { "above" } else { "below" };
        match self {
            Self::Events { above, change } => write!(f, "{}: {change}", side(above)),
            Self::Kink { index } => write!(f, "output number {index} has a kink"),
            Self::Edge { above } => write!(f, "{}: the value is out of its domain", side(above)),
            Self::Unsettled { above } => {
                write!(f, "{}: the events change down to the smallest step", side(above))
            }
        }
    }
}

/// Derivatives of the results of `run`, with respect to each argument in turn.
///
/// ```
/// use hammer::Scene;
/// use hammer::sensitivity::{Argument, Sample, derivatives};
///
/// // Before the first blow, the piston is a free body under a constant force.
/// let run = |scene: &Scene| {
///     Sample::of_run(&mut scene.machine()?, &[0.005], &|m| vec![m.kinematics().piston.velocity])
/// };
/// let scene = Scene::default();
/// let by = [Argument::named("drive.amplitude").expect("a parameter")];
/// let slopes = derivatives(&scene, &by, &run)?;
/// let exact = 0.005 / scene.parameters.piston_mass();
/// assert!((slopes[0].values[0].abs() - exact).abs() <= 1e-6 * exact);
/// # Ok::<(), hammer::Error>(())
/// ```
///
/// # Errors
///
/// Any error of `run` for the scene itself, and any error except [`Error::Parameter`] for a changed argument.
pub fn derivatives(
    scene: &Scene,
    by: &[Argument],
    run: &(dyn Fn(&Scene) -> Result<Sample, Error> + Sync),
) -> Result<Vec<Derivative>, Error> {
    Allowance::of_seconds(scene.parameters.work_limit).within(|| differences(scene, by, run))
}

/// Sets `air.error` for runs whose difference is taken. Returns the relative error of their numbers.
pub(crate) fn sharpen(parameters: &mut Parameters) -> f64 {
    if parameters.drive.source != Source::Air {
        return ROUNDING;
    }
    parameters.air.error = parameters.air.error.min(AIR);
    ROUNDING + parameters.air.error
}

fn differences(
    scene: &Scene,
    by: &[Argument],
    run: &(dyn Fn(&Scene) -> Result<Sample, Error> + Sync),
) -> Result<Vec<Derivative>, Error> {
    let mut scene = *scene;
    let noise = sharpen(&mut scene.parameters);
    let base = run(&scene)?;
    // Every argument gets an equal share of the allowance, so that the result does not depend on the number of threads.
    let share = Allowance::left().shared(by.len());
    let derivative = |argument: &Argument| {
        let value = argument.value(&scene);
        let scale = Scale { size: argument.scale(&scene), noise };
        let mut changed = |h: f64| match run(&argument.at(&scene, value + h)) {
            Err(Error::Parameter(_)) => Ok(None),
            result => result.map(Some),
        };
        share.within(|| differentiate(&base, scale, &mut changed))
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    in_threads(by.iter().collect(), threads, derivative).into_iter().collect()
}

/// Size of an argument, and the relative error of the runs' numbers.
#[derive(Clone, Copy)]
pub(crate) struct Scale {
    pub size: f64,
    pub noise: f64,
}

/// The derivatives from runs at one step, all of which have the same events.
struct Stencil {
    step: f64,
    scale: Scale,
    values: Vec<f64>,
    errors: Vec<f64>,
    /// Slopes of each number below and above the point.
    sides: Vec<[f64; 2]>,
    /// Numbers whose slope changes more sharply at the point than near it.
    kinks: Vec<usize>,
    /// True if a smaller step may be more accurate.
    coarse: bool,
    reach: f64,
}

impl Stencil {
    /// The derivatives at the step `h`; `None` if a run is outside the domain or has other events.
    fn new<E>(base: &Sample, h: f64, scale: Scale, run: &mut Run<E>) -> Result<Option<Self>, E> {
        let mut take = |x: f64| run(x).map(|sample| sample.filter(|sample| sample.agrees(base)));
        let (Some(high), Some(low)) = (take(h)?, take(-h)?) else { return Ok(None) };
        let instant = |sample: &Sample, k: usize| {
            sample.events[k].time - base.events[k].time + sample.events[k].time_rest
        };
        let slope = |k: usize| (instant(&high, k) - instant(&low, k)) / (2.0 * h);
        let count = base.values.len();
        let mut stencil = Self {
            step: h,
            scale,
            values: vec![0.0; count],
            errors: vec![0.0; count],
            sides: vec![[0.0; 2]; count],
            kinks: Vec::new(),
            coarse: false,
            reach: reach(&base.events, slope),
        };
        let value = |sample: &Sample, k: usize| sample.values.get(k).copied().unwrap_or(f64::NAN);
        let mut inaccurate = false;
        for k in 0..count {
            inaccurate |=
                stencil.second_order(k, [value(&low, k), value(base, k), value(&high, k)]);
        }
        if inaccurate {
            let Some(far) = take(2.0 * h)? else { return Ok(None) };
            for k in 0..count {
                let four = [value(&low, k), value(base, k), value(&high, k), value(&far, k)];
                stencil.third_order(k, four);
            }
        }
        Ok(Some(stencil))
    }

    /// Tolerated error of the derivative of number `k`. It is a share of the derivative itself or, if that is small, a
    /// share of the derivative with which the number would change by 1 % while the argument doubles.
    fn tolerance(&self, k: usize, size: f64) -> f64 {
        FINE * self.values[k].abs().max(0.01 * size / self.scale.size) + 2.0 * self.noise(size)
    }

    /// Error of a derivative due to the rounding of numbers of this size.
    fn noise(&self, size: f64) -> f64 {
        self.scale.noise * size / self.step
    }

    /// The central difference from the numbers at `-h`, 0 and `h`. For a function with one length scale its error is a
    /// third of the squared second difference over the slope; the estimate is a half. Returns true if that is too much.
    fn second_order(&mut self, k: usize, f: [f64; 3]) -> bool {
        let [below, above] = [(f[1] - f[0]) / self.step, (f[2] - f[1]) / self.step];
        let (value, bend) = (0.5 * (below + above), (above - below).abs());
        let size = f.iter().fold(0.0f64, |size, f| size.max(f.abs()));
        let truncation = 0.5 * bend * (bend / value.abs()).min(1.0);
        self.values[k] = value;
        self.sides[k] = [below, above];
        self.errors[k] = if bend > 0.0 { truncation } else { 0.0 } + self.noise(size);
        bend > 0.0 && truncation > self.tolerance(k, size)
    }

    /// The slope of the cubic through the numbers at `-h`, 0, `h` and `2 h`. Its difference from the central difference
    /// is taken as its error.
    fn third_order(&mut self, k: usize, f: [f64; 4]) {
        let h = self.step;
        let [below, above] = self.sides[k];
        let [bend, next] = [above - below, (f[3] - f[2]) / h - above];
        let third = (next - bend) / 6.0;
        let size = f.iter().fold(0.0f64, |size, f| size.max(f.abs()));
        let noise = self.noise(size);
        self.values[k] = 0.5 * (below + above) - third;
        self.errors[k] = third.abs() + noise;
        let (sharp, smooth) = (next.abs() < 0.2 * bend.abs(), third.abs() < 0.05 * bend.abs());
        if sharp && bend.abs() > 1e-4 * (below.abs() + above.abs()) && bend.abs() > 100.0 * noise {
            self.kinks.push(k);
            self.coarse = true;
        }
        self.coarse |= smooth && third.abs() > self.tolerance(k, size);
    }

    /// Takes each derivative from the step with the smaller error. A kink counts only if both steps show it.
    fn merge(&mut self, finer: &Self) {
        for k in 0..self.values.len() {
            let [old, new] = [&*self, finer].map(|s| s.sides[k][1] - s.sides[k][0]);
            let kinked = [&*self, finer].iter().all(|s| s.kinks.contains(&k));
            if kinked && (new - old).abs() < 0.25 * old.abs() {
                continue;
            }
            self.kinks.retain(|kink| *kink != k);
            if finer.errors[k] < self.errors[k] {
                (self.values[k], self.errors[k]) = (finer.values[k], finer.errors[k]);
            }
        }
    }

    fn finish(mut self) -> Derivative {
        let (mut left, mut right) = (self.values.clone(), self.values.clone());
        for k in &self.kinks {
            let [below, above] = self.sides[*k];
            (left[*k], right[*k]) = (below, above);
            self.values[*k] = 0.5 * (below + above);
            self.errors[*k] = 0.5 * (above - below).abs();
        }
        let Self { values, errors, kinks, reach, step, .. } = self;
        let nonsmooth = kinks.into_iter().map(|index| NonSmooth::Kink { index }).collect();
        Derivative { values, errors, left, right, nonsmooth, reach, step }
    }
}

/// Returns the sample for a change of the argument; `None` outside the domain.
type Run<'a, E> = dyn FnMut(f64) -> Result<Option<Sample>, E> + 'a;

/// Derivatives along one argument.
pub(crate) fn differentiate<E>(
    base: &Sample,
    scale: Scale,
    run: &mut Run<E>,
) -> Result<Derivative, E> {
    let mut step = STEP;
    while step >= LEAST {
        if let Some(mut stencil) = Stencil::new(base, step * scale.size, scale, run)? {
            if stencil.coarse {
                match Stencil::new(base, FINER * step * scale.size, scale, run)? {
                    Some(finer) => stencil.merge(&finer),
                    None => stencil.kinks.clear(),
                }
            }
            return Ok(stencil.finish());
        }
        step *= FINER;
    }
    let below = Side::new(base, -scale.size, scale.noise, run)?;
    let above = Side::new(base, scale.size, scale.noise, run)?;
    Ok(join(base, below, above))
}

/// The one-sided derivatives on one side of a point.
struct Side {
    values: Vec<f64>,
    errors: Vec<f64>,
    why: Option<NonSmooth>,
    step: f64,
}

impl Side {
    /// The slopes from runs at `h` and `2 h` that have the same events. If the point itself has other events, it lies
    /// on another branch, and the slope follows from these two runs alone.
    fn new<E>(base: &Sample, scale: f64, noise: f64, run: &mut Run<E>) -> Result<Self, E> {
        let (mut step, above) = (STEP, scale > 0.0);
        let mut why = NonSmooth::Edge { above };
        while step >= LEAST {
            let h = step * scale;
            if let Some(one) = run(h)? {
                why = NonSmooth::Unsettled { above };
                if let Some(two) = run(2.0 * h)?.filter(|two| two.agrees(&one)) {
                    let change = base.change(&one);
                    let why = change.map(|change| NonSmooth::Events { above, change });
                    return Ok(Self::of(base, [&one, &two], [h, noise], why));
                }
            }
            step *= FINER;
        }
        let missing = vec![f64::NAN; base.values.len()];
        Ok(Self { values: missing.clone(), errors: missing, why: Some(why), step: 0.0 })
    }

    fn of(
        base: &Sample,
        [one, two]: [&Sample; 2],
        [h, noise]: [f64; 2],
        why: Option<NonSmooth>,
    ) -> Self {
        let triples = base.values.iter().zip(&one.values).zip(&two.values);
        let pair = |((f, one), two): ((&f64, &f64), &f64)| {
            let (near, far) = ((one - f) / h, (two - one) / h);
            let noise = noise * f.abs().max(one.abs()) / h.abs();
            let smooth = why.is_none();
            (if smooth { near + 0.5 * (near - far) } else { far }, (far - near).abs() + noise)
        };
        let (values, errors) = triples.map(pair).unzip();
        Self { values, errors, why, step: h.abs() }
    }
}

fn join(base: &Sample, below: Side, above: Side) -> Derivative {
    let (mut values, mut errors) = (Vec::new(), Vec::new());
    for k in 0..base.values.len() {
        let pair =
            |s: &Side| [s.values.get(k), s.errors.get(k)].map(|x| x.map_or(f64::NAN, |x| *x));
        let ([left, left_error], [right, right_error]) = (pair(&below), pair(&above));
        let (value, half_jump) = match (left.is_nan(), right.is_nan()) {
            (true, _) => (right, 0.0),
            (_, true) => (left, 0.0),
            _ => (0.5 * (left + right), 0.5 * (right - left).abs()),
        };
        values.push(value);
        errors.push(half_jump + left_error.max(right_error));
    }
    let step = below.step.max(above.step);
    let nonsmooth = [below.why, above.why].into_iter().flatten().collect();
    let (left, right) = (below.values, above.values);
    Derivative { values, errors, left, right, nonsmooth, reach: 0.0, step }
}

/// Least change of an argument that makes two successive events simultaneous, to first order. `slope` is the derivative
/// of the instant of each event.
pub(crate) fn reach(events: &[Record], slope: impl Fn(usize) -> f64) -> f64 {
    let pairs = events.windows(2).enumerate().map(|(k, pair)| {
        let interval = (pair[1].time - pair[0].time) + (pair[1].time_rest - pair[0].time_rest);
        let closing = slope(k) - slope(k + 1);
        if closing == 0.0 { f64::INFINITY } else { (interval / closing).abs() }
    });
    pairs.fold(f64::INFINITY, f64::min)
}
