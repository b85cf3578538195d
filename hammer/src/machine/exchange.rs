//! The inputs that drive the piston, exchanged with a host as one value for each communication step.
//!
//! A value that a host sets for the step from `t_n` belongs to the instant `tau_n`, whose fractional index among the
//! communication points is `n + 0.5 - d`; `d` is `coupling.delay`. The value that acts over the step to `t_(n+1)` is
//!
//! ```text
//! p_n + (m - tau_n) (p_n - p_b) / (tau_n - tau_b),    m = (t_n + t_(n+1)) / 2
//! ```
//!
//! where `b` is the latest of the last four values for which `|m - tau_n| <= 4 (tau_n - tau_b)`. If there is none,
//! `p_n` acts. With steps of equal size the formula is `p_n + d (p_n - p_(n-1))`.
//!
//! | host sets | acts over the step |
//! |---|---|
//! | the first value | that value |
//! | the same value, or none | the last value: there is nothing to extrapolate |
//! | several values | the last of them |
//! | a value with derivatives | its polynomial, as given |
//! | after an early return, the same value or none | what acted before the return: the same step continues |
//! | after an early return, another value | that value: a new step begins with a jump, which is not counted as an error of the exchange |
//! | any value, with a step of size 0 | nothing moves; it does not count as a step |
//!
//! `energy_exchange` is the work of the force that acted, minus the work of a force that joins the successive values by
//! straight lines. It is the energy that the exchange created or lost (the residual energy of a power bond). Each value
//! is placed at `tau_n`, or at the start of the step if the delay is 0 or the value has derivatives; the wave of a line
//! without derivatives is always placed at `tau_n`. The piston is assumed to move at constant speed within a step, so
//! `energy_exchange` is 0 for a delay of -0.5.

use super::Machine;
use crate::error::Error;
use crate::numerics::display::DisplayNumber;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Drive, Source};
use serde::{Deserialize, Serialize};

/// Values of all inputs, including those that are not used.
type Values = [f64; Input::ALL.len()];

/// Largest energy that the exchange may create or lose in a cycle without a warning, as a share of the largest work of
/// the drive in a cycle.
const TOLERATED: f64 = 0.01;
/// A cycle is judged only if the drive's work in it is at least this share of the largest so far.
const LEAST: f64 = 0.1;
/// Before the first blow, this many turns of the piston count as a cycle.
const TURNS: u32 = 8;
/// Number of values that are stored for the line, and how far it is extended beyond the last value, in multiples of the
/// distance between the two. For steps that vary by half this is 3.5. Without a limit, a step of 1 ns before one of 1
/// ms would multiply the partner's noise by a million.
const KEPT: usize = 4;
const FURTHEST: f64 = 4.0;
/// Most pieces that wait for the next value; a delay of at most two steps leaves four.
const MOST: usize = 16;

/// The force over a step, or over a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Piece {
    /// Start and end, s.
    span: [f64; 2],
    /// The piston's relative positions at the start and the end, m.
    place: [f64; 2],
    /// The force that acted, N, over time from the start.
    force: Poly,
}

impl Piece {
    fn speed(&self) -> f64 {
        (self.place[1] - self.place[0]) / (self.span[1] - self.span[0])
    }

    /// The work of the force minus that of a straight line through two points (s, N), over the time between these
    /// points.
    fn beyond(&self, [from, to]: [[f64; 2]; 2]) -> f64 {
        let [begin, end] = [self.span[0].max(from[0]), self.span[1].min(to[0])];
        if end <= begin {
            return 0.0;
        }
        let line = |t: f64| from[1] + (to[1] - from[1]) * ((t - from[0]) / (to[0] - from[0]));
        let [a, b] = [begin, end].map(|t| self.force.integral(t - self.span[0]));
        let acted = if self.force.is_constant() { self.force.0[0] * (end - begin) } else { b - a };
        self.speed() * (acted - f64::midpoint(line(begin), line(end)) * (end - begin))
    }
}

/// The values of a step, and the instant to which they belong, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Sample {
    instant: f64,
    values: Values,
}

