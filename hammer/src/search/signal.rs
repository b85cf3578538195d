//! A guard as a function of time: `g(t) = drift(t) + sum c . z(t)` over one or two tracks.

use crate::modal::system::generator::Generator;
use crate::modal::system::{Functional, System, TAYLOR};
use crate::modal::track::Track;
use crate::numerics::combine;
use crate::numerics::kernel::{self, EvaluationRows};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::search::drift::{Drift, LONG};
use crate::search::window::{Noise, Window};

/// The resolution over the allowed remainder of each of two tracks. The sum of both remainders is below an eighth of
/// the resolution, with a margin for the rounding of bounds.
const REMAINDER: f64 = 17.0;

/// The part of a guard that one track contributes.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Index of the track.
    pub track: usize,
    /// Index of the functional in the track's system.
    pub functional: usize,
    /// Factor of the functional.
    pub factor: f64,
}

/// The value of a signal at one instant, with its slope and bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    pub value: f64,
    pub slope: f64,
    /// Bound on the modal part from now on.
    pub amplitude: f64,
    /// Bound on the second derivative of the modal part from now on.
    pub curvature: f64,
}

/// Threshold of steepness. The assertion in [`crate::search::steep`] limits it; this value needs the least work on the
/// reference hammer.
pub(crate) const STEEP: f64 = 2.5;

impl Probe {
    /// True if all numbers and their sum are finite. (The sum may overflow only for numbers near the largest.)
    pub(super) fn is_finite(&self) -> bool {
        (self.value + self.slope + self.amplitude + self.curvature).is_finite()
    }

    /// True if the guard is certain to rise through zero soon. `m` bounds the magnitude of its second derivative.
    #[inline]
    pub fn rises_steeply(&self, m: f64) -> bool {
        self.slope > 0.0 && self.slope * self.slope >= STEEP * m * self.value.abs()
    }

    fn of([value, slope]: [f64; 2]) -> Self {
        Self { value, slope, amplitude: 0.0, curvature: 0.0 }
    }

    fn add(&mut self, factor: f64, [value, slope, amplitude, curvature]: [f64; 4]) {
        self.value += factor * value;
        self.slope += factor * slope;
        self.amplitude += factor.abs() * amplitude;
        self.curvature += factor.abs() * curvature;
    }
}

/// The function `drift(t) + sum factor (c B^order) . z(t)`. The guard crosses where it rises through zero.
#[derive(Clone, Debug)]
pub struct Signal {
    /// The part due to static deflection and translation, in the tracks' time.
    pub(crate) drift: Drift,
    /// The parts that tracks contribute.
    pub parts: [Option<Part>; 2],
    /// 0 for a displacement, 1 for a velocity.
    pub order: usize,
    /// The value above zero from which the signal counts as crossed.
    pub resolution: f64,
    /// How long the drift is valid, s.
    reach: f64,
}

impl Signal {
    /// A signal with this polynomial as its drift. The other arguments are the fields.
    #[inline]
    pub fn new(poly: Poly, parts: [Option<Part>; 2], order: usize, resolution: f64) -> Self {
        Self::over(Drift::new(poly), parts, order, resolution)
    }

    /// A signal with this drift. The other arguments are the fields.
    #[inline]
    pub(crate) fn over(
        drift: Drift,
        parts: [Option<Part>; 2],
        order: usize,
        resolution: f64,
    ) -> Self {
        Self { drift, parts, order, resolution, reach: f64::INFINITY }
    }

    /// The drift as a polynomial of the tracks' time.
    #[cfg(feature = "internals")]
    pub fn poly(&self) -> Poly {
        match &self.drift {
            Drift::High(high) => high.poly,
            drift => {
                let mut poly = Poly::default();
                poly.0[..3].copy_from_slice(&drift.start());
                poly
            }
        }
    }

