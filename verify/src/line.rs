//! A delay line: a wave that enters one end of a bar leaves the other a transit later.

use std::collections::VecDeque;

/// What was sent during one step: a chord.
#[derive(Clone, Copy, Debug)]
struct Chord {
    start: f64,
    value: f64,
    slope: f64,
}

/// One direction of one bar.
#[derive(Clone, Debug)]
pub struct Line {
    delay: f64,
    tiny: f64,
    chords: VecDeque<Chord>,
}

impl Line {
    /// A line whose content, sent before time 0, is `value + slope t`.
    pub fn new(delay: f64, tiny: f64, value: f64, slope: f64) -> Self {
        let chord = Chord { start: f64::NEG_INFINITY, value, slope };
        Self { delay, tiny, chords: VecDeque::from([chord]) }
    }

    /// Sends a chord.
    pub fn send(&mut self, time: f64, end: f64, first: f64, last: f64) {
        let slope = (last - first) / (end - time);
        self.chords.push_back(Chord { start: time, value: first, slope });
        let gone = time - self.delay - 4.0 * self.tiny;
        while self.chords.get(1).is_some_and(|next| next.start < gone) {
            self.chords.pop_front();
        }
    }

    /// What comes out just after `time`.
    pub fn after(&self, time: f64) -> f64 {
        let sent = time - self.delay;
        self.at(sent, self.chords.partition_point(|c| c.start <= sent + self.tiny))
    }

    /// What comes out just before `time`.
    pub fn before(&self, time: f64) -> f64 {
        let sent = time - self.delay;
        self.at(sent, self.chords.partition_point(|c| c.start < sent - self.tiny))
    }

    fn at(&self, sent: f64, after: usize) -> f64 {
        let chord = self.chords[after.max(1) - 1];
        let origin = if chord.start.is_finite() { chord.start } else { 0.0 };
        chord.value + chord.slope * (sent - origin)
    }
}
