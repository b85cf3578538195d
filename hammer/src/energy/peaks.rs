//! Largest forces over the last communication step.
//!
//! They are computed on demand. The intervals of the step are stored, and each is scanned by Taylor windows
//! ([`crate::search::tracker`]), on which a force is a polynomial.

use crate::allowance::Allowance;
use crate::energy::deferred::{Deferred, DeferredLedger};
use crate::energy::interval::{self, Interval};
use crate::energy::modes::Force;
use crate::error::{Error, WorkLimit};
use crate::interrupt;
use crate::laws::mode::Tie;
use crate::modal::system::TAYLOR;
use crate::modal::system::generator::Generator;
use crate::modal::track::Track;
use crate::motion::Motion;
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::search::signal::{Part, Signal};
use crate::search::window::{EVALUATIONS, Window, maximum, step_below};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The error of a peak corresponds to a displacement of this many guard resolutions.
const COARSE: f64 = 10.0;
/// The first windows and steps of an interval are not charged; a collision of a damped hammer needs no more. They
/// cannot add up to unlimited work, because the search limits the number of intervals in a step.
const FREE: usize = 64;
/// Limit of the work of one communication step beyond [`FREE`], in modal coordinates, to which each window adds
/// [`WINDOW`]. It takes one core half a second to a second.
const BUDGET: u64 = 50_000_000;
/// Cost of a window in addition to its modal vector, in coordinates.
const WINDOW: u64 = 64;
/// Shortest step by bounds, in radians of the fastest mode. A window is a few radians long and costs as much as three
/// steps, so it replaces shorter ones.
const SHORT_STEP: f64 = 1.0;
/// Cost of one more value of a window's polynomial, in coordinates. It is 70 to 120 instructions: a chain of [`TAYLOR`]
/// products and sums, and the bounds. A flat maximum takes thousands of values.
const EVALUATION: u64 = 16;
/// A step costs a window's cost divided by this: a third, rounded up.
const STEP: u64 = 2;

/// Largest forces over the last communication step, N: `F_R`, followed by those of the ties in [`Tie::REPORTED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peaks(pub(crate) [f64; 1 + Tie::REPORTED.len()]);

impl Peaks {
    /// Peaks that could not be found.
    pub(crate) const UNKNOWN: Self = Self([f64::NAN; 1 + Tie::REPORTED.len()]);

    /// Largest rock force `F_R`.
    pub fn rock_force(&self) -> f64 {
        self.0[0]
    }

    /// Largest force of a tie, if it is reported.
    pub fn tie_force(&self, tie: Tie) -> f64 {
        let ties = Tie::REPORTED.into_iter().zip(&self.0[1..]);
        ties.filter(|(other, _)| *other == tie).fold(0.0, |_, (_, force)| *force)
    }

    /// Largest contact force `F_C`.
    pub fn contact_force(&self) -> f64 {
        self.tie_force(Tie::Contact)
    }
}

/// An interval whose peaks are not yet found.
#[derive(Clone, Debug)]
pub struct Pending {
    of: Arc<Deferred>,
    /// Start of the communication step, after the start of the interval, s.
    start: f64,
    /// Allowed error of a displacement, m.
    resolution: f64,
}

/// Peaks of the intervals that were searched, and the work of the search. How often the peaks are read does not affect
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Searched {
    peaks: Peaks,
    work: u64,
}

/// Peaks up to the last event, as a state stores them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Recorded {
    searched: Searched,
    start: f64,
}

/// Search for the peaks of the present step, or since the last blow. It is serialised with the peaks that it finds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(from = "Recorded", into = "Recorded")]
pub(crate) struct PeakSearch {
    /// Intervals whose peaks are not yet found.
    pending: Vec<Pending>,
    /// Numbers stored in them.
    pub size: usize,
    /// Peaks of the intervals before the pending ones.
    searched: Searched,
    /// Start of the search after the epoch, s (0 if it is earlier).
    pub start: f64,
}

impl From<Recorded> for PeakSearch {
    fn from(Recorded { searched, start }: Recorded) -> Self {
        Self { searched, start, ..Self::default() }
    }
}

impl From<PeakSearch> for Recorded {
    fn from(search: PeakSearch) -> Self {
        Self { searched: search.recorded(), start: search.start }
    }
}

impl PartialEq for PeakSearch {
    fn eq(&self, other: &Self) -> bool {
        (self.recorded(), self.start) == (other.recorded(), other.start)
    }
}

