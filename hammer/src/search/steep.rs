//! The crossing of a guard that rises steeply through zero, found without a window.
//!
//! Let `m` bound `|g''|` from now on, `K` = [`STEEP`] and `F` = [`FAR`] < `K`. If now `g < 0`, `g' > 0` and
//! `g'^2 >= K m |g|`, the guard rises throughout the time `S = F |g| / g'`:
//!
//! ```text
//! g'(s) >= g' - m s >= (1 - F / K) g',      g(S) >= (F - 1) |g| - m S^2 / 2 >= |g| / 5,
//! ```
//!
//! so that it has exactly one zero in this time, and is far above zero at its end. Newton's method finds this zero. A
//! step from the distance `d` leaves an error of at most `m d^2 / 2` over the slope.
//!
//! The rounding of the slope is negligible. By the Cauchy-Schwarz inequality the terms of `g'` sum to at most `sqrt(a
//! m)`, where `a` is the sum of the terms of `g`. `|g|` is many resolutions, and a resolution is at least 16 roundings
//! of `a`. The same is true of a drift.

use crate::modal::track::Track;
use crate::search::ahead::Ahead;
use crate::search::signal::{Probe, STEEP, Signal};
use crate::search::work::Work;

/// The factor `F` in `S = F |g| / g'`.
const FAR: f64 = 2.4;
const _: () = assert!(STEEP > FAR && FAR - 1.0 - 0.5 * FAR * FAR / STEEP > 0.2);
/// Limit of the Newton steps. Two or three are usual; a zero that needs more is left to a window.
const STEPS: usize = 6;

/// The crossing of a guard, computed from its value at one instant, if the guard is steep and its extrapolation reaches
/// the zero. `m` is an upper bound on its second derivative. The guard's own track is left near the crossing.
pub(super) fn crossing(
    signal: &Signal,
    ahead: &mut Ahead,
    tracks: &mut [Track],
    here: (&Probe, f64),
    m: f64,
    work: &mut Work,
) -> Option<f64> {
    let m = m + signal.drift.bends(here.1, signal.long())[1];
    if !here.0.rises_steeply(m) {
        return None;
    }
    // For a drift of high degree, the polynomial and the bound must be valid up to `end`.
    let end = here.1 + FAR * here.0.value.abs() / here.0.slope;
    if signal.drift.is_high() && (!signal.drift.is_bounded() || signal.ends_before(end)) {
        return None;
    }
    let [Some(part), None] = signal.parts else {
        return rise(signal, &mut tracks.to_vec(), here, m, work);
    };
    let track = &mut tracks[part.track];
    ahead.part_from(track);
    ahead.spare.clone_from(&track.z);
    let at = track.at;
    let crossing = rise(signal, tracks, here, m, work);
    let track = &mut tracks[part.track];
    if let Some(crossing) = crossing {
        track.step_back_to(crossing);
    } else {
        std::mem::swap(&mut track.z, &mut ahead.spare);
        track.at = at;
    }
    crossing
}

/// The zero of a guard, computed from its value at `t`, to which its tracks are rotated. `None` if the guard is not
/// steep, or its extrapolation does not reach the zero. The tracks are left near the zero.
fn rise(
    signal: &Signal,
    tracks: &mut [Track],
    (probe, t): (&Probe, f64),
    m: f64,
    work: &mut Work,
) -> Option<f64> {
    let Probe { value, slope, .. } = *probe;
    let end = t - FAR * value / slope;
    // The first estimate is the zero of the parabola.
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
