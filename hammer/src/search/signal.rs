//! A guard as a function of time: `g(t) = drift(t) + sum c . z(t)` over one or two tracks.

use crate::modal::system::{Functional, System, TAYLOR};
use crate::modal::track::Track;
use crate::numerics::kernel::{self, EvaluationRows};
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::search::drift::{Drift, LONG};
use crate::search::window::{Noise, Window};

/// A remainder is below the resolution over this, for each of two tracks: an eighth in all, and
/// some for the rounding of bounds.
const REMAINDER: f64 = 17.0;

/// One track's share of a guard.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Which track.
    pub track: usize,
    /// Which functional of its system.
    pub functional: usize,
    /// Factor.
    pub factor: f64,
}

/// A signal at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    /// Its value.
    pub value: f64,
    /// Its rate.
    pub slope: f64,
    /// Bound on the modal part, now and later.
    pub amplitude: f64,
    /// Bound on the modal part's second derivative, now and later.
    pub curvature: f64,
}

/// How steep is steep: what the assertion in [`crate::search::steep`] allows will do; chosen by the
/// count of work on the reference hammer.
pub(crate) const STEEP: f64 = 2.5;

impl Probe {
    /// True if a guard that is seen so is sure to rise through zero soon; `m` is a bound on the size
    /// of its second derivative.
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

/// `drift(t) + sum factor (c B^order) . z(t)`, crossing where it rises through zero.
#[derive(Clone, Debug)]
pub struct Signal {
    /// Static and translating part, in the time of the tracks.
    pub(crate) drift: Drift,
    /// Modal parts.
    pub parts: [Option<Part>; 2],
    /// 0: a displacement, 1: a velocity.
    pub order: usize,
    /// What counts as crossed.
    pub resolution: f64,
    /// How far the drift is to be trusted, s.
    reach: f64,
}

impl Signal {
    /// A guard over `parts`; see the fields.
    #[inline]
    pub fn new(poly: Poly, parts: [Option<Part>; 2], order: usize, resolution: f64) -> Self {
        Self::over(Drift::new(poly), parts, order, resolution)
    }

    /// The same.
    #[inline]
    pub(crate) fn over(
        drift: Drift,
        parts: [Option<Part>; 2],
        order: usize,
        resolution: f64,
    ) -> Self {
        Self { drift, parts, order, resolution, reach: f64::INFINITY }
    }

    /// Static and translating part, in the time of the tracks.
    #[cfg(feature = "internals")]
    pub fn poly(&self) -> Poly {
        match &self.drift {
            Drift::High(poly) => **poly,
            drift => {
                let mut poly = Poly::default();
                poly.0[..3].copy_from_slice(&drift.start());
                poly
            }
        }
    }

    /// The same, asked about up to `reach` only.
    #[inline]
    pub(crate) fn within(mut self, reach: f64) -> Self {
        self.reach = reach;
        self
    }

    /// Longest step when the polynomial part is of high degree, s.
    pub(crate) fn long(&self) -> f64 {
        LONG.min(self.reach)
    }

    /// Roundings of a coefficient of a Taylor polynomial, whose sum is [`kernel::combine`]'s: a
    /// product with a factor and a sum with another's share; each is half an `eps`.
    fn series_operations(&self, tracks: &[Track]) -> f64 {
        let longest = self.each(tracks).map(|(_, _, track)| track.z.len()).max();
        4.0 + 0.5 * kernel::roundings(longest.unwrap_or(0)) as f64
    }

    /// Rounding of a value at `t`, its modal terms summing up to `amplitude`.
    pub(crate) fn rounding(&self, tracks: &[Track], t: f64, amplitude: f64) -> f64 {
        f64::EPSILON * amplitude * self.series_operations(tracks) + self.drift.rounding(t)
    }

    /// Functional and track of each part.
    fn each<'a>(
        &'a self,
        tracks: &'a [Track],
    ) -> impl Iterator<Item = (f64, &'a Functional, &'a Track)> {
        self.parts.iter().flatten().map(|part| {
            let track = &tracks[part.track];
            (part.factor, &track.system.functionals[part.functional], track)
        })
    }

    /// Bound on the modal part of derivative `k`, from the tracks' instants on.
    pub(crate) fn amplitude(&self, tracks: &[Track], k: usize) -> f64 {
        let mut sum = 0.0;
        for Part { track, functional, factor } in self.parts.iter().flatten() {
            let track = &tracks[*track];
            let weights = &track.system.functionals[*functional].weights[self.order + k];
            sum += factor.abs() * kernel::bound(weights, &track.z);
        }
        sum
    }

    /// True if a step is at least about a radian of the motion.
    pub(crate) fn is_long(&self, tracks: &[Track], step: f64, amplitude: f64) -> bool {
        step * step * self.amplitude(tracks, 2) > amplitude
    }

