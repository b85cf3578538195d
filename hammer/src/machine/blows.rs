//! Blows and collisions, and what each blow drilled.
//!
//! A *blow* is the first collision, at least as fast as `blow.minimum_speed`, since the start or since the piston's
//! mean velocity turned from upward to downward. Everything until the piston has risen and falls again belongs to it:
//! later collisions of the same fall, slower bounces, and collisions of the rebounding bit with the rising piston.

use super::journal::Counters;
use crate::laws::air::FREE_DENSITY;
use crate::laws::event::Displacement;
use crate::motion::Motion;
use crate::motion::state::Milestone;
use crate::numerics::instant::Double;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// The last blow, and the drilling so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blow {
    /// Instant of impact, s.
    pub time: f64,
    /// Relative mean speed at impact, m/s.
    pub speed: f64,
    /// `Mp speed^2 / 2`, J.
    pub energy: f64,
    /// Time since the previous blow, s (0 for the first blow).
    pub period: f64,
    /// Advance of the tip over the last complete blow period, m.
    pub penetration: f64,
    /// `penetration / period`, m/s.
    pub tip_rate: f64,
    /// Advance of the tip per time from the first blow to the last, m/s.
    pub tip_rate_mean: f64,
    /// Work given to the rock (dissipated and viscous) over the last complete blow period, J.
    pub rock_work: f64,
    /// Rate of penetration of the hole: the length that this work drills, by specific energy, per
    /// period, m/s.
    pub rop: f64,
    /// The same from the first blow to the last, m/s.
    pub rop_mean: f64,
    /// Free air taken over the last complete blow period per that period, m3/s; 0 of another drive.
    pub air_flow: f64,
    /// Duration of the last complete collision (first closing to last opening), s.
    pub contact_duration: f64,
}

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
    /// Length of hole drilled since the start, and up to the first blow, m.
    pub drilled: [f64; 2],
    /// Air taken from the supply up to the last blow, kg.
    pub air_mass: f64,
    /// Last opening of the contact.
    pub opened: Option<Double>,
    /// True if the present fall has had its blow. The piston must rise before the next.
    pub spent: bool,
}

impl Progress {
    pub(crate) fn instants(&self) -> impl Iterator<Item = Double> + '_ {
        let milestones = self.milestones.iter().flatten().map(|milestone| milestone.time);
        // Before the first blow the last one has no time.
        let last = self.milestones[1].map(|_| Double::new(self.last.time));
        let step = self.step.iter().map(|blow| Double::new(blow.time));
        milestones.chain(self.collision).chain(self.opened).chain(last).chain(step)
    }

    /// Records whether the piston rises between the epoch and `at`, to which the tracks of all that it touches are
    /// rotated. In flight its velocity is a polynomial, and any rise is found. In contact only the velocity at `at`
    /// is examined.
    pub(crate) fn note_stretch(&mut self, motion: &Motion, at: f64) {
        if !self.spent {
            return;
        }
        let slowest = match motion.flying() {
            Some(index) => {
                let driven = &motion.state.anchors[index].driven;
                driven.translation.derivative().least(at)
            }
            None => motion.rates::<2>(&motion.tracks, Displacement::PISTON, at)[1],
        };
        self.spent = slowest >= 0.0;
    }

    /// The contact opens at the epoch.
    pub(crate) fn note_opening(&mut self, motion: &Motion) {
        let epoch = motion.state.epoch;
        self.opened = Some(epoch);
        if let Some(start) = self.collision {
            self.last.contact_duration = epoch.since(start);
        }
    }

    /// The contact closes at the epoch, to which the tracks are rotated. Counts a new collision, and a blow.
    pub(crate) fn note_closing(&mut self, motion: &Motion, counters: &mut Counters) {
        let epoch = motion.state.epoch;
        let same = 2.0 * motion.parameters().struck_transits();
        if self.opened.is_some_and(|opened| epoch.since(opened) <= same) {
            return;
        }
        self.collision = Some(epoch);
        counters.contacts += 1;
        let speed = |mean| motion.rates::<2>(&motion.tracks, mean, 0.0)[1];
        let piston = speed(Displacement::PISTON);
        let relative = piston - speed(Displacement::STRUCK);
        let fast = relative >= motion.parameters().blow.minimum_speed;
        if piston > 0.0 && !self.spent && fast {
            self.spent = true;
            counters.blows += 1;
            self.note_blow(motion, relative);
        }
    }

    /// Work given to the rock, J, and the length of hole that it drilled, m.
    pub(crate) fn note_work(&mut self, work: f64, length: f64) {
        self.given += work;
        self.advance += length;
        self.drilled[0] += length;
    }

    fn note_blow(&mut self, motion: &Motion, speed: f64) {
        let here = motion.milestone();
        let air_mass = motion.air().map_or(0.0, |air| air.sums.mass);
        let blow = &mut self.last;
        blow.time = here.time.value();
        blow.speed = speed;
        blow.energy = 0.5 * motion.graph().bodies[0].mass * speed * speed;
        let advance = |from: &Milestone| (here.hole.since(from.hole), here.time.since(from.time));
        if let Some(last) = &self.milestones[1] {
            (blow.penetration, blow.period) = advance(last);
            blow.tip_rate = blow.penetration / blow.period;
            (blow.rock_work, blow.rop) = (self.given, self.advance / blow.period);
            blow.air_flow = (air_mass - self.air_mass) / FREE_DENSITY / blow.period;
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
