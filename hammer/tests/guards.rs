//! Difficult guards: what a search for events must not miss, on synthetic motions whose crossings are known in closed
//! form, through the `GuardTracker` that the hammer uses.

use hammer::modal::structure::{Attachment, Structure};
use hammer::modal::system::{Recipe, System};
use hammer::modal::track::Track;
use hammer::numerics::poly::Poly;
use hammer::search::signal::{Part, Signal};
use hammer::search::tracker::{GuardTracker, Work};
use hammer::{Mode, RockMode};
use std::sync::Arc;

/// Any will do: the motions here are of order 1.
const RESOLUTION: f64 = 1e-9;
const MODE: Mode = Mode::starting(RockMode::FreeFlight);

/// Undamped oscillators of these circular frequencies, each at amplitude and phase
/// `a cos(w t + phase)`; the functional is their sum.
fn track(waves: &[(f64, f64, f64)]) -> Track {
    let omega2: Vec<f64> = waves.iter().map(|w| w.0 * w.0).collect();
    let state: Vec<f64> = waves
        .iter()
        .map(|(_, a, phase)| a * phase.cos())
        .chain(waves.iter().map(|(w, a, phase)| -a * w * phase.sin()))
        .collect();
    moving(Structure::free(&omega2, 0.0), &state)
}

/// A structure in this state, `[q | q']`; the functional is the sum of its modes.
fn moving(structure: Structure, state: &[f64]) -> Track {
    let n = structure.omega2.len();
    let recipe = Recipe {
        structure,
        loads: std::array::from_fn(|_| vec![0.0; n]),
        functionals: vec![vec![1.0; n]],
        dampers: Vec::new(),
    };
    let system = Arc::new(System::new(recipe, None, MODE).expect("a spectrum"));
    let mut z = vec![0.0; 2 * system.blocks()];
    system.to_modal(state, &mut z);
    Track { system, z, at: 0.0 }
}

fn poly(c: &[f64]) -> Poly {
    let mut p = Poly::default();
    p.0[..c.len()].copy_from_slice(c);
    p
}

fn guard(p: Poly, order: usize) -> Signal {
    let part = Part { track: 0, functional: 0, factor: 1.0 };
    Signal::new(p, [Some(part), None], order, RESOLUTION)
}

/// Runs the search to `until`: the first crossing, and the work.
fn search(track: &Track, guard: Signal, until: f64) -> (Option<f64>, u64) {
    let mut tracker = GuardTracker::new(guard, 0.0);
    let (mut tracks, mut work) = (vec![track.clone()], Work::default());
    while tracker.root.is_none() && tracker.clear <= until {
        tracker.extend(&mut tracks, &mut work);
        assert!(work.evaluations < 200_000, "the search crawls at {}", tracker.clear);
    }
    (tracker.root.filter(|t| *t <= until), work.evaluations)
}

/// Location error of a clean crossing: rounding of `g` over its slope, and of `t`.
fn close(t: f64, exact: f64, noise: f64, slope: f64) -> bool {
    (t - exact).abs() <= 4.0 * (noise / slope + f64::EPSILON * exact)
}

#[test]
fn a_plain_crossing_is_located_to_rounding() {
    // sin(t) - 1/2 rises through zero at pi/6.
    let track = track(&[(1.0, 1.0, -std::f64::consts::FRAC_PI_2)]);
    let (found, _) = search(&track, guard(poly(&[-0.5]), 0), 10.0);
    let exact = std::f64::consts::FRAC_PI_6;
    assert!(close(found.expect("a crossing"), exact, f64::EPSILON, 0.75f64.sqrt()), "{found:?}");
}

/// A guard that starts at zero without slope and rises: `1 - cos(w t)`, with rounding of either sign. It reaches the
/// resolution `r` at `sqrt(2 r) / w`, and no zero of its own may be taken for a later one.
#[test]
fn a_rise_from_zero_without_a_slope_is_found_where_it_starts() {
    for w in [1.0, 1e3, 1e7] {
        for off in [-3e-16, -1e-16, 0.0, 1e-16, 3e-16] {
            let track = track(&[(w, -0.6, 0.0), (w, -0.4, 1e-17)]);
            let (found, _) = search(&track, guard(poly(&[1.0 + off]), 0), 10.0 / w);
            let latest = (2.0 * RESOLUTION).sqrt() / w;
            assert!(found.expect("a crossing") <= latest, "w {w}, off {off}: {found:?}");
        }
    }
}

