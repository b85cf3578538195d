//! Ends of a step that a host asked for: at each blow, and where the piston passes a position.
//!
//! ```text
//! blow        the step ends at the event, whose instant is the blow's
//! position    the step ends at the first double t not before the passage at which the position
//!             that is read is the level or beyond it
//! ```
//!
//! In both cases the state is only read: the motion stays the same, bit for bit.

use crate::error::Error;
use crate::machine::Machine;
use crate::machine::outputs::Kinematics;
use crate::search::positions::Positions;
use crate::search::work::Work;
use serde::{Deserialize, Serialize};

/// Doubles after a passage that are tried one by one, and how often the step doubles after them.
const TRIED: [u32; 2] = [16, 40];

/// Where a step is to end before its time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stops {
    blows: bool,
    /// Positions of the piston over the bit, m, and true where it was last found beyond.
    levels: Vec<(f64, bool)>,
}

/// Why a step ended; both where a blow and a passage are at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stop {
    /// A blow.
    pub blow: bool,
    /// The piston passed a position.
    pub position: bool,
}

impl Stop {
    /// True if the step was ended at all.
    pub fn any(self) -> bool {
        self.blow || self.position
    }
}

impl Stops {
    /// At each blow, if `blows`, and at each passage of one of `positions` (m) from now on.
    pub fn new(machine: &Machine, blows: bool, positions: &[f64]) -> Self {
        let now = machine.kinematics();
        let goes = [now.relative_velocity, now.relative_acceleration];
        // At a position itself, where it goes tells the side.
        let up = goes.into_iter().find(|rate| *rate != 0.0).is_some_and(|rate| rate > 0.0);
        let beyond = |at: f64| now.relative_position > at || now.relative_position == at && up;
        Self { blows, levels: positions.iter().map(|&at| (at, beyond(at))).collect() }
    }

    /// The positions, m.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = f64> {
        self.levels.iter().map(|(at, _)| *at)
    }
}

/// Ends a step where its [`Stops`] say so.
pub(crate) struct Stopper<'a> {
    stops: &'a mut Stops,
    guards: Option<Positions>,
    blows: u64,
    /// Work of the search and its own: it may take as much again as the step.
    work: Work,
    /// Why it ended, so far.
    stop: Stop,
}

impl<'a> Stopper<'a> {
    pub fn new(machine: &Machine, stops: &'a mut Stops) -> Self {
        let (blows, work) = (machine.counters().blows, machine.search.work);
        Self { stops, guards: None, blows, work, stop: Stop::default() }
    }

    /// The epoch has moved.
    pub fn restart(&mut self) {
        self.guards = None;
    }

    /// An event has happened; true if it ends the step.
    pub fn after(&mut self, machine: &Machine) -> bool {
        self.restart();
        if !self.stops.blows || machine.counters().blows == self.blows {
            return false;
        }
        self.stop.blow = true;
        true
    }

    /// The step has ended; why.
    pub fn end(mut self, machine: &Machine) -> Stop {
        if self.stop.any() {
            self.pass_all(machine);
        }
        self.stop
    }

    /// Ends the step where the piston passes a position before `until` after the epoch and not
    /// after `to`: the present is then there.
    ///
    /// # Errors
    /// Those of [`Machine::advance`].
    pub fn stops_before(
        &mut self,
        machine: &mut Machine,
        until: f64,
        to: f64,
    ) -> Result<bool, Error> {
        if self.stops.levels.is_empty() {
            return Ok(false);
        }
        let state = machine.motion.state();
        let (now, time) = (state.now, state.time);
        let guards = self.guards.get_or_insert_with(|| {
            Positions::start(&machine.motion, &self.stops.levels, now.max(0.0))
        });
        loop {
            let (search, motion) = (&machine.search, &machine.motion);
            let check = |work: &Work, at: f64| search.check_beside(motion, work, at);
            let Some((at, index)) = guards.first(motion, until, &mut self.work, check)? else {
                return Ok(false);
            };
            let (level, beyond) = self.stops.levels[index];
            let passed = |x: f64| if beyond { x <= level } else { x >= level };
            let mut exact = machine.motion.state().epoch;
            exact.move_by(at);
            let mut end = exact.value().max(time);
            for tried in 0..TRIED[0] + TRIED[1] {
                let after = machine.motion.until(end);
                if after >= until && end < to || end > to {
                    // An event comes first, or the end of the step: it is found again after it.
                    machine.motion.set_present(now, time);
                    return Ok(false);
                }
                machine.motion.set_present(after.max(0.0), end);
                if passed(Kinematics::of(&machine.motion).relative_position) {
                    self.stops.levels[index].1 = !beyond;
                    self.stop.position = true;
                    self.guards = None;
                    return Ok(true);
                }
                let steps = 1_u64 << tried.saturating_sub(TRIED[0]);
                end = if end == 0.0 {
                    f64::MIN_POSITIVE
                } else {
                    end + steps as f64 * (end.next_up() - end)
                };
            }
            machine.motion.set_present(now, time);
            guards.ignore(index);
        }
    }

    /// Notes every position that was passed by now.
    fn pass_all(&mut self, machine: &Machine) {
        let x = Kinematics::of(&machine.motion).relative_position;
        for (level, beyond) in &mut self.stops.levels {
            if if *beyond { x < *level } else { x > *level } {
                *beyond = !*beyond;
                self.stop.position = true;
            }
        }
    }
}
