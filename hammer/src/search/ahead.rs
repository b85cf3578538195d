//! How a guard's watch strides ahead.

use crate::modal::system::System;
use crate::modal::track::Track;
use crate::search::signal::{Probe, Signal};
use crate::search::work::Work;

/// Below this part of a radian, a stride by curvature is worth less than a window. Chosen by the count
/// of work on the reference hammer; one of unequal bars (0.7 and 1.4 of its lengths, 14 and 27
/// elements) takes the least there too.
const SHORT_STRIDE: f64 = 0.025;

/// By how many tabulated lengths a stride that is proved from both ends is tried to be longer than one
/// proved from its start: twice as long.
const LEAP: usize = 2;

/// Strides for which a guard's bounds are taken to be as they were, which is safe for any number: they
/// only fall. Chosen by the count of work on the reference hammer; one of unequal bars takes a quarter
/// of a per cent more than its least.
pub(super) const TRUSTED: usize = 6;

/// What a watch knows ahead, and how far it may look.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// What comes after this instant is never asked for: another guard is known to cross there, s.
    pub end: f64,
    /// What comes after this instant is not asked for yet, s.
    pub until: f64,
    /// What is seen where its own track stands, if it is to stride on from there.
    pub seen: Option<Probe>,
    /// For how many strides its bounds have been taken to be as they were.
    pub age: usize,
    /// The track of its own that a guard of one track moves once it strides: no other guard moves it
    /// to where no tabulated stride ends.
    pub own: Option<Track>,
    /// Room for a modal vector.
    pub spare: Vec<f64>,
    /// Room for that of its own track.
    kept: Vec<f64>,
}

/// The tabulated length below a stride by curvature, and its level; none if a window is worth more.
#[inline]
pub(super) fn worthy(stride: f64, curvature: f64, amplitude: f64) -> Option<(usize, f64)> {
    let is_worth =
        amplitude == 0.0 || stride * stride * curvature > SHORT_STRIDE * SHORT_STRIDE * amplitude;
    System::level_below(stride).filter(|_| is_worth)
}

impl Ahead {
    pub fn new() -> Self {
        let (end, until) = (f64::INFINITY, f64::INFINITY);
        let (spare, kept) = (Vec::new(), Vec::new());
        Self { end, until, seen: None, age: 0, own: None, spare, kept }
    }

    /// Puts its own track for the one that all guards share, if it has one; until that is done again
    /// the shared one is kept here.
    #[inline]
    pub fn exchange(&mut self, shared: &mut Track) {
        if let Some(own) = &mut self.own {
            std::mem::swap(own, shared);
        }
    }

    /// From now on the track at hand is its own; the shared one is kept here as it is.
    #[inline]
    pub fn part_from(&mut self, shared: &Track) {
        if self.own.is_none() {
            let mut z = std::mem::take(&mut self.kept);
            z.clone_from(&shared.z);
            self.own = Some(Track { system: shared.system.clone(), z, at: shared.at });
        }
    }

    /// Knows nothing, and keeps the room that it has.
    #[inline]
    pub fn restart(&mut self) {
        if let Some(track) = self.own.take() {
            self.kept = track.z;
        }
        (self.end, self.until) = (f64::INFINITY, f64::INFINITY);
        (self.seen, self.age) = (None, 0);
    }

    /// Strides on from where the guard is seen, as long as nothing else is likely to be said than
    /// that it stays below `level`: it is below `far`, more than its amplitude is needed to know that
    /// it stays there, and it is not about to rise to zero. Most looks are such.
    ///
    /// A stride is proved from both its ends: the bound on the second derivative holds backwards
    /// too, and strides from both ends may meet. The next begins where it ends, and the first half of
    /// that is known from there. Bounds are taken as they were for some strides. Moves `clear`; returns
    /// whether it went on.
    pub fn stride_on(
        &mut self,
        signal: &Signal,
        [far, level]: [f64; 2],
        clear: &mut f64,
        work: &mut Work,
    ) -> bool {
        let ([Some(part), None], Some(mut here)) = (signal.parts, self.seen) else { return false };
        let (Some(track), longest) = (&mut self.own, signal.long()) else { return false };
        let Some((most, _)) = System::level_below(longest) else { return false };
        let sight = signal.sight(part, &track.system);
        let ([rise, fall], before) = (signal.drift.bends(0.0, longest), self.age);
        let mut stride = *clear - track.at;
        while self.age < TRUSTED && *clear < self.until {
            let m = here.curvature + rise;
            let is_plain = here.value < far && !signal.is_kept_below(level, here.amplitude);
            if !is_plain || here.rises_steeply(m + fall) {
                break;
            }
            let Some((short, _)) = worthy(stride, here.curvature, here.amplitude) else { break };
            self.age += 1;
            let known = (self.age < TRUSTED).then_some(&here);
            // A guard that is likely to cross before is not followed that far.
            let is_far = here.slope * System::tabulated(short + LEAP) > level - here.value;
            let mut step = (short + if is_far { LEAP / 2 } else { LEAP }).min(most);
            let (seen, length, onward) = loop {
                let seen = sight.look_ahead(track, step, known, &mut self.spare);
                work.count_look();
                let (length, room) = (System::tabulated(step), level - seen.value);
                let [back, onward] = strides_below(room, seen.slope, m);
                // Up to the shorter of both it is proved from the start alone.
                if step <= short || room >= 0.0 && stride + back >= length {
                    break (seen, length, onward);
                }
                step = short;
            };
            std::mem::swap(&mut track.z, &mut self.spare);
            track.at += length;
            here = seen;
            stride = if here.value >= far {
                0.0
            } else if onward > longest {
                longest
            } else {
                onward
            };
            *clear = track.at + stride;
        }
        self.seen = Some(here);
        self.age > before
    }
}

/// For how long a function that is `room` below a level was, and will be, below it: `m` bounds its
/// second derivative. Not numbers if it is above.
#[inline]
fn strides_below(room: f64, slope: f64, m: f64) -> [f64; 2] {
    let sum = slope.abs() + (slope * slope + 2.0 * m * room).sqrt();
    let (towards, away) = (2.0 * room / sum, if m > 0.0 { sum / m } else { f64::INFINITY });
    if slope >= 0.0 { [away, towards] } else { [towards, away] }
}