/// A transition may leave its own guard a rounding above zero and falling. A later rise is another crossing, at its
/// own time: `cos(w t + p) - cos p + off` returns to zero at `2 (pi - p) / w`.
#[test]
fn a_guard_left_above_zero_by_rounding_is_not_taken_again_at_once() {
    for short_of in [2.0, 0.1, 1e-3, 1e-4] {
        let p = std::f64::consts::PI - short_of;
        for off in [1e-18, 1e-16, 1e-13] {
            let w = 1e5;
            let track = track(&[(w, 1.0, p)]);
            let (found, _) = search(&track, guard(poly(&[off - f64::cos(p)]), 0), 10.0 / w);
            let exact = 2.0 * (std::f64::consts::PI - p) / w;
            let slope = w * p.sin().abs();
            let found = found.expect("a crossing");
            // `off` moves it, and the guard's own rounding.
            assert!(close(found, exact, off + 4.0 * f64::EPSILON, slope), "p {p}: {found:e}");
        }
    }
}

/// A resolution far below the rounding of a guard's own terms has no meaning: `cos(w t + 1) - 1 + d` rises to `d`,
/// ten roundings of its terms, once a period, and whether it crosses is undetermined. Such a rise is not taken; one
/// of `1e4` roundings is.
#[test]
fn what_a_guard_s_own_terms_hide_is_not_taken() {
    let w = 1e5;
    let track = track(&[(w, 1.0, 1.0)]);
    let run = |d: f64| {
        let mut signal = guard(poly(&[d - 1.0]), 0);
        signal.resolution = 1e-22;
        search(&track, signal, 6.0 / w)
    };
    let (found, _) = run(10.0 * f64::EPSILON);
    assert_eq!(found, None);
    let d = 1e4 * f64::EPSILON;
    let (found, ..) = run(d);
    // It is above zero within `sqrt(2 d) / w` of its top.
    let top = (std::f64::consts::TAU - 1.0) / w;
    let early = top - found.expect("a crossing");
    assert!((early * w / (2.0 * d).sqrt() - 1.0).abs() < 1e-3, "{early:e}");
}

/// cos(w t) - (1 - d) is above zero for `2 acos(1 - d) / w` only, once a period.
#[test]
fn a_pair_of_crossings_is_found_however_close() {
    for d in [1e-2, 1e-4, 1e-6, 1e-8] {
        let w = 1e5;
        let track = track(&[(w, 1.0, 1.0)]);
        let (found, _) = search(&track, guard(poly(&[-(1.0 - d)]), 0), 1.0);
        let exact = (2.0 * std::f64::consts::PI - 1.0 - (1.0 - d).acos()) / w;
        let slope = w * (2.0 * d).sqrt();
        assert!(
            close(found.expect("a pair"), exact, 4.0 * f64::EPSILON, slope),
            "d {d}: {found:?} {exact}"
        );
    }
}

/// A guard that exceeds its level by a resolution or more crosses it, however briefly.
#[test]
fn a_peak_of_a_few_resolutions_is_a_crossing() {
    let (w, a) = (3e4, 0.7);
    for peak in [1.1, 1.5, 1.9, 3.0, 8.0] {
        let level = a - peak * RESOLUTION;
        let track = track(&[(w, a, std::f64::consts::PI)]);
        let (found, _) = search(&track, guard(poly(&[-level]), 0), 1e-3);
        let found = found.expect("a crossing");
        let before = (level / a).acos() / w;
        let exact = std::f64::consts::PI / w - before;
        let slope = w * (a * a - level * level).sqrt();
        assert!(close(found, exact, f64::EPSILON * a, slope), "{peak}: {found} {exact}");
    }
}

#[test]
fn a_graze_from_below_is_not_taken() {
    let w = 1e5;
    let track = track(&[(w, 1.0, 1.0)]);
    let until = 5.0 * 2.0 * std::f64::consts::PI / w;
    // Peaks two and ten resolutions below zero: every period comes near, none crosses.
    for resolutions in [2.0, 10.0] {
        let below = 1.0 + resolutions * RESOLUTION;
        assert_eq!(search(&track, guard(poly(&[-below]), 0), until).0, None);
    }
    // Two resolutions above: taken.
    let above = 1.0 - 2.0 * RESOLUTION;
    assert!(search(&track, guard(poly(&[-above]), 0), until).0.is_some());
}

