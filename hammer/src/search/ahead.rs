//! How a guard's watch looks ahead of its proof.

use crate::modal::system::System;
use crate::modal::track::Track;
use crate::search::signal::{Part, Probe, Signal};
use crate::search::window::stride_below;
use crate::search::work::Work;

/// Below this part of a radian, a stride by curvature is worth less than a window. Chosen by the count
/// of work on the reference hammer; one of unequal bars (0.7 and 1.4 of its lengths, 14 and 27
/// elements) takes the least there too.
const SHORT_STRIDE: f64 = 0.025;

/// By how many tabulated lengths a stride that is proved from both ends is tried to be longer than one
/// proved from its start: twice as long.
pub(super) const LEAP: usize = 2;

/// What a watch knows ahead of its proof, and how far it may look.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// The tracks that all guards share may be moved up to this instant, s.
    pub limit: f64,
    /// What comes after this instant is not asked for yet, s.
    pub until: f64,
    /// What is seen where the proof ends, if that is known already.
    pub seen: Option<Probe>,
    /// For how many strides its bounds have been taken to be as they were.
    pub age: usize,
    /// The track of its own that a guard of one track moves from its second look on: no other guard
    /// keeps it from leaping, nor moves it to where no tabulated stride ends.
    pub own: Option<Track>,
    /// Room for a modal vector.
    pub spare: Vec<f64>,
    /// Room for that of its own track.
    kept: Vec<f64>,
}

/// A stride from `t` of a tabulated length that is longer than the one proved from its start,
/// `stride`: the bound `m` on the second derivative holds backwards too, and strides below `level`
/// from both ends may meet.
pub(super) struct Leap {
    pub t: f64,
    pub step: usize,
    pub stride: f64,
    pub level: f64,
    pub m: f64,
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
        let (limit, until) = (f64::INFINITY, f64::INFINITY);
        Self { limit, until, seen: None, age: 0, own: None, spare: Vec::new(), kept: Vec::new() }
    }

    /// Puts its own track for the one that all guards share, if it has one; until that is done again
    /// the shared one is kept here.
    #[inline]
    pub fn exchange(&mut self, shared: &mut Track) {
        if let Some(own) = &mut self.own {
            self.limit = f64::INFINITY;
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
            self.limit = f64::INFINITY;
        }
    }

    /// Knows nothing, and keeps the room that it has.
    #[inline]
    pub fn restart(&mut self) {
        if let Some(track) = self.own.take() {
            self.kept = track.z;
        }
        (self.limit, self.until) = (f64::INFINITY, f64::INFINITY);
        (self.seen, self.age) = (None, 0);
    }

    /// Tries a longer stride than the one proved from its start; if it holds, moves the track to its
    /// end and returns what is seen there, with the bounds of `before` if that is given.
    pub fn leap(
        &mut self,
        (signal, part): (&Signal, Part),
        track: &mut Track,
        Leap { t, step, stride, level, m }: Leap,
        before: Option<&Probe>,
        work: &mut Work,
    ) -> Option<Probe> {
        let length = System::tabulated(step)?;
        let end = t + length;
        if end > self.limit || length > signal.long() {
            return None;
        }
        (work.evaluations, work.samples) = (work.evaluations + 1, work.samples + 1);
        let seen = match before {
            Some(before) => signal.glance_ahead(part, track, step, before, &mut self.spare),
            None => signal.look_ahead(part, track, step, end, &mut self.spare),
        };
        let room = level - seen.value;
        if room < 0.0 || stride + stride_below(room, -seen.slope, m) < length {
            return None;
        }
        std::mem::swap(&mut track.z, &mut self.spare);
        track.at = end;
        Some(seen)
    }
}
