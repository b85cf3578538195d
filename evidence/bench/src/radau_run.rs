//! The event-driven run of [`Radau`], adaptive:
//!
//! ```text
//! while t < end
//!     step from x- to x+; if refused, with a shorter one again
//!     if a guard is above its resolution at x+
//!         find the earliest zero by shorter steps from x-; transition; restart
//!     else x- := x+
//! ```
//!
//! A pair of crossings inside one step goes unseen: that is the method's own
//! weakness, and part of the comparison.

use crate::radau::Radau;
use crate::schema::{Answer, Peer, Task};
use oracles::law::{Event, Guard, Memory, Mode, State};
use oracles::model::Model;
use std::time::Instant;

/// Most transitions at one instant.
const SIMULTANEOUS: usize = 50;

/// Width of the bracket in which an event is left, s.
const BRACKET: f64 = 1e-15;

/// The solver: a hammer, and what local errors over 1 mm and 1 m/s stay below.
pub struct Adaptive<'a> {
    /// The hammer.
    pub model: &'a Model<f64>,
    /// The tolerance.
    pub tolerance: f64,
}

struct Run<'a> {
    model: &'a Model<f64>,
    method: Radau,
    time: f64,
    mode: Mode,
    memory: Memory<f64>,
    state: State<f64>,
    next: State<f64>,
    guards: Vec<Guard<f64>>,
    answer: Answer,
}

impl Peer for Adaptive<'_> {
    /// Fails out of patience, or at too many transitions at one instant.
    fn run(&mut self, task: &Task) -> Result<Answer, String> {
        let (state, mode, memory) = self.model.start();
        let clock = Instant::now();
        let mut run = Run {
            model: self.model,
            method: Radau::new(self.model, self.tolerance),
            time: 0.0,
            mode,
            memory,
            next: state.clone(),
            state,
            guards: Vec::new(),
            answer: Answer::default(),
        };
        run.enter();
        for stop in task.stops() {
            let mut steps = 0u32;
            while run.time < stop {
                run.advance(stop)?;
                steps = steps.wrapping_add(1);
                if steps.is_multiple_of(1024) && clock.elapsed().as_secs_f64() > task.patience {
                    return Err(format!("gave up at {:.6} s", run.time));
                }
            }
            run.answer.keep(task, &run.state);
        }
        Ok(run.answer)
    }
}

impl Run<'_> {
    fn enter(&mut self) {
        self.method.enter(self.model, self.mode, &self.memory);
        self.guards = self.model.guards(self.mode, &self.memory);
    }

    fn value(&self, guard: &Guard<f64>, state: &State<f64>) -> f64 {
        guard.value(self.model.quantity(guard.quantity, state))
    }

    fn advance(&mut self, stop: f64) -> Result<(), String> {
        let left = stop - self.time;
        let wish = self.method.length();
        let h = if left <= wish * (1.0 + 1e-9) { left } else { wish };
        if !self.method.step(&self.state, h, &mut self.next) {
            return Ok(());
        }
        let mut first: Option<(f64, Event)> = None;
        for guard in self.guards.clone() {
            if self.value(&guard, &self.next) > guard.height {
                let at = self.locate(&guard, h);
                if first.is_none_or(|(t, e)| (at, guard.event.rank()) < (t, e.rank())) {
                    first = Some((at, guard.event));
                }
            }
        }
        if let Some((at, event)) = first {
            let mut state = self.state.clone();
            self.method.partial(&self.state, at, &mut state);
            (self.state, self.time) = (state, self.time + at);
            return self.pass(event);
        }
        std::mem::swap(&mut self.state, &mut self.next);
        self.time = if h == left { stop } else { self.time + h };
        Ok(())
    }

    /// Zero of a guard in a step of `h` at whose end it is positive: false
    /// position (Illinois) with steps of other lengths.
    fn locate(&mut self, guard: &Guard<f64>, h: f64) -> f64 {
        let (mut a, mut b) = (0.0, h);
        let mut fa = self.value(guard, &self.state);
        let mut fb = self.value(guard, &self.next);
        if fa > guard.height {
            return 0.0;
        }
        let mut probe = self.state.clone();
        let mut last = 0;
        while b - a > BRACKET {
            // A start on the surface gives no slope.
            let x = if fa > -1e-3 * fb { 0.5 * (a + b) } else { a - fa * (b - a) / (fb - fa) };
            let x = x.clamp(a + 0.25 * BRACKET, b - 0.25 * BRACKET);
            self.method.partial(&self.state, x, &mut probe);
            let fx = self.value(guard, &probe);
            if fx == 0.0 {
                return x;
            }
            let side = if fx > 0.0 { 1 } else { -1 };
            if side > 0 {
                (b, fb) = (x, fx);
                fa *= if last == side { 0.5 } else { 1.0 };
            } else {
                (a, fa) = (x, fx);
                fb *= if last == side { 0.5 } else { 1.0 };
            }
            last = side;
        }
        b
    }

    fn pass(&mut self, event: Event) -> Result<(), String> {
        let events = &mut self.answer.events;
        events.push((self.time, event));
        if events.len() > SIMULTANEOUS && events[events.len() - SIMULTANEOUS].0 == self.time {
            return Err(format!("cascade at {} s", self.time));
        }
        self.model.transition(event, &mut self.mode, &mut self.memory, &mut self.state);
        self.enter();
        Ok(())
    }
}
