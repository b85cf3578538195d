//! The search for the next event, which provably misses none.
//!
//! Each guard of the present mode is tracked as a function of time ([`mod@signal`]). [`tracker`]
//! states the theorem and holds the proof, which takes double steps where it can ([`ahead`]) and
//! uses Taylor polynomials where bounds are too coarse ([`window`]). [`barrier`] handles the energy
//! barrier, which is an integral.

mod ahead;
pub mod barrier;
mod course;
mod drift;
mod envelope;
pub(crate) mod positions;
pub mod signal;
mod steep;
pub mod tracker;
pub mod window;
pub(crate) mod work;

use crate::error::Error;
use crate::laws::event::RockEvent;
use crate::laws::event::{Displacement, Event, Guard};
use crate::motion::Motion;
use crate::numerics::poly::Poly;
use barrier::Barrier;
use course::Curves;
use drift::Drift;
use envelope::Envelope;
use signal::{Part, Signal};
use tracker::GuardTracker;
use work::{Budget, Work};

/// Events closer than this count as simultaneous, s.
pub const TIME_RESOLUTION: f64 = 1e-15;
/// Most consecutive steps of the guard whose proof extends least far.
const RUN: usize = 64;

/// A falling guard may start above its level by this many times the estimated rounding: 78 were observed, for slender
/// bodies whose masses differ by a factor of a million.
const FALLING: f64 = 4096.0;

/// The search for the event that ends the present mode.
#[derive(Debug, Default)]
pub(crate) struct Search {
    /// Guards of the present mode, followed by unused trackers whose memory is reused.
    trackers: Vec<(Event, GuardTracker)>,
    /// Number of guards of the present mode that are tracked.
    count: usize,
    /// Guards whose crossings are known without a tracker.
    crossings: Vec<(f64, Event)>,
    /// True if the guards that are not tracked cannot cross before the motion's polynomials end.
    others: bool,
    barrier: Option<Barrier>,
    /// Bounds on the guarded displacements within a window of the air.
    envelopes: Vec<Envelope>,
    known: Known,
    /// Work done so far.
    pub work: Work,
    /// Work that the present step may still spend.
    pub budget: Budget,
}

impl Search {
    /// Starts tracking the guards of the present mode from the epoch.
    pub fn start(&mut self, motion: &Motion) {
        (self.count, self.others) = (0, false);
        self.crossings.clear();
        self.envelopes.clear();
        let parameters = motion.parameters();
        let (mode, reach) = (motion.mode(), motion.reach());
        let (vr, working) = (Displacement::Relative, !mode.vented);
        let curves = Curves::new(motion);
        let mut track = |guard: Guard| {
            if let Some(curves) = &curves {
                self.others = true;
                let crossing = curves.crossing(&guard);
                self.crossings.extend(crossing.map(|at| (at, guard.event)));
                return;
            }
            let known = self.envelopes.iter().position(|envelope| envelope.is_of(&guard));
            let envelope = known.or_else(|| {
                let made = Envelope::new(motion, &guard, reach, &self.envelopes)?;
                self.envelopes.push(made);
                Some(self.envelopes.len() - 1)
            });
            let (mut signal, mut clear, mut root) = (None, [0.0; 2], None);
            if let Some(envelope) = envelope.map(|envelope| &self.envelopes[envelope]) {
                let resolution = motion.model.resolutions[guard.order];
                clear = envelope.clear(&guard, resolution, reach);
                if clear == [0.0, f64::INFINITY] {
                    self.others = true;
                    return;
                }
                if clear[0] == 0.0 {
                    root = envelope.crossing(&guard, resolution, [clear[1], reach]);
                }
                signal = Some(envelope.signal(&guard, resolution));
            }
            let signal = signal.unwrap_or_else(|| self::signal(motion, &guard)).within(reach);
            restart(&mut self.trackers, self.count, (guard.event, signal));
            let tracker = &mut self.trackers[self.count].1;
            (tracker.between, tracker.root) = (clear, root);
            self.count += 1;
        };
        // They are restarted in place, one after the other, because moving a tracker costs time.
        for edge in &motion.graph().ties {
            edge.law.guards(edge.tie, mode.ties.of(edge.tie)).for_each(&mut track);
        }
        parameters.vent_guard(&mode).into_iter().for_each(&mut track);
        mode.rock.guards(&parameters.rock, &motion.state.memory).for_each(&mut track);
        let relay = parameters.drive.guard(mode.relay, vr).filter(|_| working);
        relay.into_iter().for_each(&mut track);
        if let Some(air) = motion.air() {
            let (end, now) = (parameters.cylinder_end(mode.vented), [air.shut, mode.vented]);
            parameters.air.guards(&air.openings, now, end, |direction, level, event| {
                track(Guard { displacement: vr, order: 0, direction, level, event });
            });
        }
        self.barrier = mode.rock.is_viscous().then(|| Barrier::start(motion)).flatten();
        self.known.restart(self.count);
        self.known.first = self.crossings.iter().copied().reduce(first);
        for place in 0..self.count {
            if self.trackers[place].1.root.is_some() {
                self.record_root(place);
            }
        }
        self.record_barrier();
    }