#[test]
fn a_graze_from_above_is_a_crossing_already() {
    // Always above zero, touching it at t = 0.5 from above: it has crossed as soon as it is tracked.
    let track = track(&[(1.0, 0.0, 0.0)]);
    let (found, ..) = search(&track, guard(poly(&[0.25, -1.0, 1.0]), 0), 2.0);
    assert_eq!(found, Some(0.0));
}

#[test]
fn direction_matters_a_fall_through_zero_is_no_crossing() {
    let track = track(&[(1.0, 1.0, std::f64::consts::FRAC_PI_2)]);
    // cos(t + pi/2) = -sin t: at 0 it leaves downward, and rises at pi.
    let (found, ..) = search(&track, guard(poly(&[0.0]), 0), 4.0);
    let exact = std::f64::consts::PI;
    assert!(close(found.expect("a crossing"), exact, 4.0 * f64::EPSILON, 1.0), "{found:?}");
}

/// The motion of a body over a millisecond has a rounding above the resolution: `a t (t - b)` leaves zero downward
/// and returns at `b`, and no rounding may be taken for a rise.
#[test]
fn a_body_that_goes_far_within_a_window_is_not_taken_for_its_rounding() {
    let still = track(&[(1.0, 0.0, 0.0)]);
    for speed in [1e2, 1e6, 1e9, 1e11] {
        for b in [1e-3, 2e-5, 3e-7] {
            let (found, ..) = search(&still, guard(poly(&[0.0, -speed, speed / b]), 0), 1e-2);
            // The rounding of the three terms is that at `b`.
            let found = found.expect("a crossing");
            assert!(
                close(found, b, 2.0 * f64::EPSILON * speed * b, speed),
                "{speed} {b} {found:e}"
            );
        }
    }
}

#[test]
fn the_root_just_taken_is_not_taken_again() {
    let w = 1e5;
    let moving = track(&[(w, 1.0, -std::f64::consts::FRAC_PI_2)]);
    let (first, ..) = search(&moving, guard(poly(&[0.0]), 0), 1.0);
    // sin rises through zero at once: the guard is on the wrong side from the start.
    assert_eq!(first, Some(0.0));
    // The opposite guard, armed at the same root, waits for half a period.
    let mut opposite = guard(poly(&[0.0]), 0);
    opposite.parts[0] = Some(Part { track: 0, functional: 0, factor: -1.0 });
    let (next, ..) = search(&moving, opposite, 1.0);
    let exact = std::f64::consts::PI / w;
    assert!(close(next.expect("a crossing"), exact, 4.0 * f64::EPSILON, w), "{next:?} {exact}");
}

#[test]
fn two_crossings_within_a_picosecond_keep_their_order() {
    // Two guards on one motion, levels apart by what a slope of 1e5 makes in 1e-12 s.
    let w = 1e5;
    let track = track(&[(w, 1.0, -std::f64::consts::FRAC_PI_2)]);
    let level = 0.3;
    let apart = w * 1e-12;
    let (a, ..) = search(&track, guard(poly(&[-level]), 0), 1.0);
    let (b, ..) = search(&track, guard(poly(&[-level - apart]), 0), 1.0);
    let (a, b) = (a.expect("first"), b.expect("second"));
    let gap = apart / (w * (1.0f64 - level * level).sqrt());
    assert!(b > a && ((b - a) - gap).abs() < 1e-18 + 1e-6 * gap, "{a} {b}");
    // Identical guards give identical instants.
    assert_eq!(search(&track, guard(poly(&[-level]), 0), 1.0).0, Some(a));
}

#[test]
fn a_crossing_exactly_at_the_end_is_found() {
    // -1 + t crosses at 1: a polynomial without oscillation, whose zero is 1 to rounding.
    let track = track(&[(1.0, 0.0, 0.0)]);
    let (found, ..) = search(&track, guard(poly(&[-1.0, 1.0]), 0), 1.0 + 4.0 * f64::EPSILON);
    assert!(close(found.expect("at the end"), 1.0, f64::EPSILON, 1.0), "{found:?}");
}