/// Sums since the start, and the start of the present cycle of the piston.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Cycle {
    /// Number of blows when the cycle began.
    blows: u64,
    /// Number of complete cycles.
    count: u64,
    /// The drive's work and the exchanged energy when the cycle began, J.
    began: [f64; 2],
    /// Largest magnitude of the drive's work in the cycle, J.
    most: f64,
    /// The largest `most` of all cycles so far, J.
    largest: f64,
    /// Turns of the piston since the cycle began. They count if no blow ends the cycle.
    turns: u32,
    /// True if the piston's last motion was upward.
    rises: bool,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Exchange {
    /// The last value that was set for each input, if it is a constant.
    given: [Option<f64>; Input::ALL.len()],
    /// Start and end of the last step, s, and the values at its start.
    last: Option<([f64; 2], Values)>,
    /// Start of the step before the last, s.
    earlier: Option<f64>,
    /// The last values, in order of time.
    samples: Vec<Sample>,
    /// Instant of the last values that the motion has passed, s, and the force of these values, N.
    point: Option<[f64; 2]>,
    /// The same for values whose instant the present step has not yet passed.
    ahead: Option<[f64; 2]>,
    pieces: Vec<Piece>,
    /// The drive's work and the exchanged energy, J.
    sums: [f64; 2],
    cycle: Cycle,
    /// The piston's mean speed over the last step, m/s.
    speed: f64,
    /// Number of times that the exchange created or lost too much energy; for the last time: the size of the step, s,
    /// the share of the drive's work, and the delay.
    excesses: u32,
    excess: [f64; 3],
}

impl Drive {
    /// The force that these values cause, N.
    fn of_values(&self, values: &Values) -> f64 {
        Input::ALL.iter().zip(values).fold(0.0, |sum, (input, x)| sum + self.force_per(*input) * x)
    }
}

impl Exchange {
    /// The exchange before the first step, with the inputs' start values.
    pub(crate) fn new(inputs: &Inputs) -> Self {
        Self { given: inputs.0.map(|poly| Some(poly.0[0])), ..Self::default() }
    }

    /// Records an input. Returns true if it has the value that was set before, so that whatever acts now may continue.
    pub(crate) fn repeats(&mut self, input: Input, poly: &Poly) -> bool {
        let given = &mut self.given[input as usize];
        let before = *given;
        *given = poly.is_constant().then_some(poly.0[0]);
        input.drives() && before.is_some() && *given == before
    }

    /// The value that was set last, if it is a constant.
    pub(crate) fn value(&self, input: Input) -> Option<f64> {
        self.given[input as usize].filter(|_| input.drives())
    }

    /// Adds a constant to the last value of an input.
    pub(crate) fn shift(&mut self, input: Input, by: f64) {
        self.given[input as usize].iter_mut().for_each(|value| *value += by);
    }

    /// True if the numbers are possible. This is checked because a stored state may be corrupt.
    pub(crate) fn is_sound(&self) -> bool {
        let last = self.last.iter().flat_map(|(span, values)| span.iter().chain(values));
        let pieces =
            self.pieces.iter().flat_map(|p| p.span.iter().chain(&p.place).chain(&p.force.0));
        let samples = self.samples.iter().flat_map(|s| s.values.iter().chain([&s.instant]));
        let points = self.point.iter().chain(&self.ahead).flatten().chain(&self.earlier);
        let numbers = last.chain(pieces).chain(points).chain(samples);
        let cycle = self.cycle.began.iter().chain([&self.cycle.most, &self.cycle.largest]);
        let sums = self.sums.iter().chain(cycle);
        let numbers = numbers.chain(sums).chain(&self.excess).chain([&self.speed]);
        numbers.chain(self.given.iter().flatten()).all(|x| x.is_finite())
            && self.pieces.iter().all(|piece| piece.span[0] < piece.span[1])
            && self.pieces.len() <= MOST
            && self.samples.len() <= KEPT
    }

    /// Compares the pieces between the previous point and this one with a straight line, and sums the difference.
    fn compare(&mut self, point: [f64; 2]) {
        let Some(before) = self.point.filter(|before| before[0] < point[0]) else {
            // Of several values for one instant, the last one counts.
            self.point = self.point.filter(|before| before[0] > point[0]).or(Some(point));
            return;
        };
        let made = self.pieces.iter().map(|piece| piece.beyond([before, point]));
        self.sums[1] += made.sum::<f64>();
        self.pieces.retain(|piece| piece.span[1] > point[0]);
        self.point = Some(point);
    }

