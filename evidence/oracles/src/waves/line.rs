//! A delay line: a wave that enters one end of a bar leaves the other a transit later.

use std::collections::VecDeque;

/// One direction of one bar.
#[derive(Clone, Debug)]
pub enum Line {
    /// Undamped: the output is the input, step by step.
    Sharp(Sharp),
    /// Damped: the output is spread as Kelvin-Voigt damping spreads it.
    Spread(Spread),
}

impl Line {
    /// Sends a wave that is linear over a step.
    pub fn send(&mut self, time: f64, end: f64, first: f64, last: f64) {
        match self {
            Self::Sharp(line) => line.send(time, end, first, last),
            Self::Spread(line) => line.send(time, end, first, last),
        }
    }

    /// The output just after `time`.
    pub fn after(&self, time: f64) -> f64 {
        match self {
            Self::Sharp(line) => line.after(time),
            Self::Spread(line) => line.at(time, (line.cells(time) + ROUNDING).floor()),
        }
    }

    /// The output just before `time`.
    pub fn before(&self, time: f64) -> f64 {
        match self {
            Self::Sharp(line) => line.before(time),
            Self::Spread(line) => line.at(time, (line.cells(time) - ROUNDING).ceil() - 1.0),
        }
    }

    /// The input just after `time`, if it has not come out yet.
    ///
    /// # Panics
    /// If the line is damped, since the spread on the way is not stored.
    pub fn sent(&self, time: f64) -> f64 {
        match self {
            Self::Sharp(line) => line.sent(time),
            Self::Spread(_) => panic!("the inside of a damped bar"),
        }
    }
}

/// A wave that is linear over one step.
#[derive(Clone, Copy, Debug)]
struct Chord {
    start: f64,
    value: f64,
    slope: f64,
}

/// Waves on their way.
#[derive(Clone, Debug)]
pub struct Sharp {
    delay: f64,
    tiny: f64,
    chords: VecDeque<Chord>,
}

impl Sharp {
    /// A line whose input before time 0 was `value + slope t`.
    pub fn new(delay: f64, tiny: f64, [value, slope]: [f64; 2]) -> Self {
        let chord = Chord { start: f64::NEG_INFINITY, value, slope };
        Self { delay, tiny, chords: VecDeque::from([chord]) }
    }

    fn send(&mut self, time: f64, end: f64, first: f64, last: f64) {
        let slope = (last - first) / (end - time);
        self.chords.push_back(Chord { start: time, value: first, slope });
        let gone = time - self.delay - 4.0 * self.tiny;
        while self.chords.get(1).is_some_and(|next| next.start < gone) {
            self.chords.pop_front();
        }
    }

    fn after(&self, time: f64) -> f64 {
        self.sent(time - self.delay)
    }

    fn sent(&self, time: f64) -> f64 {
        self.at(time, self.chords.partition_point(|c| c.start <= time + self.tiny))
    }

    fn before(&self, time: f64) -> f64 {
        let sent = time - self.delay;
        self.at(sent, self.chords.partition_point(|c| c.start < sent - self.tiny))
    }

    fn at(&self, sent: f64, after: usize) -> f64 {
        let chord = self.chords[after.max(1) - 1];
        let origin = if chord.start.is_finite() { chord.start } else { 0.0 };
        chord.value + chord.slope * (sent - origin)
    }
}

/// Rounding of an instant, in cells: time is counted to some 1e8 of them.
const ROUNDING: f64 = 1e-6;
/// Width of the kernel, in standard deviations: beyond, 1e-7 of it is cut off.
const WIDTHS: f64 = 5.5;

/// Averages over cells of equal length. Kelvin-Voigt damping attenuates `exp(i w t)` by `exp(-beta w^2 T / 2)` over a
/// transit `T`, to first order in `beta w`. This is a convolution with a Gaussian of variance `beta T`. Averages keep
/// the wave's momentum, since the kernel's sum is one.
#[derive(Clone, Debug)]
pub struct Spread {
    cell: f64,
    transit: f64,
    kernel: Vec<f64>,
    /// Number of the first cell in each list.
    first: [f64; 2],
    sent: Vec<f64>,
    spread: Vec<f64>,
    /// Time integral over the current cell.
    partial: f64,
}

impl Spread {
    /// A line of `cells` cells of length `cell`, with a variance of `beta T`, whose input before time 0 was
    /// `value + slope t`.
    ///
    /// # Panics
    /// If the spread is wider than the bar.
    pub fn new(cells: usize, cell: f64, beta: f64, [value, slope]: [f64; 2]) -> Self {
        let variance = beta * cells as f64 / cell;
        let reach = (WIDTHS * variance.sqrt()).ceil() as usize;
        assert!(reach + 2 < cells, "the spread is wider than the bar");
        let weight = |j: usize| {
            let x = j as f64 - reach as f64;
            if x == 0.0 { 1.0 } else { (-0.5 * x * x / variance).exp() }
        };
        let mut kernel: Vec<f64> = (0..=2 * reach).map(weight).collect();
        let sum: f64 = kernel.iter().sum();
        kernel.iter_mut().for_each(|w| *w /= sum);
        let before = cells + 2 + 2 * reach;
        let average = |j: usize| value + slope * cell * (j as f64 + 0.5 - before as f64);
        let mut line = Self {
            cell,
            transit: cells as f64,
            kernel,
            first: [-(before as f64), (reach as f64) - before as f64],
            sent: Vec::new(),
            spread: Vec::new(),
            partial: 0.0,
        };
        for j in 0..before {
            line.push(average(j));
        }
        line
    }

    fn push(&mut self, average: f64) {
        self.sent.push(average);
        if let Some(from) = self.sent.len().checked_sub(self.kernel.len()) {
            let out = self.sent[from..].iter().zip(&self.kernel).map(|(x, w)| x * w).sum();
            self.spread.push(out);
        }
        self.forget();
    }

    /// Drops old cells, a few transits at a time.
    fn forget(&mut self) {
        let keep = 2 * (self.transit as usize + self.kernel.len());
        if self.sent.len() > 4 * keep {
            for (list, first) in [&mut self.sent, &mut self.spread].into_iter().zip(&mut self.first)
            {
                let gone = list.len() - keep;
                list.drain(..gone);
                *first += gone as f64;
            }
        }
    }

    fn send(&mut self, time: f64, end: f64, first: f64, last: f64) {
        self.partial += 0.5 * (first + last) * (end - time);
        let next = self.first[0] + self.sent.len() as f64 + 1.0;
        if end / self.cell >= next - ROUNDING {
            self.push(self.partial / self.cell);
            self.partial = 0.0;
        }
    }

    /// Number of cells that have been sent when the present output was sent.
    fn cells(&self, time: f64) -> f64 {
        time / self.cell - self.transit
    }

    /// Value within cell `index`, from its average and its neighbours'.
    fn at(&self, time: f64, index: f64) -> f64 {
        let (j, list) = ((index - self.first[1]) as usize, &self.spread);
        list[j] + 0.5 * (list[j + 1] - list[j - 1]) * (self.cells(time) - index - 0.5)
    }
}