    /// The same signal, if it is only valid up to `reach`.
    #[inline]
    pub(crate) fn within(mut self, reach: f64) -> Self {
        self.reach = reach;
        self.drift = self.drift.within(reach);
        self
    }

    /// True if the drift is no longer valid at `t`.
    #[inline]
    pub(crate) fn ends_before(&self, t: f64) -> bool {
        t >= self.reach
    }

    /// Longest step for a drift of high degree, s.
    pub(crate) fn long(&self) -> f64 {
        LONG.min(self.reach)
    }

    /// Number of times `eps` by which a Taylor coefficient may be rounded: by a sum of [`combine::combine`], a factor,
    /// and the addition of the other track's part.
    fn series_operations(&self, tracks: &[Track]) -> f64 {
        let parts = self.parts.iter().flatten();
        let longest = parts.fold(0, |n, part| tracks[part.track].z.len().max(n));
        4.0 + 0.5 * combine::roundings(longest) as f64
    }

    /// Bound on the rounding of a value at `t` whose modal terms sum to `amplitude`.
    pub(crate) fn rounding(&self, tracks: &[Track], t: f64, amplitude: f64) -> f64 {
        f64::EPSILON * amplitude * self.series_operations(tracks) + self.drift.rounding(t)
    }

    /// Factor, functional and track of each part.
    fn each<'a>(
        &'a self,
        tracks: &'a [Track],
    ) -> impl Iterator<Item = (f64, &'a Functional, &'a Track)> {
        self.parts.iter().flatten().map(|part| {
            let track = &tracks[part.track];
            (part.factor, &track.system.functionals[part.functional], track)
        })
    }

    /// Bound on the modal part of the `k`-th derivative, from the tracks' instants on.
    pub(crate) fn amplitude(&self, tracks: &[Track], k: usize) -> f64 {
        let bound = |(factor, functional, track): (f64, &Functional, &Track)| {
            factor.abs() * kernel::bound(&functional.weights[self.order + k], &track.z)
        };
        self.each(tracks).map(bound).sum()
    }

    /// True if a step is longer than about a radian of the motion.
    pub(crate) fn is_long(&self, tracks: &[Track], step: f64, amplitude: f64) -> bool {
        step * step * self.amplitude(tracks, 2) > amplitude
    }

    /// Rotates the tracks to `t` and evaluates the signal there, in one pass for each track. `drift` is the value and
    /// the rate of the drift at `t`. Also returns the number of rotations. `spare` is storage for a modal vector.
    pub(crate) fn evaluate(
        &self,
        tracks: &mut [Track],
        (t, drift): (f64, [f64; 2]),
        spare: &mut Vec<f64>,
    ) -> (Probe, u64) {
        let (mut probe, mut count) = (Probe::of(drift), 0);
        for Part { track, functional, factor } in self.parts.iter().flatten() {
            let (value, rotations) = tracks[*track].evaluate_at(t, *functional, self.order, spare);
            probe.add(*factor, value);
            count += rotations;
        }
        (probe, count)
    }

    /// A view of a signal that has only one track.
    #[inline]
    pub(crate) fn view<'a>(&'a self, part: Part, system: &'a System) -> View<'a> {
        let rows = system.functionals[part.functional].evaluation_rows(self.order);
        View { signal: self, factor: part.factor, rows }
    }

    /// True if a guard with constant drift stays below a level for ever. `amplitude` bounds its modal part.
    #[inline]
    pub(crate) fn stays_below(&self, level: f64, amplitude: f64) -> bool {
        self.drift.constant().is_some_and(|value| value + amplitude < level)
    }

    /// How long the slowest decay, `a exp(-rate t)` with `a < 0`, certainly holds a guard with constant drift below
    /// `-margin`, whatever the other modes do; 0 if that is not certain. `amplitude` bounds all modes together.
    pub(crate) fn creeping_step(&self, tracks: &[Track], amplitude: f64, margin: f64) -> f64 {
        let mut longest = 0.0f64;
        for Part { track, functional, factor } in self.parts.iter().flatten() {
            let Track { system, z, .. } = &tracks[*track];
            let Some((k, rate)) = system.creeping else { continue };
            let decay = factor * system.functionals[*functional].rows[self.order][k] * z[k];
            let room = -margin - self.drift.start()[0] - (amplitude - decay.abs());
            if decay < 0.0 && room < 0.0 {
                // The guard is below `-margin` while `decay exp(-rate t) < room`.
                longest = longest.max(math::ln(decay / room) / rate);
            }
        }
        longest.min(self.reach)
    }

    /// Makes one Newton step from a zero of a window's polynomial to the zero of the guard itself. The tracks must be
    /// rotated to `root`. The values of the two functions differ by less than the resolution.
    pub(crate) fn polish(&self, tracks: &[Track], root: f64) -> f64 {
        let [value, slope] = self.value_and_slope(tracks, root);
        let is_close = slope > 0.0 && value.abs() <= self.resolution;
        if is_close { root - value / slope } else { root }
    }

    /// Value and slope at `t`, to which the tracks must be rotated.
    pub(crate) fn value_and_slope(&self, tracks: &[Track], t: f64) -> [f64; 2] {
        let [mut value, mut slope] = self.drift.at(t);
        for (factor, f, track) in self.each(tracks) {
            value += factor * kernel::dot(&f.rows[self.order], &track.z);
            slope += factor * kernel::dot(&f.rows[self.order + 1], &track.z);
        }
        [value, slope]
    }

    /// The second derivative at the tracks' instant. The drift must be at most a parabola.
    pub(crate) fn bend(&self, tracks: &[Track]) -> f64 {
        let modal = |(factor, f, track): (f64, &Functional, &Track)| {
            factor * kernel::dot(&f.rows[self.order + 2], &track.z)
        };
        2.0 * self.drift.start()[2] + self.each(tracks).map(modal).sum::<f64>()
    }

    /// The guard's Taylor polynomial from `t` on, over the longest window in which its remainder is below an eighth of
    /// the resolution. The magnitudes of its modal terms sum to `amplitude`.
    pub fn expand(&self, tracks: &[Track], t: f64, amplitude: f64) -> Window {
        let allowed = const { factorial(TAYLOR) / REMAINDER } * self.resolution;
        let mut longest = f64::INFINITY;
        for (factor, f, track) in self.each(tracks) {
            let tail = factor.abs() * kernel::bound(&f.taylor[self.order], &track.z);
            if tail > 0.0 {
                let radians = math::root(allowed / tail);
                longest = longest.min(radians / track.system.rate_max);
            }
        }
        let h = (10.0 * LONG).min(self.reach).min(longest);
        // Each track allows the longest window with `a_TAYLOR h^TAYLOR <= allowed`. The factor 1.03 is a margin:
        // `1.03^TAYLOR` is two.
        let growth = if longest < f64::INFINITY {
            let radians = math::root(allowed / amplitude);
            1.03 * std::f64::consts::SQRT_2 * radians * (h / longest)
        } else {
            0.0
        };
        let operations = self.series_operations(tracks);
        let modal = Noise { amplitude: f64::EPSILON * amplitude, operations, growth };
        let mut q = self.drift.expand(t, h);
        for part in self.parts.iter().flatten() {
            let track = &tracks[part.track];
            let rate = track.system.rate_max;
            let mut scale = part.factor * if self.order == 0 { 1.0 } else { rate };
            let terms = track.system.taylor(part.functional, self.order, &track.z);
            for (k, (c, term)) in q.iter_mut().zip(terms).enumerate() {
                // The scale may overflow if the term is zero.
                *c += if term == 0.0 { 0.0 } else { scale * term };
                scale *= h * rate / (k + 1) as f64;
            }
        }
        Window { h, q, modal, drift: self.drift.rounding(t + h) }
    }
}

