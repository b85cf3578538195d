//! The reference solution: Taylor series in double-double arithmetic.
//!
//! Within a mode every step sums a series whose last terms are below the
//! tolerance; modes end where a guard's polynomial crosses ([`crate::crossing`]).
//! Rounding (2^-106) and truncation are the only errors, and the events pass
//! them on; two runs with different orders and tolerances measure the result.

use crate::crossing::{Outcome, Zero, scan};
use crate::dd::Dd;
use crate::model::{Event, Memory, Mode, Model, Quantity, Real, State};
use crate::taylor::{Accuracy, Series, UNIT};
use serde::{Deserialize, Serialize};

/// Most transitions at one instant before the run is given up.
const CASCADE: usize = 100;

/// A transition that happened.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// When, s.
    pub time: Dd,
    /// Which.
    pub event: Event,
    /// The mode after it.
    pub mode: Mode,
}

/// A state asked for.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// When, s.
    pub time: f64,
    /// The mode then.
    pub mode: Mode,
    /// The rock's memory then.
    pub memory: Memory<Dd>,
    /// The continuous state then.
    pub state: State<Dd>,
}

/// A zero from which a guard has risen, not yet by its height.
#[derive(Clone, Debug)]
struct Candidate {
    time: Dd,
    state: State<Dd>,
}

/// An integration under way.
pub struct Run<'a> {
    model: &'a Model<Dd>,
    accuracy: Accuracy,
    time: Dd,
    mode: Mode,
    memory: Memory<Dd>,
    state: State<Dd>,
    load: Vec<Dd>,
    pending: Vec<Option<Candidate>>,
    /// The transitions so far.
    pub events: Vec<Passed>,
    /// The states so far.
    pub samples: Vec<Sampled>,
    /// Series summed so far.
    pub steps: usize,
}

impl<'a> Run<'a> {
    /// At rest, at time 0.
    pub fn new(model: &'a Model<Dd>, accuracy: Accuracy) -> Self {
        let (state, mode, memory) = model.start();
        let mut run = Self {
            model,
            accuracy,
            time: Dd::default(),
            mode,
            memory,
            state,
            load: Vec::new(),
            pending: Vec::new(),
            events: Vec::new(),
            samples: Vec::new(),
            steps: 0,
        };
        run.enter();
        run
    }

    fn enter(&mut self) {
        self.load = self.model.load(self.mode, &self.memory);
        self.pending = vec![None; self.model.guards(self.mode, &self.memory).len()];
    }

    /// Integrates through all `instants` (ascending), sampling at each.
    ///
    /// # Errors
    /// More than [`CASCADE`] transitions at one instant.
    pub fn through(&mut self, instants: &[f64]) -> Result<(), String> {
        // A rejected stretch takes its samples with it: hence no plain loop over instants.
        while self.samples.len() < instants.len() {
            let target = instants[self.samples.len()];
            if self.step(Dd::from(target))? {
                self.samples.push(Sampled {
                    time: target,
                    mode: self.mode,
                    memory: self.memory,
                    state: self.state.clone(),
                });
            }
        }
        Ok(())
    }

    /// One step or one transition; true if `target` was reached.
    fn step(&mut self, target: Dd) -> Result<bool, String> {
        let (model, mode) = (self.model, self.mode);
        let series = Series::new(model, mode, &self.load, &self.state, self.accuracy.order);
        self.steps += 1;
        let left = (target - self.time) * Dd::from(1.0 / UNIT);
        let reach = series.reach(self.accuracy);
        let arrives = left.hi <= reach;
        let x = if arrives { left } else { Dd::from(reach) };
        if let Some((event, candidate)) = self.look(&series, x.hi) {
            self.pass(event, candidate)?;
            return Ok(false);
        }
        self.state = series.at(x);
        self.time = if arrives { target } else { self.time + x * Dd::from(UNIT) };
        Ok(arrives)
    }

    /// The first transition of a step, if any; otherwise notes what is pending.
    fn look(&mut self, series: &Series, end: f64) -> Option<(Event, Candidate)> {
        let mut first: Option<(Event, Candidate)> = None;
        for (i, guard) in self.model.guards(self.mode, &self.memory).into_iter().enumerate() {
            let mut c = series.quantity(self.model, guard.quantity);
            c[0] = c[0] - guard.offset;
            c.iter_mut().for_each(|c| *c = Dd::from(guard.sign) * *c);
            let height = guard.quantity.resolution();
            let outcome = scan(&c, end, height, self.pending[i].is_some());
            self.pending[i] = match outcome {
                Outcome::Clear => None,
                Outcome::Pending(Zero::Earlier) | Outcome::Crossed(Zero::Earlier) => {
                    self.pending[i].take()
                }
                Outcome::Pending(Zero::At(x)) | Outcome::Crossed(Zero::At(x)) => {
                    Some(Candidate { time: self.time + x * Dd::from(UNIT), state: series.at(x) })
                }
            };
            if let (Outcome::Crossed(_), Some(candidate)) = (outcome, &self.pending[i]) {
                let key = (candidate.time, guard.event.rank());
                if first.as_ref().is_none_or(|(event, best)| key < (best.time, event.rank())) {
                    first = Some((guard.event, candidate.clone()));
                }
            }
        }
        first
    }