    /// The guards of the present mode.
    #[cfg(feature = "internals")]
    pub fn tracked(&self) -> impl Iterator<Item = (Event, Signal)> {
        self.trackers[..self.count].iter().map(|(event, tracker)| (*event, tracker.signal.clone()))
    }

    /// The viscous form at the anchor of the tip's track, and the viscous work up to `at`, as far as the barrier's
    /// search computed them.
    pub fn viscous(&self, at: f64) -> [Option<f64>; 2] {
        let Some(barrier) = &self.barrier else { return [None; 2] };
        let ended = barrier.ended.filter(|[end, _]| *end == at);
        [Some(barrier.form).filter(|form| *form > 0.0), ended.map(|[_, done]| done)]
    }

    /// True if the barrier's search summed the work up to the instant of the tip's track from series, so that the
    /// ledger must do the same.
    pub fn sums_series(&self, motion: &Motion) -> bool {
        let barrier = self.barrier.as_ref().zip(motion.tracks.first());
        barrier.is_some_and(|(barrier, tip)| barrier.sums(tip))
    }

    pub fn stop(&mut self) {
        self.count = 0;
        self.barrier = None;
    }

    /// Rotates the tip's track to `at`, starting from the guard's copy that is nearest. (When the barrier is reached,
    /// it starts from the anchor, since the copies' instants then depend on the host's steps.)
    pub fn bring_tip(&mut self, motion: &mut Motion, at: f64) {
        if motion.course().is_some() {
            return; // There are no tracks.
        }
        let is_barrier = self.barrier.as_ref().is_some_and(|barrier| barrier.root == Some(at));
        motion.return_to_anchors(if is_barrier { f64::NEG_INFINITY } else { at });
        let guards = if is_barrier { 0 } else { self.count };
        let copies = self.trackers[..guards].iter_mut().filter_map(|(_, tracker)| tracker.own());
        let tips = copies.filter(|(index, track)| *index == 0 && track.at <= at);
        let nearest = tips.map(|(_, track)| track).max_by(|a, b| a.at.total_cmp(&b.at));
        let tip = &mut motion.tracks[0];
        if let Some(track) = nearest.filter(|track| track.at > tip.at) {
            std::mem::swap(track, tip);
        }
        self.work.samples += motion.tracks[0].rotate_to(at);
    }

    /// True if [`Self::next`] has already proved that there is no event up to `target`.
    pub fn is_clear(&self, target: f64) -> bool {
        self.known.first.is_none_or(|(at, _)| target < at)
            && self.known.clear.iter().all(|clear| target < *clear)
            && self.barrier.as_ref().is_none_or(|barrier| barrier.waits <= 0.0)
    }

