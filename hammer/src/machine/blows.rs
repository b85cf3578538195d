//! Blows and collisions, and what each blow drilled.
//!
//! A *blow* is the first collision, at least as fast as `blow.minimum_speed`, after the start or after the piston has
//! risen by the share [`LEAST_RISE`] of its fall to the previous blow. Everything until then belongs to the previous
//! blow: later collisions of the same fall, slower bounces, and collisions of the rebounding bit with a piston that
//! rises, rests or drifts. After [`PATIENCE`] times the wait for the previous blow, any rise is enough.

use super::journal::Counters;
use crate::energy::peaks::Peaks;
use crate::laws::air::FREE_DENSITY;
use crate::laws::event::Displacement;
use crate::motion::Motion;
use crate::motion::state::Milestone;
use crate::numerics::instant::Double;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// A blow, and what happened since the previous blow (or since the start, if it is the first).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Blow {
    /// Instant of impact, s.
    pub time: f64,
    /// Relative mean speed at impact, m/s.
    pub speed: f64,
    /// `Mp speed^2 / 2`, J.
    pub energy: f64,
    /// Time since the previous blow, s (0 for the first blow).
    pub period: f64,
    /// Advance of the tip over that time, m (0 for the first blow).
    pub penetration: f64,
    /// `penetration / period`, m/s.
    pub tip_rate: f64,
    /// Advance of the tip per time from the first blow to the last, m/s.
    pub tip_rate_mean: f64,
    /// Work given to the rock (dissipated and viscous), J.
    pub rock_work: f64,
    /// Length of hole that this work drills, m. Each part of the work counts with the specific energy at that time.
    pub length: f64,
    /// Rate of penetration of the hole: `length / period`, m/s (0 for the first blow).
    pub rop: f64,
    /// Rate of penetration of the hole from the first blow to the last, m/s.
    pub rop_mean: f64,
    /// Free air consumed, m3; 0 for a drive without air.
    pub air: f64,
    /// `air / period`, m3/s (0 for the first blow).
    pub air_flow: f64,
    /// Duration of the last complete collision (first closing to last opening), s.
    pub contact_duration: f64,
    /// Forces, works and the rebound, if they are [recorded](crate::Machine::record_blows).
    pub account: Option<Account>,
}

/// Works and forces since the previous blow (or since the start, if it is the first).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Account {
    /// Last mean speed, positive upward, at which the piston left what it strikes, m/s.
    pub rebound_speed: f64,
    /// Largest forces.
    pub peaks: Peaks,
    /// Work of the drive, J.
    pub drive: f64,
    /// Work of gravity, J.
    pub gravity: f64,
    /// Work of the feed force, J.
    pub feed: f64,
    /// Energy dissipated in the rock on loading, J.
    pub rock_dissipated: f64,
    /// Work of the dashpot at the tip, J.
    pub viscous: f64,
    /// Energy lost in the bodies and in ties, J.
    pub damping: f64,
}

impl Account {
    /// The account of a blow that was not recorded.
    pub(crate) const UNKNOWN: Self = Self {
        rebound_speed: f64::NAN,
        peaks: Peaks::UNKNOWN,
        drive: f64::NAN,
        gravity: f64::NAN,
        feed: f64::NAN,
        rock_dissipated: f64::NAN,
        viscous: f64::NAN,
        damping: f64::NAN,
    };
}

impl Blow {
    /// The account; NaN for a blow that was not recorded.
    pub(crate) fn account(&self) -> Account {
        self.account.unwrap_or(Account::UNKNOWN)
    }
}

/// Least rise of the piston before a blow, as a share of its fall to the previous blow.
const LEAST_RISE: f64 = 0.02;

/// After this many times the wait for the last blow, any rise is enough. The fall to the last blow may have been
/// exceptionally long: from a great height at the start, or after the drive was vented. After the same wait a hammer
/// counts as [stalled](crate::Machine::stalled).
pub(super) const PATIENCE: f64 = 8.0;

/// Most blows of one communication step that are stored.
pub const MAX_STEP_BLOWS: usize = 1 << 16;

/// Collisions and blows so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Last blow.
    pub last: Blow,
    /// Blows of the present communication step.
    pub step: VecDeque<Blow>,
    /// Time and hole depth at the first blow, and at the last.
    pub milestones: [Option<Milestone>; 2],
    /// Start of the present or last collision.
    pub collision: Option<Double>,
    /// Work given to the rock since the last blow, J.
    pub given: f64,
    /// Length of hole drilled since the last blow, m: each part of that work over the specific energy of its time.
    pub advance: f64,
    /// Length of hole drilled since the start, then the part of it drilled before the first blow, m.
    pub drilled: [f64; 2],
    /// Air taken from the supply up to the last blow, kg.
    pub air_mass: f64,
    /// Last opening of the contact.
    pub opened: Option<Double>,
    /// The piston's travel since the last blow.
    pub way: Way,
    /// When the drive last began to act.
    pub acts_since: Double,
}

/// The travel of the piston's mean in the hole since the last blow or the start, positive downward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Way {
    /// Start of this travel.
    pub began: Double,
    /// Extreme positions, m.
    lowest: f64,
    highest: f64,
    /// Largest rise so far from the lowest position before it, m.
    rise: f64,
    /// The fall to the last blow, m, and the time since the blow before it or since the start, s.
    last: Option<[f64; 2]>,
}

impl Way {
    fn from(began: Double, place: f64, last: Option<[f64; 2]>) -> Self {
        Self { began, lowest: place, highest: place, rise: 0.0, last }
    }

    fn pass(&mut self, place: f64) {
        self.lowest = self.lowest.max(place);
        self.highest = self.highest.min(place);
        self.rise = self.rise.max(self.lowest - place);
    }