    fn pass(&mut self, event: Event, candidate: Candidate) -> Result<(), String> {
        (self.time, self.state) = (candidate.time, candidate.state);
        self.samples.retain(|sample| Dd::from(sample.time) <= self.time);
        self.model.transition(event, &mut self.mode, &mut self.memory, &mut self.state);
        self.events.push(Passed { time: self.time, event, mode: self.mode });
        self.enter();
        let now = self.events.iter().rev().take_while(|e| e.time == self.time).count();
        if now > CASCADE {
            return Err(format!("{now} transitions at {} s", self.time.hi));
        }
        Ok(())
    }
}

/// The committed form of an event.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EventRecord {
    /// Time, s: nearest `f64`.
    pub time: f64,
    /// What the nearest `f64` leaves, s.
    pub time_rest: f64,
    /// Which.
    pub event: Event,
    /// The mode after it.
    pub mode: Mode,
}

/// The committed form of a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StateRecord {
    /// Time, s.
    pub time: f64,
    /// The mode then.
    pub mode: Mode,
    /// `ul`, `uu`, `dp`, m.
    pub memory: Memory<f64>,
    /// Viscous work of the cycle, J.
    pub psi: f64,
    /// Nodal displacements, piston then bit, m.
    pub u: Vec<f64>,
    /// Nodal velocities, m/s.
    pub v: Vec<f64>,
    /// Piston's mean minus bit's mean minus `g0`, m.
    pub relative: f64,
    /// `F_C`, N.
    pub contact_force: f64,
    /// `F_R`, N.
    pub rock_force: f64,
}

/// A committed reference solution.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Elements of each bar.
    pub elements: usize,
    /// Order of the series.
    pub order: usize,
    /// Size of the last term kept (units: 1 mm, 1 m/s).
    pub tolerance: f64,
    /// Largest difference from a second run of other order and tolerance, at any
    /// instant: displacements over 1 mm, velocities over 1 m/s.
    pub state_uncertainty: f64,
    /// Largest difference of an event's time from that run's, s.
    pub event_uncertainty: f64,
    /// Every transition, in order.
    pub events: Vec<EventRecord>,
    /// States at the instants asked for.
    pub states: Vec<StateRecord>,
}

/// Largest difference, with 1 mm and 1 m/s as units; `f64::MAX` if any is not a number.
pub fn distance<T: Real>(a: &State<T>, b: &State<T>) -> f64 {
    let worst = |x: &[T], y: &[T], scale: f64| {
        x.iter().zip(y).fold(0.0f64, |max, (&x, &y)| {
            let d = (x - y).to_f64().abs() / scale;
            if d.is_finite() { max.max(d) } else { f64::MAX }
        })
    };
    worst(&a.u, &b.u, 1e-3).max(worst(&a.v, &b.v, 1.0))
}

fn state_record(model: &Model<Dd>, sample: &Sampled) -> StateRecord {
    let f64s = |row: &[Dd]| row.iter().map(|x| x.to_f64()).collect();
    let (mode, state, memory) = (sample.mode, &sample.state, &sample.memory);
    let gap = model.quantity(Quantity::Gap, state);
    let contact = if mode.closed { -(model.contact_stiffness * gap) } else { Dd::default() };
    StateRecord {
        time: sample.time,
        mode,
        memory: Memory {
            ul: memory.ul.to_f64(),
            uu: memory.uu.to_f64(),
            gain: memory.gain.to_f64(),
        },
        psi: state.psi.to_f64(),
        u: f64s(&state.u),
        v: f64s(&state.v),
        relative: model.quantity(Quantity::Relative, state).to_f64(),
        contact_force: contact.to_f64(),
        rock_force: model.rock_force(mode, memory, state).to_f64(),
    }
}

/// Runs twice and keeps the better run with the difference.
///
/// # Errors
/// A run failed, or the two disagree on the sequence of events.
pub fn record(
    model: &Model<Dd>,
    elements: usize,
    instants: &[f64],
    [best, check]: [Accuracy; 2],
) -> Result<Record, String> {
    let (mut one, mut two) = (Run::new(model, best), Run::new(model, check));
    one.through(instants)?;
    two.through(instants)?;
    let kinds = |run: &Run| run.events.iter().map(|e| e.event).collect::<Vec<_>>();
    if kinds(&one) != kinds(&two) {
        return Err("the two runs disagree on the events".into());
    }
    let pairs = one.samples.iter().zip(&two.samples);
    let times = one.events.iter().zip(&two.events);
    Ok(Record {
        elements,
        order: best.order,
        tolerance: best.tolerance,
        state_uncertainty: pairs.fold(0.0, |max, (a, b)| max.max(distance(&a.state, &b.state))),
        event_uncertainty: times.fold(0.0, |max, (a, b)| max.max((a.time - b.time).hi.abs())),
        events: one
            .events
            .iter()
            .map(|e| EventRecord {
                time: e.time.hi,
                time_rest: e.time.lo,
                event: e.event,
                mode: e.mode,
            })
            .collect(),
        states: one.samples.iter().map(|sample| state_record(model, sample)).collect(),
    })
}
