//! Walking with a machine.

use crate::error::Error;
use crate::laws::event::Event;
use crate::machine::{Machine, Observer};
use crate::modal::model::Span;
use crate::quantities::inputs::{Input, Inputs};
use crate::quantities::parameters::{Parameters, Source};
use crate::tangent::change::Change;
use crate::tangent::event::Caution;
use crate::tangent::leg::{Leg, Moment};
use crate::tangent::line::Line;
use crate::tangent::response::Response;
use crate::tangent::seed::Seed;
use crate::tangent::spent::Here;
use crate::tangent::start::{begin, kinks};
use crate::tangent::statics::Statics;
use crate::tangent::summit::Summit;
use crate::tangent::viscous::Kept;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// The derivatives of a machine's motion; see the [module](super).
#[derive(Debug)]
pub struct Tangents {
    pub(crate) seeds: Vec<Seed>,
    pub(crate) changes: Vec<Change>,
    pub(crate) lines: Vec<Line>,
    pub(super) parameters: Parameters,
    pub(super) responses: HashMap<(usize, Span), Arc<Response>>,
    pub(super) statics: HashMap<Span, Arc<Statics>>,
    /// From the last event to the epoch, s.
    passed: f64,
    /// Where the lines stand, after the epoch.
    pub(crate) since: f64,
    pub(super) kept: Vec<Kept>,
    /// The ledger is carried too.
    pub(crate) ledger: bool,
    /// Largest contact and rock force of a step, if these are carried too.
    pub(crate) summits: Option<[Summit; 2]>,
    /// Where the step began, after the epoch.
    pub(super) step: f64,
    /// The lines stand just after an event.
    pub(super) fresh: bool,
    moment: Option<Moment>,
    pub(super) last: Option<(Event, f64)>,
    pub(super) cautions: Vec<Caution>,
    pub(super) uncounted: u64,
    /// Of the last event, s.
    pub(super) time: f64,
    /// Digits were lost beside a slow coordinate; told once.
    pub(super) rough: bool,
    /// Legs and their events, for who wants to go the same way again.
    pub(crate) tape: Option<Vec<(Leg, Option<Moment>)>>,
    /// Every blow is kept, not only the last.
    pub(crate) story: bool,
    /// Ends a step after such an event.
    pub(crate) stop: Option<fn(&Moment) -> bool>,
    pub(crate) stopped: bool,
}

/// Derivatives of a machine's state, as they are kept and restored with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TangentState {
    lines: Vec<Line>,
    inputs: Vec<Inputs>,
    since: f64,
    ledger: bool,
    summits: Option<[Summit; 2]>,
    step: f64,
    fresh: bool,
}

impl Tangents {
    /// From the start of a scene: the start state too depends on the parameters. `machine`
    /// must be as [`Machine::new`] made it.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if a system cannot be decomposed; [`Error::NoTangents`].
    pub fn of_scene(machine: &Machine, seeds: &[Seed]) -> Result<Self, Error> {
        let mut tangents = Self::from_here(machine, seeds)?;
        for (line, change) in tangents.lines.iter_mut().zip(&tangents.changes) {
            begin(line, change, machine)?;
        }
        Ok(tangents)
    }

    /// From the present state, which stays as it is: only what follows varies.
    ///
    /// # Errors
    /// [`Error::NoTangents`] of a drive by chambers.
    pub fn from_here(machine: &Machine, seeds: &[Seed]) -> Result<Self, Error> {
        let model = machine.motion().model();
        if model.parameters.drive.source == Source::Chambers {
            return Err(Error::NoTangents);
        }
        let modes = model.piston.len() + model.bit.len();
        Ok(Self {
            seeds: seeds.to_vec(),
            changes: seeds.iter().map(|d| Change::of(*d, model)).collect(),
            lines: vec![Line::zero(modes); seeds.len()],
            parameters: model.parameters,
            responses: HashMap::new(),
            statics: HashMap::new(),
            passed: 0.0,
            since: machine.motion().state().now,
            kept: Vec::new(),
            ledger: false,
            summits: None,
            step: machine.motion().state().now,
            fresh: false,
            moment: None,
            last: None,
            cautions: kinks(model, seeds),
            uncounted: 0,
            time: machine.time(),
            rough: false,
            tape: None,
            story: false,
            stop: None,
            stopped: false,
        })
    }