    /// The first event up to `target`: its time after the epoch, and its kind. The target must lie
    /// within the motion's [reach](Motion::reach).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Overwork`], [`Error::Cancelled`].
    pub fn next(
        &mut self,
        motion: &mut Motion,
        target: f64,
    ) -> Result<Option<(f64, Event)>, Error> {
        loop {
            let first = self.known.first;
            let (least, place, next) = self.known.front();
            self.check(motion, first.map_or(least, |(at, _)| at.min(least)))?;
            let limit = first.map_or(target, |(at, _)| at.min(target));
            // A guard that is clear up to the limit may still cross at the limit.
            let settled = first.is_some_and(|(at, _)| at <= target);
            let open = |clear: f64| if settled { clear < limit } else { clear <= limit };
            let ends = !open(least);
            if ends && !self.barrier.as_ref().is_some_and(|barrier| barrier.waits > 0.0) {
                return Ok(first.filter(|(at, _)| *at <= target));
            }
            let tracker = self.trackers[..self.count].get_mut(place).filter(|_| !ends);
            let Some((_, tracker)) = tracker else {
                if ends && settled {
                    self.bring_tip(motion, limit);
                }
                self.extend_barrier(motion, ends.then_some(limit));
                continue;
            };
            tracker.limit(first.map_or(f64::INFINITY, |(at, _)| at), next.min(limit));
            for _ in 0..RUN {
                tracker.extend(&mut motion.tracks, &mut self.work);
                if let Some(beyond) = tracker.beyond
                    && tracker.root.is_some()
                {
                    re_arm(motion, tracker, beyond);
                }
                if tracker.root.is_some() || !(tracker.clear < next && open(tracker.clear)) {
                    break;
                }
            }
            // NaN becomes minus infinity, so that comparisons find it.
            self.known.clear[place] = tracker.clear.max(f64::NEG_INFINITY);
            if tracker.root.is_some() {
                self.record_root(place);
            }
        }
    }

    /// Records the crossing of the guard at `place`, and whether it is the first of all.
    fn record_root(&mut self, place: usize) {
        self.known.clear[place] = f64::INFINITY;
        let guards = self.trackers[..self.count].iter();
        let found = guards.filter_map(|(event, tracker)| Some((tracker.root?, *event)));
        let crossings = self.crossings.iter().copied().chain(found);
        let barrier = self.barrier.as_ref().and_then(|barrier| barrier.root);
        let barrier = barrier.map(|at| (at, Event::Rock(RockEvent::Barrier)));
        self.known.first = crossings.chain(barrier).reduce(first);
    }

    fn record_barrier(&mut self) {
        let Some(barrier) = &self.barrier else { return };
        self.known.clear[self.count] = barrier.clear.max(barrier.waits);
        if barrier.root.is_some() {
            self.record_root(self.count);
        }
    }

    /// Returns an error if the step's work is spent, or if instants are no longer finite.
    #[inline]
    fn check(&self, motion: &Motion, horizon: f64) -> Result<(), Error> {
        let time = motion.state.epoch.value();
        if horizon == f64::NEG_INFINITY {
            return Err(Error::NotFinite { time });
        }
        self.budget.check(motion, &self.work, time + horizon)
    }

    /// The same check for a second search, which has spent `work` and is proved up to `horizon`.
    pub fn check_beside(&self, motion: &Motion, work: &Work, horizon: f64) -> Result<(), Error> {
        self.budget.check(motion, work, motion.state.epoch.value() + horizon)
    }

    fn extend_barrier(&mut self, motion: &Motion, end: Option<f64>) {
        if let Some(barrier) = &mut self.barrier {
            barrier.extend(motion, end, &mut self.work);
        }
        self.record_barrier();
    }

    /// True if bounds alone prove that no event of this rank ever happens under the present loads; false if no guard of
    /// this rank is tracked.
    pub fn never(&self, motion: &Motion, rank: u8) -> bool {
        let tracks = motion.present();
        let mut tracked =
            self.trackers[..self.count].iter().filter(|(e, _)| e.rank() == rank).peekable();
        !self.others
            && tracked.peek().is_some()
            && tracked.all(|(_, w)| w.root.is_none() && w.never(&tracks))
    }
}

/// Puts a guard that starts at the epoch in the place `count`. The memory of the tracker there is reused.
fn restart(
    trackers: &mut Vec<(Event, GuardTracker)>,
    count: usize,
    (event, signal): (Event, Signal),
) {
    match trackers.get_mut(count) {
        Some(tracked) => {
            tracked.0 = event;
            tracked.1.restart(signal, 0.0);
        }
        None => trackers.push((event, GuardTracker::new(signal, 0.0))),
    }
}

/// Re-arms a guard that started above zero only because of rounding. A falling guard was at zero just before, so it may
/// start above the estimated rounding.
fn re_arm(motion: &Motion, tracker: &mut GuardTracker, [value, slope]: [f64; 2]) {
    let Signal { parts, order, .. } = tracker.signal;
    let of = |part: Part| motion.rounding(part.track, part.functional, order);
    let rounding: f64 = parts.into_iter().flatten().map(of).sum();
    if value <= if slope < 0.0 { FALLING * rounding } else { rounding } {
        tracker.re_arm();
    }
    tracker.beyond = None;
}