    /// Adds a piece, and evaluates the cycle if the piece ends one.
    fn add(&mut self, piece: Piece, blows: u64, delay: f64) {
        self.speed = piece.speed();
        let turned = self.cycle.rises && piece.speed() > 0.0;
        self.cycle.rises = piece.speed() < 0.0 || self.cycle.rises && !turned;
        let length = piece.span[1] - piece.span[0];
        self.sums[0] += piece.speed() * piece.force.integral(length);
        match self.pieces.last_mut() {
            // After an early return, the same step continues.
            Some(last) if self.last.is_some_and(|([begin, _], _)| begin < piece.span[0]) => {
                (last.span[1], last.place[1]) = (piece.span[1], piece.place[1]);
            }
            _ => self.pieces.push(piece),
        }
        if self.pieces.len() > MOST {
            self.pieces.remove(0);
        }
        if let Some(point) = self.ahead.take_if(|point| point[0] <= piece.span[1]) {
            self.compare(point);
        }
        let [work, made] = [0, 1].map(|k| self.sums[k] - self.cycle.began[k]);
        self.cycle.most = self.cycle.most.max(work.abs());
        self.cycle.turns += u32::from(turned);
        if blows == self.cycle.blows && (blows > 0 || self.cycle.turns < TURNS) {
            return;
        }
        let largest = self.cycle.largest.max(self.cycle.most);
        let share = made / largest;
        // The cycle before the first blow is incomplete, and a cycle with little work is not representative.
        let complete = self.cycle.count > 0 || blows == 0;
        let threshold = if self.excesses > 0 { 2.0 * self.excess[1].abs() } else { TOLERATED };
        if complete && self.cycle.most >= LEAST * largest && share.abs() > threshold {
            self.excesses = self.excesses.saturating_add(1);
            self.excess = [length, share, delay];
        }
        let count = self.cycle.count + 1;
        let (began, rises) = (self.sums, self.cycle.rises);
        self.cycle = Cycle { blows, count, began, most: 0.0, largest, turns: 0, rises };
    }

    /// The piston's mean speed over the last step, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// The instant to which the values of a step belong. Its fractional index among the communication points is `n +
    /// 0.5 - delay`, where `n` is that of the step's start. Steps before the first are assumed to have its size.
    fn instant(&self, [now, to]: [f64; 2], delay: f64) -> f64 {
        let size = to - now;
        let begin = self.last.map(|([begin, _], _)| begin);
        let before = begin.map_or(size, |begin| now - begin);
        let earlier = begin.zip(self.earlier).map_or(before, |(begin, earlier)| begin - earlier);
        match 0.5 - delay {
            index if index >= 0.0 => (now + index * size).min(to),
            index if index >= -1.0 => now + index * before,
            index => now - before + (index + 1.0) * earlier,
        }
    }

    /// Records the present values, and extrapolates to an instant: along the line through them and the latest earlier
    /// values that are far enough away. `None` if there are no such values.
    fn line(&mut self, last: Sample, at: f64) -> Option<Values> {
        // Earlier values may belong to later instants after a change of the delay, or after an early return from a step
        // whose value belonged to its end.
        let lever = |base: &Sample| {
            let distance = last.instant - base.instant;
            let reached = distance > 0.0 && (at - last.instant).abs() <= FURTHEST * distance;
            reached.then(|| ((at - last.instant) / distance, base.values))
        };
        let line = self.samples.iter().rev().find_map(lever);
        if self.samples.len() == KEPT {
            self.samples.remove(0);
        }
        self.samples.push(last);
        let (lever, before) = line?;
        let mut values = last.values;
        values.iter_mut().zip(before).for_each(|(x, before)| *x += lever * (*x - before));
        Some(values)
    }

    /// True within a step that an event or an interrupt has ended early.
    fn goes_on(&self, now: f64) -> bool {
        self.last.is_some_and(|([begin, end], _)| (begin..end).contains(&now))
    }
}

impl Machine {
    /// Energy that the exchange of the drive's inputs has created (positive) or lost since the start, up to the last
    /// values, J.
    pub fn exchanged_energy(&self) -> f64 {
        self.exchange.sums[1]
    }

    /// Number of warnings so far. There is one when the exchange creates or loses more than 1 % of the drive's work of
    /// a blow, and again each time the share exceeds twice that of the last warning.
    pub fn exchange_excesses(&self) -> u32 {
        self.exchange.excesses
    }