/// A view of a signal that has only one track.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    signal: &'a Signal,
    factor: f64,
    rows: &'a EvaluationRows,
}

impl View<'_> {
    /// Evaluates the signal after a tabulated rotation from the track's instant, and leaves the rotated modal vector in
    /// `spare`. If an earlier probe is given as `bounds`, its bounds are reused, since they hold for all later times.
    #[inline]
    pub fn evaluate_ahead(
        &self,
        track: &Track,
        level: usize,
        bounds: Option<&Probe>,
        spare: &mut Vec<f64>,
    ) -> Probe {
        let Track { system, z, at } = track;
        let mut probe = Probe::of(self.signal.drift.at(at + Generator::length(level)));
        let Some(bounds) = bounds else {
            probe.add(self.factor, system.generator.evaluate_ahead(level, self.rows, z, spare));
            return probe;
        };
        let two = system.generator.evaluate_two_ahead(level, self.rows, z, spare);
        let [value, slope] = two.map(|x| self.factor * x);
        Probe { value: probe.value + value, slope: probe.slope + slope, ..*bounds }
    }
}

/// [`math::root`] must take the root of the order of the remainder.
const _: () = assert!(TAYLOR == math::ROOT);

const fn factorial(n: usize) -> f64 {
    let (mut product, mut k) = (1.0, 1);
    while k <= n {
        product *= k as f64;
        k += 1;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::mode::{Mode, RockMode};
    use crate::modal::structure::{Attachment, Structure};
    use crate::modal::system::Recipe;
    use std::sync::Arc;

    /// A track whose functional is the sum of an undamped oscillation `a cos(w t + phase)` and the decay
    /// `-size exp(-r t)`. The decay is the slower one of an overdamped oscillator with the rates `r` and `fast`.
    fn track([w, a, phase]: [f64; 3], [r, fast, size]: [f64; 3]) -> Track {
        let omega2 = [r * fast, w * w];
        let shape = &[1.0, 0.0];
        let dashpot = Attachment { shape, stiffness: 0.0, viscosity: r + fast };
        let recipe = Recipe {
            structure: Structure { attachments: vec![dashpot], ..Structure::free(&omega2, 0.0) },
            loads: std::array::from_fn(|_| vec![0.0; 2]),
            functionals: vec![vec![1.0; 2]],
            dampers: Vec::new(),
        };
        let mode = Mode::starting(RockMode::FreeFlight);
        let system = Arc::new(System::new(recipe, None, mode).expect("a spectrum"));
        let mut z = vec![0.0; 2 * system.blocks()];
        let (sine, cosine) = phase.sin_cos();
        system.to_modal(&[-size, a * cosine, size * r, -a * w * sine], &mut z);
        Track { system, z, at: 0.0 }
    }

    fn guard(drift: [f64; 3], factor: f64) -> Signal {
        let part = Part { track: 0, functional: 0, factor };
        Signal::over(Drift::parabola(drift), [Some(part), None], 0, 1e-9)
    }

    /// A creeping step ends where the other modes, at their bound, could bring the guard to the margin. There is no
    /// step if the decay starts above zero, or does not outweigh the other modes.
    #[test]
    fn a_creeping_step_ends_where_the_decay_outweighs_the_rest_no_more() {
        let (r, size, a, margin) = (30.0, 2.0, 0.2, 0.05);
        for (factor, level) in [(1.0, -0.3), (1.5, -0.1), (1.0, 0.2)] {
            let tracks = [track([2e4, a, 0.3], [r, 4e3, size])];
            let signal = guard([level, 0.0, 0.0], factor);
            let amplitude = signal.amplitude(&tracks, 0);
            let step = signal.creeping_step(&tracks, amplitude, margin);
            let rest = amplitude - factor * size;
            assert!(rest >= 0.999 * factor * a, "{rest}");
            let end = level - factor * size * (-r * step).exp() + rest;
            assert!(step > 0.0 && (end + margin).abs() < 1e-9, "{factor} {level}: {step} {end}");
        }
        let up = [track([2e4, a, 0.3], [r, 4e3, -size])];
        let signal = guard([-0.3, 0.0, 0.0], 1.0);
        assert_eq!(signal.creeping_step(&up, signal.amplitude(&up, 0), margin), 0.0);
        let weak = [track([2e4, a, 0.3], [r, 4e3, 0.1])];
        let signal = guard([0.3, 0.0, 0.0], 1.0);
        assert_eq!(signal.creeping_step(&weak, signal.amplitude(&weak, 0), margin), 0.0);
    }

    /// For `a cos(w t)` plus a parabola, the second derivative and the values in a window equal those of the closed
    /// form. A window is as long as `w` allows, and its error is at most an eighth of the resolution.
    #[test]
    fn bends_zeros_and_windows_are_those_of_the_closed_form() {
        let (w, a, phase) = (2e4, 0.2, 0.3);
        let tracks = [track([w, a, phase], [30.0, 4e3, 0.0])];
        for (drift, factor) in [([-0.17, 20.0, 5e3], 1.0), ([0.2, -300.0, 7e6], -1.5)] {
            let signal = guard(drift, factor);
            let exact = |t: f64| {
                drift[0] + t * (drift[1] + t * drift[2]) + factor * a * (w * t + phase).cos()
            };
            let bend = 2.0 * drift[2] - factor * a * w * w * phase.cos();
            assert!((signal.bend(&tracks) - bend).abs() < 1e-9 * a * w * w, "{factor}");
            let amplitude = signal.amplitude(&tracks, 0);
            let window = signal.expand(&tracks, 0.0, amplitude);
            for x in [0.0, 0.3, 0.7, 1.0] {
                let value = window.q.iter().rev().fold(0.0, |sum, c| sum * x + c);
                let error = (value - exact(x * window.h)).abs();
                assert!(error <= signal.resolution / 8.0, "{factor} {x}: {error:e}");
            }
            // The terms grow by `sqrt(2) w h`, times a margin.
            let growth = window.modal.growth / (std::f64::consts::SQRT_2 * w * window.h);
            assert!((1.0..1.1).contains(&growth), "{factor}: {growth}");
            assert_eq!(window.modal.amplitude, f64::EPSILON * amplitude);
            // The rounding is at least that of a value and its factor, and at most that of some ten terms.
            let rounding = signal.rounding(&tracks, 0.0, amplitude) - signal.drift.rounding(0.0);
            let roundings = rounding / (f64::EPSILON * amplitude);
            assert!((4.0..20.0).contains(&roundings), "{roundings}");
        }
    }

    /// A Newton step is made where the guard rises and is within its resolution of zero; elsewhere no step is made.
    #[test]
    fn a_zero_is_polished_where_the_guard_rises_within_its_resolution() {
        for (slope, start, is_polished) in
            [(3.0, 0.9e-9, true), (3.0, -0.9e-9, true), (3.0, 1.1e-9, false), (-3.0, 0.9e-9, false)]
        {
            let tracks = [track([2e4, 0.0, 0.0], [30.0, 4e3, 0.0])];
            let signal = guard([start, slope, 0.0], 1.0);
            let expected = if is_polished { -start / slope } else { 0.0 };
            assert_eq!(signal.polish(&tracks, 0.0), expected, "{slope} {start}");
        }
    }

    #[test]
    fn a_probe_is_finite_if_each_of_its_numbers_is() {
        let probe = Probe { value: 1.0, slope: 1.0, amplitude: 1.0, curvature: 1.0 };
        assert!(probe.is_finite());
        for number in [f64::NAN, f64::INFINITY] {
            for altered in [
                Probe { value: number, ..probe },
                Probe { slope: number, ..probe },
                Probe { amplitude: number, ..probe },
                Probe { curvature: number, ..probe },
            ] {
                assert!(!altered.is_finite(), "{altered:?}");
            }
        }
    }
}
