//! What drives the piston from outside, as a host hands it over: one value for each communication step.
//!
//! A host that holds a value over a step uses it late. `coupling.delay` `d` says how late: the value
//! belongs to an instant `d` steps before the middle of its step. Over step `n` of length `H` acts,
//! held,
//!
//! ```text
//! p_n + d (p_n - p_(n-1)) H_n / H_(n-1)
//! ```
//!
//! | at a step | acts over it |
//! |---|---|
//! | the first value | that value |
//! | a value repeated, or none set | the last value: there is nothing to extrapolate |
//! | a value set several times | the last of them |
//! | a value with derivatives | its polynomial, as given |
//! | after an early return, the same value or none | what acted before the return, as the same step goes on |
//! | after an early return, another value | that value: a step begins there, with a jump that counts as no error of the exchange |
//! | a step of size 0 | nothing moves; it counts as no step |
//!
//! `energy_exchange` is the work of what acted, less that of straight lines between the successive
//! values, each at its instant: what the exchange itself made or lost (the residual energy of a power bond).
//! No partner knows a value before its communication point, so for a delay below a half the instant is that; but a
//! line knows its wave ahead.
//! Within a step the piston counts as moving evenly.

use super::Machine;
use crate::error::Error;
use crate::numerics::display::DisplayNumber;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Drive, Source};
use serde::{Deserialize, Serialize};

/// Values of all inputs; those that do not drive are not used.
type Values = [f64; Input::ALL.len()];

/// A part of the drive's work, in a cycle of the piston, that an exchange may make unnoticed.
const TOLERATED: f64 = 0.01;
/// Most pieces that wait for the value to compare them with: with a delay of at most two steps, four wait.
const MOST: usize = 16;

/// A step under one value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Piece {
    /// From when until when, s.
    span: [f64; 2],
    /// The piston's relative position at both, m.
    place: [f64; 2],
    /// The force that acted, N, over time from the start.
    force: Poly,
}

impl Piece {
    fn speed(&self) -> f64 {
        (self.place[1] - self.place[0]) / (self.span[1] - self.span[0])
    }

    /// The work beyond that of a straight line of the force through two points (s, N), between them.
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

/// Sums since the start, and where the present cycle of the piston began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Cycle {
    /// Blows when it began.
    blows: u64,
    /// Cycles before it.
    count: u64,
    /// The drive's work and what the exchange has made by then, J.
    began: [f64; 2],
    /// The drive's largest work in it, J.
    most: f64,
    /// True where the piston has moved up last.
    rises: bool,
}

/// The state of the exchange.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Exchange {
    /// The value that was set last of each input, while it stays a constant.
    given: [Option<f64>; Input::ALL.len()],
    /// Begin and end of the last step, s, and the values at its begin.
    last: Option<([f64; 2], Values)>,
    /// The instant to which the last values belong, s, and the force that they are, N.
    point: Option<[f64; 2]>,
    pieces: Vec<Piece>,
    /// The drive's work and what the exchange has made, J.
    sums: [f64; 2],
    cycle: Cycle,
    /// The size of the step in which too much was made, s, and the part of the drive's work.
    coarse: Option<[f64; 2]>,
}

impl Drive {
    /// The force of these values of its inputs, N.
    fn of_values(&self, values: &Values) -> f64 {
        Input::ALL.iter().zip(values).fold(0.0, |sum, (input, x)| sum + self.force_per(*input) * x)
    }
}

impl Exchange {
    /// With the inputs' values at the start.
    pub(crate) fn new(inputs: &Inputs) -> Self {
        Self { given: inputs.0.map(|poly| Some(poly.0[0])), ..Self::default() }
    }

    /// Notes what is set; true if it is what was set before, and may act on as it does.
    pub(crate) fn repeats(&mut self, input: Input, poly: &Poly) -> bool {
        let given = &mut self.given[input as usize];
        let before = *given;
        *given = poly.is_constant().then_some(poly.0[0]);
        input.drives() && before.is_some() && *given == before
    }