impl PeakSearch {
    /// Begins a new step at the present.
    pub fn begin_step(&mut self, motion: &Motion) {
        self.pending.clear(); // Its memory is reused.
        (self.size, self.searched, self.start) = (0, Searched::default(), motion.state.now);
    }

    /// Stores an interval that starts at the epoch.
    pub fn record(&mut self, motion: &Motion, of: &Arc<Deferred>) {
        let interval = &of.interval;
        if interval.is_pressed() {
            self.size += interval.size();
            self.pending.push(Pending::new(motion, of.clone(), self.start));
        }
        self.start = (self.start - interval.span).max(0.0);
    }

    /// Searches the stored intervals if they are many. Intervals that an interrupt leaves are searched at the next
    /// call.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn work_off(&mut self) -> Result<(), Error> {
        if self.size <= interval::storable() {
            return Ok(());
        }
        let searched = &mut self.searched;
        let goes_on = |pending: &&Pending| {
            let mut after = *searched;
            pending.fold(&mut after);
            let is_whole = !interrupt::is_set();
            if is_whole {
                *searched = after;
            }
            is_whole
        };
        let done = self.pending.iter().take_while(goes_on).count();
        self.pending.drain(..done);
        self.size = self.pending.iter().map(|pending| pending.of.interval.size()).sum();
        if self.pending.is_empty() { Ok(()) } else { Err(Error::Cancelled) }
    }

    /// Peaks of the step up to the epoch.
    pub fn recorded(&self) -> Searched {
        let mut searched = self.searched;
        for pending in &self.pending {
            pending.fold(&mut searched);
        }
        searched
    }

    /// Peaks of the step up to the present.
    ///
    /// # Errors
    /// [`Error::Overwork`] beyond [`BUDGET`]; [`Error::Cancelled`].
    pub fn now(&self, motion: &Motion) -> Result<Peaks, Error> {
        let mut searched = self.recorded();
        // Windows proceed from the start, so the state at the end is not needed.
        let mut alone = DeferredLedger::default();
        let of = alone.defer(|| Interval::whole(motion, &motion.tracks, motion.state.now));
        Pending::new(motion, of.clone(), self.start).fold(&mut searched);
        Error::if_interrupted()?;
        searched.outcome(motion)
    }
}

impl Pending {
    fn new(motion: &Motion, of: Arc<Deferred>, start: f64) -> Self {
        Self { of, start, resolution: COARSE * motion.model.resolutions[0] }
    }

    fn fold(&self, searched: &mut Searched) {
        let interval = &self.of.interval;
        let Some(modes) = interval.modes() else { return self.fold_whole(searched) };
        let forces = interval.forces(modes);
        if searched.is_over() || forces.iter().all(Option::is_none) {
            return;
        }
        let Searched { peaks, work } = searched;
        for (force, best) in forces.iter().zip(&mut peaks.0) {
            if let Some(force) = force {
                let mut track = modes.track(force);
                track.rotate_to(self.start);
                *best = self.peak(force, &track, *best, work);
            }
        }
    }

    /// [`Self::fold`] where the forces are polynomials.
    fn fold_whole(&self, searched: &mut Searched) {
        let forces = self.of.interval.whole_forces(self.start);
        for (force, best) in forces.iter().zip(&mut searched.peaks.0) {
            if let Some(force) = force.as_ref().filter(|_| searched.work <= BUDGET) {
                let (highest, evaluations) = maximum(force, *best);
                *best = highest;
                let cost = EVALUATION * evaluations;
                searched.work = searched.work.saturating_add(cost);
                if evaluations == EVALUATIONS || !Allowance::spend(cost) {
                    searched.work = u64::MAX;
                }
            }
        }
    }

