//! Stops: a host may ask that a step ends at each blow, and where the piston passes a position.
//!
//! ```text
//! blow        the step ends at the event, at the instant of the blow
//! position    the step ends at the first double t, at or after the passage, at which the output
//!             is at the level or beyond it
//! ```
//!
//! A stop only reads the state, so the motion stays identical to the last binary digit. On request, such events are
//! only recorded and do not end the step.

use crate::error::Error;
use crate::laws::event::Displacement;
use crate::machine::Machine;
use crate::machine::outputs::Kinematics;
use crate::search::positions::Positions;
use crate::search::tracker::NEAR;
use crate::search::work::Work;
use serde::{Deserialize, Serialize};

/// Number of doubles after a passage that are tried one by one, and number of the doublings of the distance after that.
const TRIED: [u32; 2] = [16, 40];

/// Events that end a step early, or are recorded in it.
///
/// ```
/// let mut hammer = hammer::Scene::default().machine()?;
/// let mut stops = hammer::Stops::new(&hammer, true, &[]); // at each blow
/// let (_, stop) = hammer.advance_keeping_start(1.0, Some(&mut stops))?;
/// assert!(stop.blow);
/// assert_eq!(hammer.time(), hammer.blow().expect("the first blow").time);
/// # Ok::<(), hammer::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stops {
    /// True if these events end the step, false if they are only recorded.
    pub ends: bool,
    blows: bool,
    /// Positions of the piston relative to the bit, m, each with a flag: true if the piston was last beyond it.
    levels: Vec<(f64, bool)>,
}

/// Why a step ended, or which events happened in it. A blow and a passage may be simultaneous.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Stop {
    /// True if there was a blow.
    pub blow: bool,
    /// Index of the position that the piston passed; the last one if there were several.
    pub position: Option<usize>,
}

impl Stop {
    /// True if there was an event.
    pub fn any(self) -> bool {
        self.blow || self.position.is_some()
    }
}

impl Stops {
    /// Stops at each blow, if `blows`, and at each passage of one of `positions` (m) from now on.
    pub fn new(machine: &Machine, blows: bool, positions: &[f64]) -> Self {
        let now = machine.kinematics();
        let rates = [now.relative.velocity, now.relative.acceleration];
        // Exactly at a position, the direction of the motion decides the side.
        let rises = rates.into_iter().find(|rate| *rate != 0.0).is_some_and(|rate| rate > 0.0);
        let x = now.relative.displacement;
        let side = |&level: &f64| (level, x > level || x == level && rises);
        Self { ends: true, blows, levels: positions.iter().map(side).collect() }
    }

    /// True if these stops were made for the same `blows` and `positions`.
    pub fn are(&self, blows: bool, positions: &[f64]) -> bool {
        self.blows == blows && self.positions().eq(positions.iter().copied())
    }

    /// Corrects the stored sides after a machine was restored. The piston's present position decides, unless it is so
    /// near a level that a guard could have missed the passage.
    pub fn settle(&mut self, machine: &Machine) {
        let tolerance = NEAR * machine.motion().resolved(Displacement::Relative);
        let x = machine.kinematics().relative.displacement;
        for (level, beyond) in &mut self.levels {
            if (x - *level).abs() > tolerance {
                *beyond = x > *level;
            }
        }
    }

    /// The positions, m.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = f64> {
        self.levels.iter().map(|(at, _)| *at)
    }
}

/// Observer that ends a step at its [`Stops`].
pub(crate) struct Stopper<'a> {
    stops: &'a mut Stops,
    guards: Option<Positions>,
    blows: u64,
    /// Work of the search for positions. Its limit is as large again as that of the search for events.
    work: Work,
    /// The events of the step so far.
    stop: Stop,
}

impl<'a> Stopper<'a> {
    pub fn new(machine: &Machine, stops: &'a mut Stops) -> Self {
        let (blows, work) = (machine.counters().blows, machine.search.work);
        Self { stops, guards: None, blows, work, stop: Stop::default() }
    }

    /// Restarts the search for positions after the epoch has moved.
    pub fn restart(&mut self) {
        self.guards = None;
    }

    /// Handles an event. Returns true if it ends the step.
    pub fn after(&mut self, machine: &Machine) -> bool {
        self.restart();
        let blows = machine.counters().blows;
        if !self.stops.blows || blows == self.blows {
            return false;
        }
        (self.blows, self.stop.blow) = (blows, true);
        self.stops.ends
    }

    /// Ends the step and returns why it ended.
    pub fn end(mut self, machine: &Machine) -> Stop {
        if self.stop.any() {
            self.pass_all(machine);
        }
        self.stop
    }

    /// Looks for a passage of a position before the time `until` after the epoch and not after the instant `to`. If
    /// there is one and it ends the step, moves the present there and returns true.
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
        let state = &machine.motion.state;
        let (now, time) = (state.now, state.time);
        let mut from = now.max(0.0);
        loop {
            let guards = self
                .guards
                .get_or_insert_with(|| Positions::start(&machine.motion, &self.stops.levels, from));
            let context = (&machine.search, &machine.motion);
            let Some((crossing, index)) = guards.first(context, until, &mut self.work)? else {
                return Ok(false);
            };
            let (level, beyond) = self.stops.levels[index];
            let passed = |x: f64| if beyond { x <= level } else { x >= level };
            let mut exact = machine.motion.state.epoch;
            exact.move_by(crossing);
            let mut end = exact.value().max(time);
            for attempt in 0..TRIED[0] + TRIED[1] {
                let after = machine.motion.state.epoch.until(end);
                if after >= until && end < to || end > to {
                    // An event or the end of the step comes first. The passage will be found again after it.
                    machine.motion.set_present(now, time);
                    return Ok(false);
                }
                machine.motion.set_present(after.max(0.0), end);
                if passed(Kinematics::of(&machine.motion).relative.displacement) {
                    self.stops.levels[index].1 = !beyond;
                    self.stop.position = Some(index);
                    self.guards = None;
                    if self.stops.ends {
                        return Ok(true);
                    }
                    from = after.max(0.0);
                    break;
                }
                let steps = 1_u64 << attempt.saturating_sub(TRIED[0]);
                end = if end == 0.0 {
                    f64::MIN_POSITIVE
                } else {
                    end + steps as f64 * (end.next_up() - end)
                };
            }
            machine.motion.set_present(now, time);
            if let Some(guards) = &mut self.guards {
                guards.ignore(index);
            }
        }
    }

    /// Updates the sides of all positions that have been passed.
    fn pass_all(&mut self, machine: &Machine) {
        let x = Kinematics::of(&machine.motion).relative.displacement;
        for (index, (level, beyond)) in self.stops.levels.iter_mut().enumerate() {
            if if *beyond { x < *level } else { x > *level } {
                *beyond = !*beyond;
                self.stop.position = Some(index);
            }
        }
    }
}
