//! The inputs that drive the piston, exchanged with a host as one value for each communication step.
//!
//! A host that holds a value over a step uses it late, by `coupling.delay` `d`: the value belongs to an instant `d`
//! steps before the middle of its step. The value that acts over step `n` of length `H` is therefore extrapolated:
//!
//! ```text
//! p_n + d (p_n - p_(n-1)) H_n / H_(n-1)
//! ```
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
//! `energy_exchange` is the work of the force that acted, less the work of a force that joins the successive values
//! by straight lines, each value at its instant. It is the energy that the exchange made or lost (the residual energy
//! of a power bond). No partner knows a value before its communication point, so for a delay below a half the value's
//! instant is that point; but the wave of a line is known in advance. Within a step the piston is taken to move at
//! constant speed.

use super::Machine;
use crate::error::Error;
use crate::numerics::display::DisplayNumber;
use crate::numerics::poly::Poly;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Drive, Source};
use serde::{Deserialize, Serialize};

/// Values of all inputs, including those that are not used.
type Values = [f64; Input::ALL.len()];

/// Share of the drive's work in a cycle of the piston that the exchange may make or lose without a warning.
const TOLERATED: f64 = 0.01;
/// Most pieces that wait for the next value: with a delay of at most two steps, four.
const MOST: usize = 16;

/// The force over a step, or over a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Piece {
    /// Start and end, s.
    span: [f64; 2],
    /// The piston's relative positions then, m.
    place: [f64; 2],
    /// The force that acted, N, over time from the start.
    force: Poly,
}

impl Piece {
    fn speed(&self) -> f64 {
        (self.place[1] - self.place[0]) / (self.span[1] - self.span[0])
    }

    /// The work of the force, less that of a straight line through two points (s, N), between these.
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

/// Sums since the start, and the start of the present cycle of the piston.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Cycle {
    /// Number of blows when it began.
    blows: u64,
    /// Number of complete cycles.
    count: u64,
    /// The drive's work and the exchanged energy at its start, J.
    began: [f64; 2],
    /// Largest size of the drive's work in it, J.
    most: f64,
    /// True if the piston's last motion was upward.
    rises: bool,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Exchange {
    /// Last value set of each input, if it is a constant.
    given: [Option<f64>; Input::ALL.len()],
    /// Start and end of the last step, s, and the values at its start.
    last: Option<([f64; 2], Values)>,
    /// Instant of the last values, s, and their force, N.
    point: Option<[f64; 2]>,
    pieces: Vec<Piece>,
    /// The drive's work and the exchanged energy, J.
    sums: [f64; 2],
    cycle: Cycle,
    /// Size of the first step whose exchange made too much, s, and its share of the drive's work.
    coarse: Option<[f64; 2]>,
}

impl Drive {
    /// Force of these values, N.
    fn of_values(&self, values: &Values) -> f64 {
        Input::ALL.iter().zip(values).fold(0.0, |sum, (input, x)| sum + self.force_per(*input) * x)
    }
}

impl Exchange {
    /// The exchange before the first step, with the inputs' start values.
    pub(crate) fn new(inputs: &Inputs) -> Self {
        Self { given: inputs.0.map(|poly| Some(poly.0[0])), ..Self::default() }
    }

    /// Records an input. Returns true if it is the value set before, which may continue to act as it does.
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

    /// Adds a constant to the last value of an input.
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

    /// Compares the pieces between the previous point and this one with a straight line, and sums the difference.
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

    /// Adds a piece, and evaluates the cycle if the piece ends one.
    fn add(&mut self, piece: Piece, blows: u64) {
        let turned = self.cycle.rises && piece.speed() > 0.0;
        self.cycle.rises = piece.speed() < 0.0 || self.cycle.rises && !turned;
        let length = piece.span[1] - piece.span[0];
        self.sums[0] += piece.speed() * piece.force.integral(length);
        match self.pieces.last_mut() {
            // After an early return the same step continues.
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
        // The first cycle is incomplete.
        if self.cycle.count > 0 && self.coarse.is_none() && made.abs() > TOLERATED * self.cycle.most
        {
            self.coarse = Some([length, made / self.cycle.most]);
        }
        let count = self.cycle.count + 1;
        self.cycle = Cycle { blows, count, began: self.sums, most: 0.0, ..self.cycle };
    }

    /// True within a step that an event or an interrupt has ended early.
    fn goes_on(&self, now: f64) -> bool {
        self.last.is_some_and(|([begin, end], _)| (begin..end).contains(&now))
    }
}

impl Machine {
    /// Energy that the exchange of the drive's inputs has made (positive) or lost since the start, up to the last
    /// values, J.
    pub fn exchanged_energy(&self) -> f64 {
        self.exchange.sums[1]
    }

    /// The warning after the exchange has made or lost more than 1 % of the drive's work of a cycle.
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
        // The size is a difference of instants, and so rounded.
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

    /// Begins a communication step: replaces the inputs by the values that belong to its middle. Returns the piston's
    /// relative position and the force from now on if the step's work is compared.
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
            // A jump, as a valve makes it after an event: no straight line joins it to the last value.
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
            // The wave of a line is known in advance, so the step is compared after its end.
            if let Some(([begin, end], before)) = before {
                let instant = begin + (0.5 - drive.delay) * (end - begin);
                self.exchange.compare([instant, drive.of_values(&before)]);
            }
        } else {
            let instant = now + (0.5 - drive.delay.max(0.5)) * size;
            self.exchange.compare([instant, drive.of_values(&values)]);
        }
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
        self.exchange.add(Piece { span: [from, to], place, force }, self.history.counters.blows);
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
