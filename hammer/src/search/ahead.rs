//! Double steps of a guard's proof, confirmed from both ends.

use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::search::signal::{Probe, Signal};
use crate::search::work::Work;

/// Where double steps are shorter than this, in radians of the motion, a Taylor window gains more. This value needs
/// the least work on the reference hammer, and also on one with unequal bars (0.7 and 1.4 times its lengths, 14 and
/// 27 elements).
const SHORT_STEP: f64 = 0.025;

/// A double step is this many tabulated lengths beyond a single step, which is twice its length.
const DOUBLE_STEP: usize = 2;

/// Steps for which a guard's bounds are reused. Any number is safe, because bounds only fall. This value needs the
/// least work on the reference hammer, and within 0.25 % of the least on one with unequal bars.
pub(super) const TRUSTED: usize = 6;

/// How far a guard's proof is needed, and the state from which it continues.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// Nothing after this instant is needed, because another guard crosses here, s.
    pub end: f64,
    /// Nothing after this instant is needed yet, s.
    pub until: f64,
    /// The guard's value at its own track's instant, if the proof continues from there.
    pub probe: Option<Probe>,
    /// For how many steps its bounds have been reused.
    pub age: usize,
    /// A copy of the track, for a guard on one track. Other guards rotate the shared track to instants that are not a
    /// tabulated length away.
    pub own: Option<Track>,
    /// Storage for a modal vector.
    pub spare: Vec<f64>,
    /// Storage for the modal vector of its own track.
    buffer: Vec<f64>,
}

/// The level and the length of the tabulated step just below a step by curvature; none if a window gains more.
#[inline]
pub(super) fn worthy(step: f64, curvature: f64, amplitude: f64) -> Option<(usize, f64)> {
    let is_worth =
        amplitude == 0.0 || step * step * curvature > SHORT_STEP * SHORT_STEP * amplitude;
    Generator::level_below(step).filter(|_| is_worth)
}

impl Ahead {
    pub fn new() -> Self {
        let (end, until) = (f64::INFINITY, f64::INFINITY);
        let (spare, buffer) = (Vec::new(), Vec::new());
        Self { end, until, probe: None, age: 0, own: None, spare, buffer }
    }

    /// Swaps its own track, if it has one, with the shared one.
    #[inline]
    pub fn exchange(&mut self, shared: &mut Track) {
        if let Some(own) = &mut self.own {
            std::mem::swap(own, shared);
        }
    }

    /// Makes a copy of the shared track its own.
    #[inline]
    pub fn part_from(&mut self, shared: &Track) {
        if self.own.is_none() {
            let mut z = std::mem::take(&mut self.buffer);
            z.clone_from(&shared.z);
            self.own = Some(Track { system: shared.system.clone(), z, at: shared.at });
        }
    }

    /// Resets it; memory is reused.
    #[inline]
    pub fn restart(&mut self) {
        if let Some(track) = self.own.take() {
            self.buffer = track.z;
        }
        (self.end, self.until) = (f64::INFINITY, f64::INFINITY);
        (self.probe, self.age) = (None, 0);
    }

    /// Continues from the last probe as long as the guard is below `far`, is not about to rise to
    /// zero, and its amplitude alone does not prove that it stays below `level`.
    ///
    /// A double step is proved from both ends: the bound on the second derivative holds backwards
    /// too, so single steps from both ends may meet in the middle. The next double step starts
    /// where this one ends. Advances `clear`; returns whether it advanced.
    pub fn step_on(
        &mut self,
        signal: &Signal,
        [far, level]: [f64; 2],
        clear: &mut f64,
        work: &mut Work,
    ) -> bool {
        let ([Some(part), None], Some(mut here)) = (signal.parts, self.probe) else { return false };
        let (Some(track), longest) = (&mut self.own, signal.long()) else { return false };
        let Some((most, _)) = Generator::level_below(longest) else { return false };
        let view = signal.view(part, &track.system);
        let ([rise, fall], before) = (signal.drift.bends(0.0, longest), self.age);
        let mut step = *clear - track.at;
        while self.age < TRUSTED && *clear < self.until {
            let m = here.curvature + rise;
            let goes_on = here.value < far && !signal.stays_below(level, here.amplitude);
            if !goes_on || here.rises_steeply(m + fall) {
                break;
            }
            let Some((short, _)) = worthy(step, here.curvature, here.amplitude) else { break };
            // The bound from the end of a double step must hold there.
            if signal.ends_before(track.at + Generator::length(short + DOUBLE_STEP)) {
                break;
            }
            self.age += 1;
            let bounds = (self.age < TRUSTED).then_some(&here);
            // A guard that is likely to cross before the end of a double step takes a shorter one.
            let is_far = here.slope * Generator::length(short + DOUBLE_STEP) > level - here.value;
            let mut index = (short + if is_far { DOUBLE_STEP / 2 } else { DOUBLE_STEP }).min(most);
            let (next, length, onward) = loop {
                let next = view.evaluate_ahead(track, index, bounds, &mut self.spare);
                work.count_evaluation();
                let (length, room) = (Generator::length(index), level - next.value);
                let [back, onward] = steps_below(room, next.slope, m);
                // A single step needs no proof from its end.
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

/// For how long a function, now `room` below a level, stays below it, backwards and forwards, if `m` bounds its
/// second derivative; NaN if it is above the level.
#[inline]
fn steps_below(room: f64, slope: f64, m: f64) -> [f64; 2] {
    let sum = slope.abs() + (slope * slope + 2.0 * m * room).sqrt();
    let (towards, away) = (2.0 * room / sum, if m > 0.0 { sum / m } else { f64::INFINITY });
    if slope >= 0.0 { [away, towards] } else { [towards, away] }
}
