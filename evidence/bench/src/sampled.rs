//! The engine with its certification off: what the proof costs.
//!
//! The same exact modal propagation, the same guards and transitions, but events are found as others
//! find them: the guards are looked at in strides of fixed length, a value above the resolution
//! where one ends is taken for a crossing, and its zero is found by Newton's method kept in the
//! stride by bisection. No bound, no window: what rises and falls again within a stride is
//! missed. Strides are rounded down to a tabulated rotation, so that each is one product a track.
//!
//! The energy barrier is found as the engine finds it: the viscous work never falls, so there is
//! nothing to prove.

use crate::engine::machine;
use crate::trajectory::{Peer, Task, Trajectory};
use hammer::modal::system::System;
use hammer::modal::track::Track;
use hammer::numerics::kernel;
use hammer::search::signal::Signal;
use hammer::{Event, Machine, Parameters, RockEvent, TIME_RESOLUTION};
use verify::{reference, scene};

/// In this time a hammer meets all its systems, s.
const CYCLE: f64 = 0.05;
/// Halvings of a stride; Newton's method takes three or four steps.
const STEPS: usize = 60;

/// The solver.
pub struct Sampled {
    parameters: Parameters,
    stride: f64,
    /// Its systems are there for all that follow.
    _warm: Machine,
}

impl Sampled {
    /// Of a scene whose loads change at events alone, in strides of at most so many seconds.
    ///
    /// # Panics
    /// The engine refuses the parameters.
    pub fn new(parameters: Parameters, stride: f64) -> Self {
        let mut warm = machine(&parameters);
        warm.advance(CYCLE).expect("a cycle without an excess of events");
        Self { parameters, stride, _warm: warm }
    }
}

/// A machine and how far it was looked at.
struct Run {
    machine: Machine,
    stride: f64,
    /// After the last event, s: the tracks stand here.
    at: f64,
    tracks: Vec<Track>,
    ahead: Vec<Track>,
    guards: Vec<(Event, Signal)>,
}

impl Peer for Sampled {
    fn run(&mut self, task: &Task) -> Result<Trajectory, String> {
        let (_, stride) = System::level_below(self.stride).ok_or("no such stride")?;
        let mut machine = machine(&self.parameters);
        machine.keep_journal(true);
        let (tracks, ahead, guards) = (Vec::new(), Vec::new(), Vec::new());
        let mut run = Run { machine, stride, at: 0.0, tracks, ahead, guards };
        run.enter();
        let mut done = Trajectory::default();
        for stop in task.stops() {
            run.advance(stop).map_err(|e| e.to_string())?;
            if done.states.len() < task.instants.len() {
                done.states.push(reference::nodal(&run.machine));
            }
        }
        let journal = run.machine.take_journal();
        done.events = journal.iter().map(|r| (r.time, scene::event(r))).collect();
        Ok(done)
    }
}

impl Run {
    /// A mode begins.
    fn enter(&mut self) {
        (self.tracks, self.guards) = self.machine.watched();
        for track in &mut self.tracks {
            track.rotate_to(0.0);
        }
        self.ahead = self.tracks.clone();
        self.at = 0.0;
    }

    fn advance(&mut self, stop: f64) -> Result<(), hammer::Error> {
        loop {
            let end = self.machine.until(stop);
            if self.at >= end {
                self.machine.wait(stop);
                return Ok(());
            }
            let span = self.stride.min(end - self.at);
            if let Some((at, event)) = self.stride(span) {
                self.machine.lead(at, event)?;
                self.enter();
            }
        }
    }

    /// Goes on by `span`, or finds the event within it: when, and which.
    fn stride(&mut self, span: f64) -> Option<(f64, Event)> {
        for (ahead, track) in self.ahead.iter_mut().zip(&self.tracks) {
            ahead.z.copy_from_slice(&track.z);
            // By the span itself: a difference of instants is no tabulated one.
            ahead.system.rotate(span, &mut ahead.z);
        }
        let end = self.at + span;
        let risen = self.guards.iter().filter(|(_, guard)| {
            let [value, _] = look(guard, &self.ahead, end);
            value > guard.resolution
        });
        let crossed = risen.map(|(event, guard)| (self.at + self.zero(guard, span), *event));
        let mut first = crossed.reduce(earlier);
        let barrier =
            self.machine.barrier_within(end).map(|at| (at, Event::Rock(RockEvent::Barrier)));
        first = first.into_iter().chain(barrier).reduce(earlier);
        if first.is_none() {
            std::mem::swap(&mut self.tracks, &mut self.ahead);
            self.at = end;
        }
        first
    }

    /// The zero of a guard within the next `span`, at whose end it has risen.
    fn zero(&self, guard: &Signal, span: f64) -> f64 {
        let [start, slope] = look(guard, &self.tracks, self.at);
        if start >= 0.0 && slope >= 0.0 {
            return 0.0; // It left its surface in the right direction when the mode began.
        }
        let (mut low, mut high) = (0.0, span);
        let mut x = 0.5 * span;
        for _ in 0..STEPS {
            let mut tracks = self.tracks.clone();
            tracks.iter_mut().for_each(|track| {
                track.system.rotate(x, &mut track.z);
            });
            let [value, slope] = look(guard, &tracks, self.at + x);
            if value > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - value / slope;
            let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= TIME_RESOLUTION {
                return next;
            }
            x = next;
        }
        x
    }
}

/// Value and slope of a guard at `t`, where its tracks stand.
fn look(guard: &Signal, tracks: &[Track], t: f64) -> [f64; 2] {
    let [mut value, mut slope, _] = guard.poly.rates_at(t);
    for part in guard.parts.iter().flatten() {
        let track = &tracks[part.track];
        let rows = &track.system.functionals[part.functional].rows;
        value += part.factor * kernel::dot(&rows[guard.order], &track.z);
        slope += part.factor * kernel::dot(&rows[guard.order + 1], &track.z);
    }
    [value, slope]
}

/// The earlier of two events; at one instant, the first in order.
fn earlier(a: (f64, Event), b: (f64, Event)) -> (f64, Event) {
    let is_tie = (a.0 - b.0).abs() <= TIME_RESOLUTION;
    let rank = |event| match event {
        Event::Contact => 0,
        Event::Rock(_) => 1,
        _ => 2,
    };
    let is_first = if is_tie { rank(a.1) <= rank(b.1) } else { a.0 < b.0 };
    if is_first { a } else { b }
}