/// How far the proof of each guard extends. The energy barrier comes last, after all guards.
#[derive(Debug, Default)]
struct Known {
    /// The instant up to which each guard is clear; infinite if its crossing is known.
    clear: Vec<f64>,
    /// The earliest crossing, and the first in order of simultaneous crossings.
    first: Option<(f64, Event)>,
}

impl Known {
    fn restart(&mut self, guards: usize) {
        self.clear.clear();
        self.clear.resize(guards, 0.0);
        self.clear.push(f64::INFINITY);
        self.first = None;
    }

    /// The least instant up to which a guard is clear (minus infinity for NaN), the place of that guard, and the
    /// instant up to which all others are clear.
    #[inline]
    fn front(&self) -> (f64, usize, f64) {
        let (mut least, mut place, mut next) = (f64::INFINITY, 0, f64::INFINITY);
        for (i, &clear) in self.clear.iter().enumerate() {
            if clear < least {
                (least, place, next) = (clear, i, least);
            } else if clear < next {
                next = clear;
            }
        }
        (least, place, next)
    }
}

/// The earlier of two crossings, or the first in order if they are simultaneous.
pub fn first(one: (f64, Event), other: (f64, Event)) -> (f64, Event) {
    let tie = (one.0 - other.0).abs() <= TIME_RESOLUTION;
    let precedes = if tie { other.1.rank() < one.1.rank() } else { other.0 < one.0 };
    if precedes { other } else { one }
}

/// A guard of the present mode as a function of time after the epoch, rising through zero.
fn signal(motion: &Motion, guard: &Guard) -> Signal {
    let Guard { displacement, order, .. } = *guard;
    let factor = guard.direction.sign();
    let resolution = motion.model.resolutions[order];
    let level = guard.level - if order == 0 { motion.ahead(displacement) } else { 0.0 };
    let (mut parts, mut drift, mut is_calm) = ([None; 2], [0.0; 3], true);
    for (part, (track, functional)) in parts.iter_mut().zip(motion.shares(displacement)) {
        *part = Some(Part { track, functional, factor });
        is_calm = is_calm && motion.is_calm(track);
        if is_calm {
            let functional = &motion.tracks[track].system.functionals[functional];
            let moved = &motion.state.anchors[track].driven.translation;
            functional.add_parabola(&motion.state.loads, moved, factor, &mut drift);
        }
    }
    let is_rate = order == 1;
    if is_calm {
        if is_rate {
            drift = [drift[1], 2.0 * drift[2], 0.0];
        }
        drift[0] -= factor * level;
        // A part that does not oscillate belongs to the drift. (This applies only to displacements that involve a
        // frame: for others it would change the steps of the track's rotations, and with them the rounding.)
        if motion.graph().is_of_frame(displacement) {
            let system = |part: &Part| &motion.tracks[part.track].system;
            let moves = |part: &Part| !system(part).functionals[part.functional].still;
            let [one, other] = parts.map(|part| part.filter(moves));
            parts = [one.or(other), one.and(other)];
        }
        return Signal::over(Drift::parabola(drift), parts, order, resolution);
    }
    let sum = |sum: Poly, part: Part| sum.plus(factor, &motion.poly(part.track, part.functional));
    let mut poly = parts.into_iter().flatten().fold(Poly::default(), sum);
    if is_rate {
        poly = poly.derivative();
    }
    poly.0[0] -= factor * level;
    Signal::new(poly, parts, order, resolution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::mode::Relay;

    /// Events closer than the resolution of time are simultaneous: contact then comes before rock, and rock before
    /// drive. Other events are in the order of time.
    #[test]
    fn of_events_at_one_instant_the_first_in_order_comes_first() {
        let events = [Event::CLOSING, Event::Rock(RockEvent::Touch), Event::Relay(Relay::Drive)];
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            for (apart, earlier) in [(0.0, i), (0.5, i), (-0.5, i), (2.0, i), (-2.0, j)] {
                // The event that is second in order is this many resolutions later, or earlier if negative.
                let pair = [(1e-3, events[i]), (1e-3 + apart * TIME_RESOLUTION, events[j])];
                let expected = pair[usize::from(earlier == j)];
                assert_eq!(first(pair[0], pair[1]), expected, "{pair:?}");
                assert_eq!(first(pair[1], pair[0]), expected, "{pair:?}");
            }
        }
    }
}