    /// The last of these warnings.
    pub fn exchange_warning(&self) -> Option<String> {
        if self.exchange.excesses == 0 {
            return None;
        }
        let [size, share, delay] = self.exchange.excess;
        let wave = self.parameters().drive.impedance > 0.0;
        let caveat = if delay == 0.0 && !wave {
            ", if its values belong to the step's begin (of a host that steps all at once two to four times that; of a \
             partner that holds a flow, or that is stepped first, less)"
        } else {
            ""
        };
        let meant = if wave {
            "0 for the wave of a line"
        } else {
            "0.5 if the partner goes to the position at the step's begin or differences volumes, 0 if it holds a flow, \
             -0.5 if it looks ahead"
        };
        // The size is a difference of instants, and therefore rounded.
        let size = format!("{size:.5e}").parse().unwrap_or(size);
        Some(format!(
            "energy_exchange: at steps of {} s with coupling.delay = {} the exchange of the drive's inputs has {} \
             {:.2} % of the drive's work of a blow{caveat}: set coupling.delay ({meant}; plus 1 in a host that steps \
             all at once), or halve the step",
            DisplayNumber(size),
            DisplayNumber(delay),
            if share > 0.0 { "added" } else { "taken" },
            100.0 * share.abs(),
        ))
    }

    /// Begins a communication step: replaces the inputs by the values that belong to its middle. If the step's work is
    /// compared, returns the piston's relative position and the force from now on.
    pub(super) fn begin_exchange(&mut self, to: f64) -> Result<Option<(f64, Poly)>, Error> {
        let (now, drive) = (self.time(), self.parameters().drive);
        if !matches!(drive.source, Source::Force | Source::Pressure) || to <= now {
            return Ok(None);
        }
        let values = Input::ALL.map(|input| self.input(input));
        let (goes_on, size, before) = (self.exchange.goes_on(now), to - now, self.exchange.last);
        let changed = before.is_none_or(|(_, before)| before != values);
        if goes_on && !changed {
            return Ok(Some(self.begun()));
        }
        if goes_on {
            // This is a jump, as after a valve has switched: no straight line joins it to the last value.
            self.exchange.pieces.clear();
            (self.exchange.point, self.exchange.ahead) = (None, None);
            self.exchange.samples.clear();
        }
        let instant = self.exchange.instant([now, to], drive.delay);
        if drive.delay != 0.0 {
            let middle = self.exchange.line(Sample { instant, values }, now + 0.5 * size);
            if let Some(middle) = middle {
                self.extrapolate(&middle)?;
            }
        }
        let varies = |x: &Input| drive.force_per(*x) != 0.0 && self.exchange.value(*x).is_none();
        let varies = Input::ALL.iter().any(varies);
        let held = drive.delay == 0.0 && drive.impedance == 0.0;
        let instant = if varies || held { now } else { instant };
        self.exchange.ahead = Some([instant, drive.of_values(&values)]);
        if let Some(point) = self.exchange.ahead.take_if(|point| point[0] <= now) {
            self.exchange.compare(point);
        }
        self.exchange.earlier = before.map(|([begin, _], _)| begin);
        self.exchange.last = Some(([now, to], values));
        Ok(Some(self.begun()))
    }

    /// Replaces the constant inputs by extrapolated values.
    fn extrapolate(&mut self, values: &Values) -> Result<(), Error> {
        let mut polys = Vec::new();
        for input in Input::ALL {
            let read = self.parameters().drive.force_per(input) != 0.0;
            if read && self.exchange.value(input).is_some() {
                let (value, source) = (values[input as usize], self.parameters().drive.source);
                let poly = input.polynomial(&[value], source).map_err(Error::of_input(input))?;
                let state = &self.motion.state;
                if state.inputs.of(input).shifted(state.now) != poly {
                    polys.push((input, poly));
                }
            }
        }
        if polys.is_empty() { Ok(()) } else { self.put(&polys) }
    }

    /// Ends the step that [`Self::begin_exchange`] began at `from`, with the piston's position then and the force
    /// that acted.
    pub(super) fn end_exchange(&mut self, from: f64, begun: Option<(f64, Poly)>) {
        let to = self.time();
        let Some((place, force)) = begun.filter(|_| to > from) else { return };
        let place = [place, self.kinematics().relative.displacement];
        let (delay, blows) = (self.parameters().drive.delay, self.history.counters.blows);
        self.exchange.add(Piece { span: [from, to], place, force }, blows, delay);
    }

    /// The piston's relative position, m, and the force of the drive's inputs from now on, N.
    fn begun(&self) -> (f64, Poly) {
        let (state, drive) = (&self.motion.state, self.parameters().drive);
        let force = Input::ALL.into_iter().fold(Poly::default(), |sum, input| {
            sum.plus(drive.force_per(input), &state.inputs.of(input).shifted(state.now))
        });
        (self.kinematics().relative.displacement, force)
    }
}
