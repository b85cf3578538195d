//! The crossing of a guard that rises steeply through zero, found without a window.
//!
//! Let `m` bound `|g''|` from here on, `K` = [`STEEP`] and `F` = [`FAR`] < `K`. Where `g < 0`,
//! `g' > 0` and `g'^2 >= K m |g|`, the guard rises throughout the time `S = F |g| / g'`:
//! ```text
//! g'(s) >= g' - m s >= (1 - F / K) g',      g(S) >= (F - 1) |g| - m S^2 / 2 >= |g| / 5,
//! ```
//!
//! So it has exactly one zero there and then lies far above zero. Newton's method finds it: a step
//! from the distance `d` errs by at most `m d^2 / 2` over the slope.
//!
//! The slope's rounding is negligible: by the Cauchy-Schwarz inequality the terms of `g'` sum to at
//! most `sqrt(a m)`, where `a` is the sum of those of `g`, and `|g|` is many resolutions, each of
//! which is at least 16 roundings of `a`; likewise for a drift.

use crate::modal::track::Track;
use crate::search::ahead::Ahead;
use crate::search::signal::{Probe, STEEP, Signal};
use crate::search::work::Work;

/// `S`, over `|g| / g'`.
const FAR: f64 = 2.4;
const _: () = assert!(STEEP > FAR && FAR - 1.0 - 0.5 * FAR * FAR / STEEP > 0.2);
/// Newton steps; two or three are usual, and a window finds what needs more.
const STEPS: usize = 6;

/// The crossing of a guard from its value at an instant, if it is steep and can be extrapolated
/// that far; `m` is an upper bound on its second derivative. A track of its own is left near the
/// crossing.
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

/// The zero of a guard from its value at `t`, to which its tracks are rotated; they are left near the zero. None if
/// the guard is not steep, or cannot be extrapolated that far.
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
    let tolerance = 0.25 * f64::EPSILON * at;
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
    }
    None
}
