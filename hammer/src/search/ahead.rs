//! Double steps of a guard's proof, confirmed from both ends.

use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::search::signal::{Probe, Signal};
use crate::search::work::Work;

/// If double steps are shorter than this, in radians of the motion, a Taylor window advances further for the same work.
/// This value needs the least work on the reference hammer, and also on one with unequal bars (0.7 and 1.4 times its
/// lengths, 14 and 27 elements).
const SHORT_STEP: f64 = 0.025;

/// A double step is twice as long as a single one, and so this many levels above it in the table of rotations.
const DOUBLE_STEP: usize = 2;

/// Number of steps for which a guard's bounds are reused. Any number is safe, because the true bounds never rise. This
/// value needs the least work on the reference hammer; on one with unequal bars it needs 0.25 % more than the least.
pub(super) const TRUSTED: usize = 6;

/// How far a guard's proof is needed, and the state from which it continues.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// The proof is not needed after this instant, because another guard crosses there, s.
    pub end: f64,
    /// The proof is not yet needed after this instant, s.
    pub until: f64,
    /// The guard's value at the instant of its own track, if the proof continues from that instant.
    pub probe: Option<Probe>,
    /// Number of steps for which the probe's bounds have been reused.
    pub age: usize,
    /// For a guard on one track, its own copy of that track. Other guards rotate the shared track to instants from
    /// which no tabulated rotation leads to where this guard needs it.
    pub own: Option<Track>,
    /// Storage for a modal vector.
    pub spare: Vec<f64>,
    /// Storage for the modal vector of the guard's own track.
    buffer: Vec<f64>,
}

/// The level and the length of the longest tabulated rotation that is no longer than the step which curvature allows.
/// `None` if a window would advance further for the same work.
#[inline]
pub(super) fn worthy(step: f64, curvature: f64, amplitude: f64) -> Option<(usize, f64)> {
    let is_worthy =
        amplitude == 0.0 || step * step * curvature > SHORT_STEP * SHORT_STEP * amplitude;
    Generator::level_below(step).filter(|_| is_worthy)
}

impl Ahead {
    pub fn new() -> Self {
        let (end, until) = (f64::INFINITY, f64::INFINITY);
        let (spare, buffer) = (Vec::new(), Vec::new());
        Self { end, until, probe: None, age: 0, own: None, spare, buffer }
    }

    /// Swaps the guard's own track, if there is one, with the shared one.
    #[inline]
    pub fn exchange(&mut self, shared: &mut Track) {
        if let Some(own) = &mut self.own {
            std::mem::swap(own, shared);
        }
    }

    /// Makes the guard's own copy of the shared track, if there is none.
    #[inline]
    pub fn part_from(&mut self, shared: &Track) {
        if self.own.is_none() {
            let mut z = std::mem::take(&mut self.buffer);
            z.clone_from(&shared.z);
            self.own = Some(Track { system: shared.system.clone(), z, at: shared.at });
        }
    }

    /// Resets everything. Memory is reused.
    #[inline]
    pub fn restart(&mut self) {
        if let Some(track) = self.own.take() {
            self.buffer = track.z;
        }
        (self.end, self.until) = (f64::INFINITY, f64::INFINITY);
        (self.probe, self.age) = (None, 0);
    }

    /// Continues the proof from the last probe as long as the guard is below `far`, is not about to rise to zero, and
    /// cannot be proved to stay below `level` by its amplitude alone. Advances `clear`, and returns true if it
    /// advanced.
    ///
    /// A double step is proved from both ends: the bound on the second derivative also holds backwards, so single steps
    /// from the two ends may meet in the middle. The next double step starts where this one ends.
    pub fn step_on(
        &mut self,
        signal: &Signal,
        [far, level]: [f64; 2],
        clear: &mut f64,
        work: &mut Work,
    ) -> bool {
        let ([Some(part), None], Some(mut here)) = (signal.parts, self.probe) else { return false };
        let (Some(track), longest) = (&mut self.own, signal.long()) else { return false };
        let Some((highest, _)) = Generator::level_below(longest) else { return false };
        let view = signal.view(part, &track.system);
        let ([rise, fall], before) = (signal.drift.bends(0.0, longest), self.age);
        let mut step = *clear - track.at;
        while self.age < TRUSTED && *clear < self.until {
            let m = here.curvature + rise;
            let continues = here.value < far && !signal.stays_below(level, here.amplitude);
            if !continues || here.rises_steeply(m + fall) {
                break;
            }
            let Some((short, _)) = worthy(step, here.curvature, here.amplitude) else { break };
            // The drift must still be valid at the end of a double step.
            if signal.ends_before(track.at + Generator::length(short + DOUBLE_STEP)) {
                break;
            }
            self.age += 1;
            let bounds = (self.age < TRUSTED).then_some(&here);
            // A guard that is likely to cross before the end of a double step takes a shorter one.
            let may_cross =
                here.slope * Generator::length(short + DOUBLE_STEP) > level - here.value;
            let levels = if may_cross { DOUBLE_STEP / 2 } else { DOUBLE_STEP };
            let mut index = (short + levels).min(highest);
            let (next, length, onward) = loop {
                let next = view.evaluate_ahead(track, index, bounds, &mut self.spare);
                work.count_evaluation();
                let (length, room) = (Generator::length(index), level - next.value);
                let [back, onward] = steps_below(room, next.slope, m);
                // A single step is proved by its start alone.
                if index <= short || room >= 0.0 && step + back >= length {
                    break (next, length, onward);
                }
                index = short;
            };
            std::mem::swap(&mut track.z, &mut self.spare);
            track.at += length;
            here = next;
            step = if here.value >= far {
                0.0
            } else if onward > longest {
                longest
            } else {
                onward
            };
            *clear = track.at + step;
        }
        self.probe = Some(here);
        self.age > before
    }
}

/// For how long a function stays below a level, backwards and forwards, if it is now `room` below it and `m` bounds its
/// second derivative; NaN if it is above the level.
#[inline]
fn steps_below(room: f64, slope: f64, m: f64) -> [f64; 2] {
    let sum = slope.abs() + (slope * slope + 2.0 * m * room).sqrt();
    let (towards, away) = (2.0 * room / sum, if m > 0.0 { sum / m } else { f64::INFINITY });
    if slope >= 0.0 { [away, towards] } else { [towards, away] }
}