    /// The larger of `best` and the force's maximum over the interval, from the track `start` on. The search ends early
    /// if `work` exceeds [`BUDGET`], if the call's [`Allowance`] is spent, or if an interrupt comes.
    fn peak(&self, force: &Force, start: &Track, mut best: f64, work: &mut u64) -> f64 {
        let (mut track, end) = (start.clone(), self.of.interval.span);
        let part = Part { track: 0, functional: force.functional, factor: 1.0 };
        let guard = Signal::new(force.poly, [Some(part), None], 0, self.resolution);
        let (whole, rate) = (track.z.len() as u64 + WINDOW, track.system.rate_max);
        let rates = force.rates();
        for round in 0.. {
            let t = track.at;
            let ceiling = force.ceiling(&rates[0], &track, [t, end]);
            if ceiling <= best || *work > BUDGET || interrupt::is_set() {
                break;
            }
            let below = force.step_below(&rates[1..], &track, [t, end], best);
            if t + below >= end {
                break;
            }
            let step = Some(below).filter(|below| below * rate > SHORT_STEP);
            let step = step.and_then(Generator::level_below);
            let cost = if step.is_some() { whole / STEP } else { whole };
            if !Allowance::spend(cost) {
                *work = u64::MAX;
                break;
            }
            if round >= FREE {
                *work = work.saturating_add(cost);
            }
            if let Some((level, length)) = step {
                track.system.generator.rotate_level(level, &mut track.z);
                track.at += length;
                continue;
            }
            let Window { h, q, .. } = guard.expand(std::slice::from_ref(&track), t, 0.0);
            let last = ((end - t) / h).clamp(0.0, 1.0);
            let (highest, evaluations) = maximum(&force.along(&q, h, last), best);
            best = highest;
            let cost = EVALUATION * evaluations;
            *work = work.saturating_add(cost);
            if evaluations == EVALUATIONS || !Allowance::spend(cost) {
                *work = u64::MAX;
                break;
            }
            if t + h >= end {
                break;
            }
            track.rotate_to(t + h);
        }
        best
    }
}

impl Searched {
    fn is_over(&self) -> bool {
        self.work > BUDGET
    }

    pub fn outcome(&self, motion: &Motion) -> Result<Peaks, Error> {
        if !self.is_over() {
            return Ok(self.peaks);
        }
        let (time, mode) = (motion.state.time, motion.mode());
        let suspect = motion.parameters().suspect();
        Err(Error::Overwork { time, limit: WorkLimit::Peaks, mode, suspect, work_limit: None })
    }
}

impl Force {
    /// The first three rates of the polynomial part.
    fn rates(&self) -> [Poly; 3] {
        let mut rate = self.poly;
        std::array::from_fn(|_| {
            rate = rate.derivative();
            rate
        })
    }

    /// How long after `t`, to which the track is rotated, the force is certain to stay below `level`. The proof uses
    /// the force's value, its rate and a bound on its second derivative up to `end`, s. `bends` are the second and
    /// third rate of the polynomial part.
    fn step_below(&self, bends: &[Poly], track: &Track, [t, end]: [f64; 2], level: f64) -> f64 {
        let f = &track.system.functionals[self.functional];
        let drift: [f64; 3] = self.poly.derivatives_at(t);
        let [u, v, a] = std::array::from_fn(|k| drift[k] + kernel::dot(&f.rows[k], &track.z));
        let wave = |k: usize| kernel::bound(&f.weights[k], &track.z);
        let bound = self.stiffness.abs() * (largest(&bends[0], [t, end]) + wave(2))
            + self.viscosity.abs() * (largest(&bends[1], [t, end]) + wave(3));
        let of = |x: f64, rate: f64| self.stiffness * x + self.viscosity * rate;
        let room = level - of(u, v);
        if room > 0.0 { step_below(room, of(v, a), bound) } else { 0.0 }
    }

    /// Bound on the force from `t` to `end`. `rate` is the rate of the force's polynomial part.
    fn ceiling(&self, rate: &Poly, track: &Track, [t, end]: [f64; 2]) -> f64 {
        let f = &track.system.functionals[self.functional];
        let (drift, span) = (largest(rate, [t, end]), end - t);
        let wave = |k: usize| kernel::bound(&f.weights[k], &track.z);
        self.stiffness * self.poly.at(t)
            + self.stiffness.abs() * (drift * span + wave(0))
            + self.viscosity.abs() * (drift + wave(1))
    }

    /// The force's polynomial over the part `[0, last]` of a window, in time over that part.
    fn along(&self, q: &[f64; TAYLOR], h: f64, last: f64) -> [f64; TAYLOR] {
        let mut power = 1.0;
        std::array::from_fn(|k| {
            let rate = q.get(k + 1).map_or(0.0, |c| (k + 1) as f64 * c / h);
            let coefficient = power * (self.stiffness * q[k] + self.viscosity * rate);
            power *= last;
            coefficient
        })
    }
}

