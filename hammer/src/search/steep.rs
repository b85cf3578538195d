//! A guard that rises steeply through zero: its crossing without a window.
//!
//! Where `g < 0`, `g' > 0` and `g'^2 >= K m |g|`, `m` being a bound on `|g''|` from here on and
//! `K` = [`STEEP`], over the time `S = F |g| / g'`, `F` = [`FAR`] below `K`, the guard rises all the
//! way,
//!
//! ```text
//! g'(s) >= g' - m s >= (1 - F / K) g',      g(S) >= (F - 1) |g| - m S^2 / 2 >= |g| / 5,
//! ```
//!
//! so that it has one zero there, and comes to lie far above it. To that zero Newton's method leads:
//! from `d` beside it, a step errs by `m d^2 / 2` over the slope there at the most.
//!
//! The slope's rounding is far below itself: by the inequality of Cauchy and Schwarz the terms of
//! `g'` sum up to `sqrt(a m)` at the most, `a` being what those of `g` do, and `|g|` is many times a
//! resolution, which is 16 roundings of `a` or more; so is a drift's.

use crate::modal::track::Track;
use crate::search::ahead::Ahead;
use crate::search::signal::{Probe, STEEP, Signal};
use crate::search::work::Work;

/// `S`, over `|g| / g'`.
const FAR: f64 = 2.4;
const _: () = assert!(STEEP > FAR && FAR - 1.0 - 0.5 * FAR * FAR / STEEP > 0.2);
/// Newton steps; two or three will do.
const STEPS: usize = 6;
/// Part of the resolution that is left to a zero where rounding keeps it from being any sharper.
const LEFT: f64 = 1.0 / 16.0;

/// The crossing of a guard that is seen so at an instant, if it is steep and can be followed so far; `m`
/// is a bound from above on its second derivative. A track of its own is left there, or as near as
/// it takes the event to find it: it is looked at no more.
pub(super) fn crossing(
    signal: &Signal,
    ahead: &mut Ahead,
    tracks: &mut [Track],
    here: (&Probe, f64),
    m: f64,
    work: &mut Work,
) -> Option<f64> {
    let m = m + signal.drift.bends(here.1, signal.long())[1];
    if signal.drift.is_high() || !here.0.rises_steeply(m) {
        return None;
    }
    let [Some(part), None] = signal.parts else {
        return rise(signal, &mut tracks.to_vec(), here, m, work);
    };
    let track = &mut tracks[part.track];
    ahead.part_from(track);
    ahead.spare.clone_from(&track.z);
    let at = track.at;
    let found = rise(signal, tracks, here, m, work);
    let track = &mut tracks[part.track];
    if let Some(found) = found {
        track.step_back_to(found);
    } else {
        std::mem::swap(&mut track.z, &mut ahead.spare);
        track.at = at;
    }
    found
}

/// The zero of a guard that is seen so at `t`, where its tracks stand; these are left near it. None
/// if it is not steep, or cannot be followed so far.
fn rise(
    signal: &Signal,
    tracks: &mut [Track],
    (probe, t): (&Probe, f64),
    m: f64,
    work: &mut Work,
) -> Option<f64> {
    let Probe { value, slope, .. } = *probe;
    let end = t - FAR * value / slope;
    // The zero of the parabola.
    let root = (slope * slope - 2.0 * signal.bend(tracks) * value).max(0.0).sqrt();
    let mut at = t - 2.0 * value / (slope + root);
    let (tolerance, mut left) = (0.25 * f64::EPSILON * at, f64::INFINITY);
    for _ in 0..STEPS {
        if !(t < at && at < end) {
            return None;
        }
        for part in signal.parts.iter().flatten() {
            let track = &mut tracks[part.track];
            if at < track.at {
                track.step_back_to(at);
            } else {
                work.samples += track.rotate_to(at);
            }
            if track.at != at {
                return None;
            }
        }
        work.evaluations += 1;
        let [value, slope] = signal.value_and_slope(tracks, at);
        let step = -value / slope;
        at += step;
        if m * step * step <= slope * tolerance {
            return Some(at);
        }
        left = value.abs();
    }
    (left <= LEFT * signal.resolution && t < at && at < end).then_some(at)
}
