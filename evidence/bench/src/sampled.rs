//! The engine with its certification off: what the proof costs.
//!
//! The same exact modal propagation, the same guards and transitions, but events are found as others
//! find them: the guards are looked at in strides of fixed length, a value above the resolution
//! where one ends is taken for a crossing, and its zero is found by Newton's method kept in the
//! stride by bisection. No bound, no window: what rises and falls again within a stride is
//! missed. Strides are rounded down to a tabulated rotation.
//!
//! At its best: the rows that read a guard at the next [`BLOCK`] samples are tabulated, so that a
//! sample is one product a guard and nothing is rotated between events but from block to block. The
//! energy barrier is found as the engine finds it: the viscous work never falls, so there is
//! nothing to prove.

use crate::engine::machine;
use crate::trajectory::{Peer, Task, Trajectory};
use hammer::modal::system::System;
use hammer::modal::track::Track;
use hammer::numerics::poly::Poly;
use hammer::numerics::{kernel, matrix2};
use hammer::search::first;
use hammer::search::signal::{Part, Signal};
use hammer::{Event, Machine, Parameters, RockEvent, TIME_RESOLUTION};
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use verify::{reference, scene};

/// Samples whose rows are tabulated: a power of two, so that as many strides are one rotation.
const BLOCK: usize = 64;
/// Newton steps and halvings at the most; three or four are taken.
const STEPS: usize = 60;
/// In this time a hammer meets all its systems, s.
const CYCLE: f64 = 0.05;

/// The rows of one functional of a system, a row a sample.
type Rows = Rc<[f64]>;

/// All rows so far, by system, functional and derivative; a system is kept, and its address with it.
type Tables = HashMap<(usize, usize, usize), (Arc<System>, Rows)>;

/// The solver.
pub struct Sampled {
    parameters: Parameters,
    stride: f64,
    tables: Tables,
}

impl Sampled {
    /// Of a scene whose loads change at events alone, in strides of at most so many seconds; its
    /// systems are met and its rows tabulated.
    ///
    /// # Errors
    /// The engine's own; no such stride.
    ///
    /// # Panics
    /// The engine refuses the parameters.
    pub fn new(parameters: Parameters, stride: f64) -> Result<Self, String> {
        let (_, stride) = System::level_below(stride).ok_or("no such stride")?;
        let mut new = Self { parameters, stride, tables: Tables::new() };
        new.run(&Task { instants: Vec::new(), end: CYCLE, patience: 0.0 })?;
        Ok(new)
    }
}

impl Peer for Sampled {
    fn run(&mut self, task: &Task) -> Result<Trajectory, String> {
        let mut machine = machine(&self.parameters);
        machine.keep_journal(true);
        let (stride, tables) = (self.stride, &mut self.tables);
        let (tracks, guards) = (Vec::new(), Vec::new());
        let mut run = Run { machine, stride, tables, at: 0.0, tracks, guards };
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

/// A guard of the present mode, with the rows that read each of its parts.
struct Watched {
    event: Event,
    signal: Signal,
    /// Its part that does not oscillate, after the last event.
    poly: Poly,
    parts: Vec<(Part, Rows)>,
}

/// A machine and how far it was looked at.
struct Run<'a> {
    machine: Machine,
    stride: f64,
    tables: &'a mut Tables,
    /// After the last event, s: the tracks stand here.
    at: f64,
    tracks: Vec<Track>,
    guards: Vec<Watched>,
}

impl Run<'_> {
    /// A mode begins.
    fn enter(&mut self) {
        let (tracks, guards) = self.machine.tracked();
        (self.tracks, self.at) = (tracks, 0.0);
        for track in &mut self.tracks {
            track.rotate_to(0.0);
        }
        let mut watched = |(event, signal): (Event, Signal)| {
            let part = |part: &Part| (*part, self.rows(*part, signal.order));
            let parts = signal.parts.iter().flatten().map(part).collect();
            Watched { event, poly: signal.poly(), signal, parts }
        };
        let watched = guards.into_iter().map(&mut watched).collect();
        self.guards = watched;
    }

    /// The rows that read a part of a guard at each of the next samples: `c B^order exp(B k d)`.
    fn rows(&mut self, part: Part, order: usize) -> Rows {
        let system = &self.tracks[part.track].system;
        let key = (Arc::as_ptr(system) as usize, part.functional, order);
        let made = || (system.clone(), rows(system, part.functional, order, self.stride));
        self.tables.entry(key).or_insert_with(made).1.clone()
    }