    /// The value that was set last, if it stays.
    pub(crate) fn value(&self, input: Input) -> Option<f64> {
        self.given[input as usize].filter(|_| input.drives())
    }

    /// A constant was added to an input.
    pub(crate) fn shift(&mut self, input: Input, by: f64) {
        self.given[input as usize].iter_mut().for_each(|value| *value += by);
    }

    /// Checked because a stored state may be corrupt.
    pub(crate) fn is_sound(&self) -> bool {
        let last = self.last.iter().flat_map(|(span, values)| span.iter().chain(values));
        let pieces =
            self.pieces.iter().flat_map(|p| p.span.iter().chain(&p.place).chain(&p.force.0));
        let numbers = last.chain(pieces).chain(self.point.iter().flatten());
        let sums = self.sums.iter().chain(&self.cycle.began).chain([&self.cycle.most]);
        let numbers = numbers.chain(sums).chain(self.coarse.iter().flatten());
        numbers.chain(self.given.iter().flatten()).all(|x| x.is_finite())
            && self.pieces.iter().all(|piece| piece.span[0] < piece.span[1])
            && self.pieces.len() <= MOST
    }

    /// Adds what lies between the point before and this one.
    fn compare(&mut self, point: [f64; 2]) {
        let Some(before) = self.point.filter(|before| before[0] < point[0]) else {
            self.point = self.point.or(Some(point));
            return;
        };
        let made = self.pieces.iter().map(|piece| piece.beyond([before, point]));
        self.sums[1] += made.sum::<f64>();
        self.pieces.retain(|piece| piece.span[1] > point[0]);
        self.point = Some(point);
    }

    /// Adds a piece, and looks at the cycle that it may end.
    fn add(&mut self, piece: Piece, blows: u64) {
        let turned = self.cycle.rises && piece.speed() > 0.0;
        self.cycle.rises = piece.speed() < 0.0 || self.cycle.rises && !turned;
        let length = piece.span[1] - piece.span[0];
        self.sums[0] += piece.speed() * piece.force.integral(length);
        match self.pieces.last_mut() {
            // The same step goes on after an early return.
            Some(last) if self.last.is_some_and(|([begin, _], _)| begin < piece.span[0]) => {
                (last.span[1], last.place[1]) = (piece.span[1], piece.place[1]);
            }
            _ => self.pieces.push(piece),
        }
        if self.pieces.len() > MOST {
            self.pieces.remove(0);
        }
        let [work, made] = [0, 1].map(|k| self.sums[k] - self.cycle.began[k]);
        self.cycle.most = self.cycle.most.max(work.abs());
        if blows == self.cycle.blows && (blows > 0 || !turned) {
            return;
        }
        // The first cycle is not whole.
        if self.cycle.count > 0 && self.coarse.is_none() && made.abs() > TOLERATED * self.cycle.most
        {
            self.coarse = Some([length, made / self.cycle.most]);
        }
        let count = self.cycle.count + 1;
        self.cycle = Cycle { blows, count, began: self.sums, most: 0.0, ..self.cycle };
    }

    /// True within a step that has begun, which an event or an interrupt has ended early.
    fn goes_on(&self, now: f64) -> bool {
        self.last.is_some_and(|([begin, end], _)| (begin..end).contains(&now))
    }
}

impl Machine {
    /// Energy that the exchange of the drive's inputs has made (positive) or lost since the start, as far as
    /// their values have come, J.
    pub fn exchanged_energy(&self) -> f64 {
        self.exchange.sums[1]
    }