/// Bound on a polynomial between two instants.
fn largest(poly: &Poly, [from, to]: [f64; 2]) -> f64 {
    if *poly == Poly::default() {
        return 0.0;
    }
    let terms = poly.shifted(from).0;
    terms.iter().enumerate().map(|(k, c)| c.abs() * math::powi(to - from, k)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::interval::CROWDED;
    use crate::machine::Machine;
    use crate::quantities::inputs::Input;
    use crate::quantities::parameters::{Fidelity, InputValues, Parameters};
    use crate::scene::Scene;

    /// If no coefficient is negative, the bound is the value at the end.
    #[test]
    fn largest_is_the_end_of_what_only_grows() {
        let mut poly = Poly::default();
        (poly.0[0], poly.0[2], poly.0[4]) = (5.0, 7.0, 0.5);
        let poly = poly.shifted(-2.0);
        let end = 5.0 + 7.0 * 9.0 + 0.5 * 81.0;
        assert!((largest(&poly, [2.0, 5.0]) - end).abs() < 1e-12 * end);
    }

    /// Steps and ceilings are compared with the force itself at 40 instants of each interval. The scene has a casing
    /// whose loads grow so fast that bounds on waves alone would not suffice. The rounding of a sum of modes is less
    /// than 1e-12 of the largest force.
    #[test]
    fn forces_stay_below_their_bounds() {
        let mut steps = 0;
        for (fidelity, feed) in [
            (Fidelity::Rigid, [5e3, 2e7, 0.0, 0.0]),
            (Fidelity::Rigid, [5e3, 0.0, 5e10, 0.0]),
            (Fidelity::Elastic, [5e3, 1e8, 0.0, 3e17]),
        ] {
            let mut parameters = Parameters { fidelity, ..Parameters::default() };
            parameters.casing.mass = 40.0;
            let mut m = Machine::new(&parameters, &InputValues::default(), 0.0).expect("a scene");
            m.set_input(Input::FeedForce, &feed).expect("an input");
            for step in 0..30 {
                m.advance(5e-6 * f64::from(step)).expect("a step");
                let (now, span) = (m.motion().state.now, 2e-5);
                let interval = Interval::whole(m.motion(), &m.motion().tracks, now + span);
                let modes = interval.modes().expect("no air");
                for force in interval.forces(modes).into_iter().flatten() {
                    let at = |t: f64| {
                        let mut track = modes.track(&force);
                        track.rotate_to(t);
                        let f = &track.system.functionals[force.functional];
                        let [u, v] = [0, 1].map(|k| {
                            force.poly.derivatives_at::<3>(t)[k] + kernel::dot(&f.rows[k], &track.z)
                        });
                        (force.stiffness * u + force.viscosity * v, track)
                    };
                    let end = now + span;
                    let (first, track) = at(now);
                    let rates = force.rates();
                    let ceiling = force.ceiling(&rates[0], &track, [now, end]);
                    let places = (0..=40).map(|i| f64::from(i) / 40.0);
                    let most = places.clone().map(|x| at(now + x * span).0).fold(first, f64::max);
                    let rounding = 1e-12 * most.abs().max(first.abs());
                    assert!(most <= ceiling + rounding, "{most} above {ceiling}");
                    for part in [0.01, 0.1, 0.5, 1.0] {
                        let level = first + part * (most - first);
                        let below = force.step_below(&rates[1..], &track, [now, end], level);
                        let below = below.min(span);
                        let highest = places.clone().map(|x| at(now + x * below).0);
                        let highest = highest.fold(first, f64::max);
                        assert!(highest <= level + rounding, "{highest} above {level}");
                        steps += usize::from(below > 0.0);
                    }
                }
            }
        }
        assert!(steps > 300, "{steps}");
    }

    /// A communication step of 1 s, with some 900 intervals.
    fn second() -> Machine {
        let mut machine = Scene::default().machine().expect("a scene");
        machine.advance(1.0).expect("a step");
        machine
    }

    #[test]
    fn among_many_hammers_each_stores_little_and_reads_the_same() {
        let alone = second();
        assert!(
            alone.stored().iter().all(|&size| size > 4 * CROWDED),
            "one hammer alone integrates nothing"
        );
        // Hammers of 1.5 MB each, until 32 MB are stored.
        let mut others: Vec<Machine> = (0..30).map(|_| second()).collect();
        let last = others.pop().expect("thirty");
        // The limit is checked between intervals, so the last one may exceed it.
        let most = CROWDED + 1000;
        assert!(last.stored().iter().all(|&size| size <= most), "{:?}", last.stored());
        assert_eq!(last.energies(), alone.energies());
        assert_eq!(last.impulses(), alone.impulses());
        assert_eq!(last.peaks(), alone.peaks());
    }
}