    /// Looks at the signal at `t`, moving its tracks there, in one pass per track; and the number
    /// of rotations. `spare` is room for a modal vector.
    pub(crate) fn evaluate(&self, tracks: &mut [Track], t: f64, spare: &mut Vec<f64>) -> (Probe, u64) {
        let (mut probe, mut count) = (Probe::of(self.drift.at(t)), 0);
        for Part { track, functional, factor } in self.parts.iter().flatten() {
            let (value, turns) = tracks[*track].evaluate_at(t, *functional, self.order, spare);
            probe.add(*factor, value);
            count += turns;
        }
        (probe, count)
    }

    /// The signal's view of its one track.
    #[inline]
    pub(crate) fn view<'a>(&'a self, part: Part, system: &'a System) -> View<'a> {
        let rows = system.functionals[part.functional].evaluation_rows(self.order);
        View { signal: self, factor: part.factor, rows }
    }

    /// True if amplitude alone, the bound on what the modes make of it, keeps a guard without drift
    /// below a level for ever.
    #[inline]
    pub(crate) fn stays_below(&self, level: f64, amplitude: f64) -> bool {
        self.drift.constant().is_some_and(|value| value + amplitude < level)
    }

    /// How long the slowest decay alone, `a exp(-rate t)` with `a < 0`, keeps a guard without
    /// drift below `-margin`, however all the others swing; 0 if it does not. `amplitude` is
    /// the bound on all of them.
    pub(crate) fn creeping_step(&self, tracks: &[Track], amplitude: f64, margin: f64) -> f64 {
        let mut longest = 0.0f64;
        for Part { track, functional, factor } in self.parts.iter().flatten() {
            let Track { system, z, .. } = &tracks[*track];
            let Some((k, rate)) = system.creeping else { continue };
            let push = factor * system.functionals[*functional].rows[self.order][k] * z[k];
            let room = -margin - self.drift.start()[0] - (amplitude - push.abs());
            if push < 0.0 && room < 0.0 {
                // Below while `push exp(-rate t) < room`.
                longest = longest.max(math::ln(push / room) / rate);
            }
        }
        longest.min(self.reach)
    }

    /// A zero of the window's polynomial, moved to the zero of the guard itself: one Newton
    /// step, since the two differ by less than the resolution. The tracks stand at the first.
    pub(crate) fn polish(&self, tracks: &[Track], root: f64) -> f64 {
        let [value, slope] = self.value_and_slope(tracks, root);
        let close = slope > 0.0 && value.abs() <= self.resolution;
        if close { root - value / slope } else { root }
    }

    /// Value and slope at `t`, where the tracks stand.
    pub(crate) fn value_and_slope(&self, tracks: &[Track], t: f64) -> [f64; 2] {
        let [mut value, mut slope] = self.drift.at(t);
        for (factor, f, track) in self.each(tracks) {
            value += factor * kernel::dot(&f.rows[self.order], &track.z);
            slope += factor * kernel::dot(&f.rows[self.order + 1], &track.z);
        }
        [value, slope]
    }

    /// The second derivative at the tracks' instant, of a drift that is a parabola at most.
    pub(crate) fn bend(&self, tracks: &[Track]) -> f64 {
        let modal = |(factor, f, track): (f64, &Functional, &Track)| {
            factor * kernel::dot(&f.rows[self.order + 2], &track.z)
        };
        2.0 * self.drift.start()[2] + self.each(tracks).map(modal).sum::<f64>()
    }

    /// The guard's Taylor polynomial from `t` on, over a window as long as its remainder stays
    /// below an eighth of the resolution; its modal terms sum up to `amplitude`.
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
        // Each track's `a_TAYLOR h^TAYLOR` is at most `allowed`, and `1.03^TAYLOR` is two.
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
                // A scale may overflow where there is nothing to be scaled.
                *c += if term == 0.0 { 0.0 } else { scale * term };
                scale *= h * rate / (k + 1) as f64;
            }
        }
        Window { h, q, modal, drift: self.drift.rounding(t + h) }
    }
}

/// A signal's view of its one track.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    signal: &'a Signal,
    factor: f64,
    rows: &'a EvaluationRows,
}

impl View<'_> {
    /// Looks at the signal, whose drift is a parabola at most, a tabulated span after the track's
    /// instant, and leaves the modal vector
    /// there in `spare`; with the bounds of `known` if that is given, which was seen earlier: they
    /// hold for all later times.
    #[inline]
    pub fn evaluate_ahead(
        &self,
        track: &Track,
        level: usize,
        known: Option<&Probe>,
        spare: &mut Vec<f64>,
    ) -> Probe {
        let Track { system, z, at } = track;
        let mut probe = Probe::of(self.signal.drift.at(at + System::tabulated(level)));
        let Some(known) = known else {
            probe.add(self.factor, system.evaluate_ahead(level, self.rows, z, spare));
            return probe;
        };
        let [value, slope] =
            system.evaluate_two_ahead(level, self.rows, z, spare).map(|x| self.factor * x);
        Probe { value: probe.value + value, slope: probe.slope + slope, ..*known }
    }
}

/// [`math::root`] is the one of a remainder.
const _: () = assert!(TAYLOR == math::ROOT);

const fn factorial(n: usize) -> f64 {
    let (mut product, mut k) = (1.0, 1);
    while k <= n {
        product *= k as f64;
        k += 1;
    }
    product
}