    /// What is said once the exchange has made or lost more than 1 % of the drive's work of a blow.
    pub fn exchange_warning(&self) -> Option<String> {
        let [size, part] = self.exchange.coarse?;
        let delay = self.parameters().drive.delay;
        let remedy = match delay {
            0.0 => {
                "set coupling.delay (0.5 where the host steps this unit before its partner, 1.5 where it \
                    steps all at once and the partner reads positions, 1 where it reads flows), or halve the step"
            }
            _ => "halve the step, or see whether coupling.delay is the host's (0.5, 1 or 1.5)",
        };
        // Steps are differences of instants.
        let size = format!("{size:.5e}").parse().unwrap_or(size);
        Some(format!(
            "energy_exchange: at steps of {} s with coupling.delay = {} the exchange of the drive's inputs has \
             {} {:.2} % of the drive's work of a blow: {remedy}",
            DisplayNumber(size),
            DisplayNumber(delay),
            if part > 0.0 { "added" } else { "taken" },
            100.0 * part.abs(),
        ))
    }

    /// Begins a communication step: puts on the piston what belongs to its middle. Returns the piston's
    /// relative position, if the step is to be looked at.
    pub(super) fn begin_exchange(&mut self, to: f64) -> Result<Option<f64>, Error> {
        let (now, drive) = (self.time(), self.parameters().drive);
        if !matches!(drive.source, Source::Force | Source::Pressure) || to <= now {
            return Ok(None);
        }
        let values = Input::ALL.map(|input| self.input(input));
        let (goes_on, size, before) = (self.exchange.goes_on(now), to - now, self.exchange.last);
        let changed = before.is_none_or(|(_, before)| before != values);
        if goes_on && !changed {
            return Ok(Some(self.relative_place()));
        }
        if goes_on {
            // A jump, as a valve makes one where the step ended: no straight line leads to it.
            self.exchange.pieces.clear();
            self.exchange.point = None;
        }
        if let Some(([begin, _], before)) = before.filter(|_| !goes_on && drive.delay > 0.0) {
            let ahead = drive.delay * size / (now - begin);
            let mut middle = values;
            middle.iter_mut().zip(before).for_each(|(x, before)| *x += ahead * (*x - before));
            self.extrapolate(&middle)?;
        }
        if drive.impedance > 0.0 {
            // A line's wave is known before: the middle of a step is looked at when the step is over.
            if let Some(([begin, end], before)) = before {
                let instant = begin + (0.5 - drive.delay) * (end - begin);
                self.exchange.compare([instant, drive.of_values(&before)]);
            }
        } else {
            let instant = now + (0.5 - drive.delay.max(0.5)) * size;
            self.exchange.compare([instant, drive.of_values(&values)]);
        }
        self.exchange.last = Some(([now, to], values));
        Ok(Some(self.relative_place()))
    }

    /// Puts on the piston other values than were given, of those inputs that are constants.
    fn extrapolate(&mut self, values: &Values) -> Result<(), Error> {
        let mut polys = Vec::new();
        for input in Input::ALL {
            let read = self.parameters().drive.force_per(input) != 0.0;
            if read && self.exchange.value(input).is_some() {
                let poly =
                    input.polynomial(&[values[input as usize]]).map_err(Error::of_input(input))?;
                let state = self.motion.state();
                if state.inputs.of(input).shifted(state.now) != poly {
                    polys.push((input, poly));
                }
            }
        }
        if polys.is_empty() { Ok(()) } else { self.put(&polys) }
    }

    fn relative_place(&self) -> f64 {
        self.kinematics().relative_position
    }

    /// Ends what [`Self::begin_exchange`] began at `from`: with where the piston stood, and what acted.
    pub(super) fn end_exchange(&mut self, from: f64, begun: Option<(f64, Poly)>) {
        let to = self.time();
        let Some((place, force)) = begun.filter(|_| to > from) else { return };
        let piece = Piece { span: [from, to], place: [place, self.relative_place()], force };
        self.exchange.add(piece, self.counters.blows);
    }

    /// The force of the drive's inputs over time from now on, N.
    pub(super) fn handed_force(&self) -> Poly {
        let (state, drive) = (self.motion.state(), self.parameters().drive);
        let mut sum = Poly::default();
        for input in Input::ALL {
            sum = sum.plus(drive.force_per(input), &state.inputs.of(input).shifted(state.now));
        }
        sum
    }
}