    /// Carries the ledger too, from here on: see [`Derivative::ledger`](super::Derivative).
    #[must_use]
    pub fn with_ledger(mut self, machine: &Machine) -> Self {
        self.ledger = true;
        let body_state = machine.motion().whole_state();
        let here = Here::of(machine, &body_state);
        for (line, change) in self.lines.iter_mut().zip(&self.changes) {
            here.begin(line, change);
        }
        self
    }

    /// The lines that go a way again carry all that can be carried.
    pub(crate) fn carry_ledger(&mut self) {
        (self.ledger, self.summits) = (true, Some(Default::default()));
    }

    /// Carries the largest forces of a step too: see [`Derivative::peaks`](super::Derivative).
    #[must_use]
    pub fn with_peaks(mut self) -> Self {
        self.summits = Some(Default::default());
        self
    }

    /// What the derivatives are by, in their order.
    pub fn seeds(&self) -> &[Seed] {
        &self.seeds
    }

    /// Where the derivatives are one-sided or undefined, so far (the first thousand places).
    pub fn cautions(&self) -> &[Caution] {
        &self.cautions
    }

    /// How many such places there were.
    pub fn cautious(&self) -> u64 {
        self.uncounted + self.cautions.len() as u64
    }

    /// The least change of each parameter that would turn the order of two events, as the
    /// derivatives of their instants tell: a difference over more is no derivative.
    pub fn reach(&self) -> Vec<f64> {
        self.lines.iter().map(|l| l.reach).collect()
    }

    /// [`Machine::advance`], with the tangents.
    ///
    /// # Errors
    /// Those of [`Machine::advance`].
    pub fn advance(&mut self, machine: &mut Machine, to: f64) -> Result<(), Error> {
        self.begin_step(machine);
        machine.advance_before(to, self)
    }

    /// A step begins: peaks are looked for anew.
    pub(crate) fn begin_step(&mut self, machine: &Machine) {
        self.refresh(machine);
        self.step = machine.motion().state().now;
        self.summits = self.summits.take().map(|_| Default::default());
    }

    /// [`Machine::set_input`]; the derivative by an input goes on as it was.
    ///
    /// # Errors
    /// Those of [`Machine::set_input`].
    pub fn set_input(
        &mut self,
        machine: &mut Machine,
        input: Input,
        derivatives: &[f64],
    ) -> Result<(), Error> {
        self.arrive(machine);
        let done = machine.set_input(input, derivatives);
        self.settled(machine);
        done
    }

    /// [`Machine::retune`]; the derivatives go on with the new parameters.
    ///
    /// # Errors
    /// Those of [`Machine::retune`].
    pub fn retune(&mut self, machine: &mut Machine, tunables: &Parameters) -> Result<(), Error> {
        self.arrive(machine);
        let before = self.stored(machine);
        let done = machine.retune(tunables);
        self.settled(machine);
        self.refresh(machine);
        let after = self.stored(machine);
        for (line, (before, after)) in self.lines.iter_mut().zip(before.iter().zip(after)) {
            line.spent.retuned += after - before;
        }
        done
    }

    /// The derivatives as they stand, to be gone on from with the machine's own state.
    pub fn state(&mut self, machine: &Machine) -> TangentState {
        self.settle_viscous(machine.motion().model());
        let inputs = self.changes.iter().map(|c| c.inputs).collect();
        TangentState {
            lines: self.lines.clone(),
            inputs,
            since: self.since,
            ledger: self.ledger,
            summits: self.summits.clone(),
            step: self.step,
            fresh: self.fresh,
        }
    }

    /// Looks at the lines where the machine stands, and leaves them where they were: how often
    /// one looks must not show.
    pub(crate) fn at_present<T>(&mut self, machine: &Machine, read: impl FnOnce(&Self) -> T) -> T {
        let (lines, since, kept) = (self.lines.clone(), self.since, self.kept.len());
        let (summits, fresh) = (self.summits.clone(), self.fresh);
        let inputs: Vec<Inputs> = self.changes.iter().map(|c| c.inputs).collect();
        self.arrive(machine);
        let seen = read(self);
        (self.lines, self.since) = (lines, since);
        (self.summits, self.fresh) = (summits, fresh);
        self.kept.truncate(kept);
        self.changes.iter_mut().zip(inputs).for_each(|(change, was)| change.inputs = was);
        seen
    }