    fn advance(&mut self, stop: f64) -> Result<(), hammer::Error> {
        loop {
            let left = self.machine.until(stop) - self.at;
            if left <= 0.0 {
                self.machine.wait(stop);
                return Ok(());
            }
            let whole = ((left / self.stride) as usize).min(BLOCK);
            let found = if whole > 0 { self.scan(whole) } else { self.within(left) };
            if let Some((at, event)) = found {
                self.machine.lead(at, event)?;
                self.enter();
            }
        }
    }

    /// Goes on by so many strides, or up to the end of one within which there is an event: that.
    fn scan(&mut self, count: usize) -> Option<(f64, Event)> {
        let (begun, stride) = (self.at, self.stride);
        let sample = |k: usize| begun + k as f64 * stride;
        let barrier = self.machine.barrier_within(sample(count));
        let ends = barrier.map(|at| (((at - begun) / stride).ceil() as usize).clamp(1, count));
        let count = ends.unwrap_or(count);
        let has_risen = |k: &usize| {
            let value = |guard: &Watched| guard.at_sample(*k, sample(*k), &self.tracks);
            self.guards.iter().any(|guard| value(guard) > guard.signal.resolution)
        };
        let Some(last) = (1..=count).find(has_risen).or(ends) else {
            self.tracks = self.ahead(count as f64 * stride);
            self.at = sample(count);
            return None;
        };
        self.tracks = self.ahead((last - 1) as f64 * stride);
        self.at = sample(last - 1);
        self.within(stride)
    }

    /// The tracks a span later. By the span itself: a difference of instants is no tabulated one.
    fn ahead(&self, span: f64) -> Vec<Track> {
        let mut tracks = self.tracks.clone();
        tracks.iter_mut().for_each(|track| {
            track.system.rotate(span, &mut track.z);
        });
        tracks
    }

    /// Goes on by `span`, or finds the event within it: when, and which.
    fn within(&mut self, span: f64) -> Option<(f64, Event)> {
        let (end, ahead) = (self.at + span, self.ahead(span));
        let risen = self.guards.iter().filter(|guard| {
            let [value, _] = guard.look(&ahead, end);
            value > guard.signal.resolution
        });
        let zero = |guard: &Watched| (self.at + self.zero(guard, span), guard.event);
        let crossing = risen.map(zero).reduce(first);
        let barrier = self.machine.barrier_within(end);
        let barrier = barrier.map(|at| (at, Event::Rock(RockEvent::Barrier)));
        let next = crossing.into_iter().chain(barrier).reduce(first);
        if next.is_none() {
            (self.tracks, self.at) = (ahead, end);
        }
        next
    }

    /// The zero of a guard within the next `span`, at whose end it has risen.
    fn zero(&self, guard: &Watched, span: f64) -> f64 {
        let [start, slope] = guard.look(&self.tracks, self.at);
        if start >= 0.0 && slope >= 0.0 {
            return 0.0; // It left its surface in the right direction when the mode began.
        }
        let (mut low, mut high) = (0.0, span);
        let mut x = 0.5 * span;
        for _ in 0..STEPS {
            let [value, slope] = guard.look(&self.ahead(x), self.at + x);
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

impl Watched {
    /// Its value at sample `k`, at `t` after the event, from where the tracks stand.
    fn at_sample(&self, k: usize, t: f64, tracks: &[Track]) -> f64 {
        let mut value = self.poly.at(t);
        for (part, rows) in &self.parts {
            let z = &tracks[part.track].z;
            value += part.factor * kernel::dot(&rows[(k - 1) * z.len()..][..z.len()], z);
        }
        value
    }

    /// Its value and slope at `t`, where the tracks stand.
    fn look(&self, tracks: &[Track], t: f64) -> [f64; 2] {
        let [mut value, mut slope, _] = self.poly.rates_at(t);
        for (part, _) in &self.parts {
            let track = &tracks[part.track];
            let rows = &track.system.functionals[part.functional].rows;
            value += part.factor * kernel::dot(&rows[self.signal.order], &track.z);
            slope += part.factor * kernel::dot(&rows[self.signal.order + 1], &track.z);
        }
        [value, slope]
    }
}

fn rows(system: &System, functional: usize, order: usize, stride: f64) -> Rows {
    let first = &system.functionals[functional].rows[order];
    let n = system.blocks();
    let mut rows = vec![0.0; BLOCK * 2 * n];
    for (k, row) in rows.chunks_exact_mut(2 * n).enumerate() {
        let span = (k + 1) as f64 * stride;
        for i in (0..n).filter(|i| first[*i] != 0.0 || first[n + *i] != 0.0) {
            let e = matrix2::exponential(&system.block(i), span);
            row[i] = first[i] * e[0] + first[n + i] * e[2];
            row[n + i] = first[i] * e[1] + first[n + i] * e[3];
        }
    }
    rows.into()
}
