//! How a guard's watch looks ahead of its proof.

use crate::modal::system::System;
use crate::modal::track::Track;
use crate::search::signal::{Part, Probe, Signal};
use crate::search::watch::Work;
use crate::search::window::stride_below;

/// Below this part of a radian, a stride by curvature is worth less than a window.
const SHORT_STRIDE: f64 = 0.08;

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
        Self { limit, until, seen: None, age: 0, own: None, spare: Vec::new() }
    }

    /// Puts its own track for the one that all guards share, if it has one; until that is done again
    /// the shared one is kept here.
    pub fn exchange(&mut self, shared: &mut Track) {
        if let Some(own) = &mut self.own {
            self.limit = f64::INFINITY;
            std::mem::swap(own, shared);
        }
    }

    /// From now on the track at hand is its own; the shared one is kept here as it is.
    pub fn part_from(&mut self, shared: &Track) {
        self.own.get_or_insert_with(|| shared.clone());
        self.limit = f64::INFINITY;
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