    /// Goes on from a state of derivatives by as many seeds; `machine` stands where it stood.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a state of other dimensions; nothing is changed then.
    pub fn resume(&mut self, machine: &Machine, state: &TangentState) -> Result<(), Error> {
        let modes = machine.motion().whole_state().len() / 2;
        let fits = |line: &Line| line.q.len() == modes && line.v.len() == modes;
        let count = self.seeds.len();
        if state.lines.len() != count
            || state.inputs.len() != count
            || !state.lines.iter().all(fits)
        {
            return Err(Error::Foreign);
        }
        self.refresh(machine);
        self.lines = state.lines.clone();
        for (change, inputs) in self.changes.iter_mut().zip(&state.inputs) {
            change.inputs = *inputs;
        }
        (self.ledger, self.summits) = (state.ledger, state.summits.clone());
        (self.since, self.step, self.fresh) = (state.since, state.step, state.fresh);
        self.kept.clear();
        (self.moment, self.last) = (None, None);
        Ok(())
    }

    /// Takes over parameters that have changed.
    fn refresh(&mut self, machine: &Machine) {
        let model = machine.motion().model();
        if self.parameters == model.parameters {
            return;
        }
        self.parameters = model.parameters;
        self.responses.clear();
        self.statics.clear();
        for (change, seed) in self.changes.iter_mut().zip(&self.seeds) {
            let inputs = change.inputs;
            *change = Change::of(*seed, model);
            change.inputs = inputs;
        }
    }

    /// Derivatives of the energy stored at present, if the ledger is carried.
    fn stored(&self, machine: &Machine) -> Vec<f64> {
        if !self.ledger {
            return Vec::new();
        }
        let body_state = machine.motion().whole_state();
        let here = Here::of(machine, &body_state);
        let lines = self.lines.iter().zip(&self.changes);
        lines.map(|(line, change)| here.stored(line, change).iter().sum()).collect()
    }

    /// True if legs must say where they lead.
    fn places(&self) -> bool {
        self.ledger || self.tape.is_some()
    }

    /// Brings the lines to the present.
    pub(crate) fn arrive(&mut self, machine: &Machine) {
        let motion = machine.motion();
        let now = motion.state().now;
        if now > self.since {
            let leg = Leg::of(motion, self.since, now, self.places());
            self.cross(motion.model(), &leg);
            self.since = now;
            if let Some(tape) = &mut self.tape {
                tape.push((leg, None));
            }
        }
    }

    /// The epoch may have moved to the present, where the lines stand.
    fn settled(&mut self, machine: &Machine) {
        let now = machine.motion().state().now;
        self.passed += self.since - now;
        self.since = now;
    }
}

impl Observer for Tangents {
    fn before(&mut self, machine: &Machine, at: f64, event: Event) {
        let motion = machine.motion();
        let leg = Leg::of(motion, self.since.min(at), at, self.places());
        self.cross(motion.model(), &leg);
        self.moment = Some(Moment::before(machine, &leg, at, self.passed + at, event));
        if let Some(tape) = &mut self.tape {
            tape.push((leg, None));
        }
    }

    fn after(&mut self, machine: &Machine) -> bool {
        let Some(mut moment) = self.moment.take() else { return false };
        (self.since, self.passed, self.step) = (0.0, 0.0, 0.0);
        moment.after(machine);
        self.pass(machine.motion().model(), &moment);
        if let Some((_, kept)) = self.tape.as_mut().and_then(|tape| tape.last_mut()) {
            *kept = Some(moment.clone());
        }
        self.stopped = self.stop.is_some_and(|stop| stop(&moment));
        self.stopped
    }

    fn along(&mut self, machine: &Machine, at: f64) {
        let motion = machine.motion();
        let leg = Leg::of(motion, self.since.min(at), at, self.places());
        self.cross(motion.model(), &leg);
        (self.since, self.passed, self.step) = (0.0, self.passed + at, 0.0);
        if let Some(tape) = &mut self.tape {
            tape.push((leg, None));
        }
    }
}