/// Forty oscillations with large amplitudes cancel at the start, so that the guard is as flat as a high power of t: a
/// bound by absolute values is 1e12 m/s3 there. A window must carry the search through.
#[test]
fn cancelling_amplitudes_do_not_make_the_search_crawl() {
    let waves: Vec<(f64, f64, f64)> = (0..40)
        .map(|k| {
            (
                1e5 * (k as f64 + 1.0),
                binomial(39, k) / 2f64.powi(39) * if k % 2 == 0 { 10.0 } else { -10.0 },
                0.0,
            )
        })
        .collect();
    // sum (-1)^k C(39,k) cos((k+1) x) = Re e^{ix} (1 - e^{ix})^39: of size x^39 near 0.
    let track = track(&waves);
    let exact = |t: f64| {
        let x = 1e5 * t;
        let r = (2.0 * (0.5 * x).sin()).powi(39) / 2f64.powi(39) * 10.0;
        // (1 - e^{ix})^39 = (2 sin(x/2))^39 e^{i 39 (x - pi)/2}.
        r * (x + 39.0 * (x - std::f64::consts::PI) / 2.0).cos()
    };
    let level = 1e-3;
    let (found, work) = search(&track, guard(poly(&[-level]), 0), 1e-4);
    let t = found.expect("a crossing");
    // Independent bracket: the closed form on a fine grid.
    let step = 1e-9;
    let first =
        (1..100_000).map(|i| f64::from(i) * step).find(|&s| exact(s) > level).expect("bracket");
    assert!(t <= first && t >= first - step, "{t} {first}");
    assert!(work < 200, "{work} evaluations");
}

fn binomial(n: u32, k: u32) -> f64 {
    (0..k).fold(1.0, |b, i| b * f64::from(n - i) / f64::from(i + 1))
}

/// The remainder of a window is bounded for the guard's own order, here for the velocity of a fast mode.
#[test]
fn a_velocity_is_searched_as_sharply_as_a_displacement() {
    let (w, v) = (2e6, 1.0);
    for slow in [1e3, 1e5] {
        // v = cos(w t) small beside a slow ramp: crossings by bisection of the closed form.
        let track = track(&[(w, 1e-3 * v / w, 0.3), (slow, v / slow, 0.2)]);
        let exact = |t: f64| -1e-3 * v * (w * t + 0.3).sin() - v * (slow * t + 0.2).sin() - 0.4;
        let (found, ..) = search(&track, guard(poly(&[-0.4]), 1), 1e-1);
        let t = found.expect("a crossing");
        let step = 1e-9;
        let first = (1..10_000_000)
            .map(|i| f64::from(i) * step)
            .find(|&s| exact(s) > 0.0)
            .expect("bracket");
        assert!(t <= first && t >= first - step, "slow {slow}: {t} {first}");
        assert!(exact(t).abs() < 1e-13, "{:e}", exact(t));
    }
}

#[test]
fn a_decay_towards_zero_from_below_costs_nothing() {
    // Damped to nothing below the level: clear for ever, without a search.
    let track = moving(Structure::free(&[1e10], 1e-6), &[-1e-3, 0.0]);
    let (found, work) = search(&track, guard(poly(&[-2e-3]), 0), 1e3);
    assert_eq!(found, None);
    assert!(work < 10, "{work} evaluations");
}

/// `-exp(-t) + a cos(w t)` first rises through zero when the decay has fallen to the amplitude. Until then the decay
/// alone decides, where a bound on the curvature would take a step every `sqrt(2 / a) / w`, 10,000 of them.
#[test]
fn a_creep_that_outweighs_an_oscillation_is_followed_to_where_it_ends() {
    let (w, a) = (2e4, 0.1);
    // s^2 + c s + k = 0 has the roots -1 and -1000.
    let (k, c) = (1e3f64, 1001.0);
    let omega2 = [k, w * w];
    let dashpot = Attachment { shape: &[1.0, 0.0], stiffness: 0.0, viscosity: c };
    let structure = Structure { attachments: vec![dashpot], ..Structure::free(&omega2, 0.0) };
    let track = moving(structure, &[-1.0, a, 1.0, 0.0]);
    let (found, work) = search(&track, guard(poly(&[]), 0), 10.0);
    let t = found.expect("a crossing");
    let exact = |t: f64| a * (w * t).cos() - (-t).exp();
    // The first peak above zero; an independent bracket on the way up to it.
    let peak = (1u32..)
        .map(|n| f64::from(n) * std::f64::consts::TAU / w)
        .find(|&peak| exact(peak) > 0.0)
        .expect("a peak");
    let (mut low, mut high) = (peak - std::f64::consts::PI / w, peak);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if exact(middle) < 0.0 { low = middle } else { high = middle }
    }
    let slope = (exact(low + 1e-9) - exact(low - 1e-9)) / 2e-9;
    // The slow root is a thousandth of its pair's other root, and so has a thousand roundings.
    assert!(close(t, low, 1e3 * f64::EPSILON, slope), "{t} {low}");
    assert!(work < 500, "{work} evaluations");
}