    /// True if a collision after a wait of this time may be a blow.
    fn is_ready(&self, waited: f64) -> bool {
        self.last.is_none_or(|[fall, wait]| {
            self.rise >= LEAST_RISE * fall || self.rise > 0.0 && waited > PATIENCE * wait
        })
    }

    /// Time that passed before the last blow, s.
    pub fn wait(&self) -> Option<f64> {
        self.last.map(|[_, wait]| wait)
    }
}

impl Progress {
    /// The state at the start.
    pub(crate) fn new(motion: &Motion) -> Self {
        let [place] = motion.piston_in_hole(0.0);
        let start = motion.state.epoch;
        Self { way: Way::from(start, place, None), acts_since: start, ..Self::default() }
    }

    pub(crate) fn instants(&self) -> impl Iterator<Item = Double> + '_ {
        let milestones = self.milestones.iter().flatten().map(|milestone| milestone.time);
        // Before the first blow, `last` has no time.
        let last = self.milestones[1].map(|_| Double::new(self.last.time));
        let step = self.step.iter().map(|blow| Double::new(blow.time));
        let own =
            [self.way.began, self.acts_since].into_iter().chain(self.collision).chain(self.opened);
        milestones.chain(own).chain(last).chain(step)
    }

    /// Follows the piston from the epoch to `at`, to which the tracks of all bodies that it touches are rotated. In
    /// flight its motion is a polynomial, so only the turning points and both ends are examined. In contact only the
    /// position at `at` is examined.
    pub(crate) fn note_stretch(&mut self, motion: &Motion, at: f64) {
        let course = motion.course().filter(|_| !motion.mode().closed());
        let course = course.filter(|course| course.piston_may_turn(at));
        let course = course.map(|course| course.poly([1.0, 0.0]));
        let flight = motion.flying().map(|index| &motion.state.anchors[index].driven.translation);
        let flight = course.as_ref().or(flight);
        let mut pass = |t| {
            let [place] = motion.piston_in_hole(t);
            self.way.pass(place);
        };
        match flight {
            Some(flight) if motion.is_steady() => flight.turn(at).into_iter().for_each(pass),
            Some(flight) if !flight.may_turn(at) => pass(at),
            Some(flight) => flight.turns(at).into_iter().for_each(pass),
            None => pass(at),
        }
    }

    /// Records that the contact opens at the epoch.
    pub(crate) fn note_opening(&mut self, motion: &Motion) {
        let epoch = motion.state.epoch;
        self.opened = Some(epoch);
        if let Some(start) = self.collision {
            self.last.contact_duration = epoch.since(start);
        }
    }

    /// Records that the contact closes at the epoch, to which the tracks are rotated. Counts the collision if it is
    /// new, and the blow if it is one. Returns true for a blow.
    pub(crate) fn note_closing(&mut self, motion: &Motion, counters: &mut Counters) -> bool {
        let epoch = motion.state.epoch;
        let same = 2.0 * motion.parameters().struck_transits();
        if self.opened.is_some_and(|opened| epoch.since(opened) <= same) {
            return false;
        }
        self.collision = Some(epoch);
        counters.contacts += 1;
        let [place, piston] = motion.piston_in_hole(0.0);
        self.way.pass(place);
        let [_, struck] = motion.rates(&motion.tracks, Displacement::STRUCK, 0.0);
        let (relative, waited) = (piston - struck, epoch.since(self.way.began));
        let fast = relative >= motion.parameters().blow.minimum_speed;
        let is_blow = piston > 0.0 && fast && self.way.is_ready(waited);
        if is_blow {
            let fall = place - self.way.highest;
            self.way = Way::from(epoch, place, Some([fall, waited]));
            counters.blows += 1;
            self.note_blow(motion, relative);
        }
        is_blow
    }

    /// Completes the record of the last blow.
    pub(crate) fn note_account(&mut self, account: Account) {
        self.last.account = Some(account);
        if let Some(blow) = self.step.back_mut().filter(|blow| blow.time == self.last.time) {
            *blow = self.last;
        }
    }

    /// Adds work given to the rock, J, and the length of hole that it drilled, m.
    pub(crate) fn note_work(&mut self, work: f64, length: f64) {
        self.given += work;
        self.advance += length;
        self.drilled[0] += length;
    }

    fn note_blow(&mut self, motion: &Motion, speed: f64) {
        let here = motion.milestone();
        let air_mass = motion.air().map_or(0.0, |air| air.sums.mass);
        let blow = &mut self.last;
        blow.account = None;
        blow.time = here.time.value();
        blow.speed = speed;
        blow.energy = 0.5 * motion.graph().bodies[0].mass * speed * speed;
        (blow.rock_work, blow.length) = (self.given, self.advance);
        blow.air = (air_mass - self.air_mass) / FREE_DENSITY;
        let advance = |from: &Milestone| (here.hole.since(from.hole), here.time.since(from.time));
        if let Some(last) = &self.milestones[1] {
            (blow.penetration, blow.period) = advance(last);
            blow.tip_rate = blow.penetration / blow.period;
            (blow.rop, blow.air_flow) = (blow.length / blow.period, blow.air / blow.period);
        }
        match &self.milestones[0] {
            Some(first) => {
                let (depth, time) = advance(first);
                blow.tip_rate_mean = depth / time;
                blow.rop_mean = (self.drilled[0] - self.drilled[1]) / time;
            }
            None => self.drilled[1] = self.drilled[0],
        }
        (self.given, self.advance, self.air_mass) = (0.0, 0.0, air_mass);
        if self.step.len() == MAX_STEP_BLOWS {
            self.step.pop_front();
        }
        self.step.push_back(self.last);
        self.milestones[0].get_or_insert(here);
        self.milestones[1] = Some(here);
    }
}
