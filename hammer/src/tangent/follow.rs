//! Walking with a machine.

use crate::error::Error;
use crate::machine::{Machine, Witness};
use crate::modal::model::{Model, Span};
use crate::modal::system::CHANNELS;
use crate::numerics::poly::Poly;
use crate::physics::event::Event;
use crate::physics::event::RockEvent;
use crate::physics::inputs::{Input, Inputs};
use crate::physics::mode::RockMode;
use crate::physics::parameters::{Fidelity, Parameters, Source, Tunables};
use crate::physics::rock::Spring;
use crate::tangent::change::Change;
use crate::tangent::event::{Caution, Doubt};
use crate::tangent::leg::{Leg, Moment, Run};
use crate::tangent::line::Line;
use crate::tangent::response::{Path, Response};
use crate::tangent::seed::{Parameter, Seed};
use crate::tangent::statics::Statics;
use crate::tangent::variation::variation;
use crate::tangent::viscous::Kept;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// Cautions kept; more are counted.
const MAX_CAUTIONS: usize = 1000;

/// The derivatives of a machine's motion; see the [module](super).
#[derive(Debug)]
pub struct Tangents {
    pub(crate) seeds: Vec<Seed>,
    pub(crate) changes: Vec<Change>,
    pub(crate) lines: Vec<Line>,
    parameters: Parameters,
    responses: HashMap<(usize, Span), Arc<Response>>,
    statics: HashMap<Span, Arc<Statics>>,
    /// From the last event to the epoch, s.
    passed: f64,
    /// Where the lines stand, after the epoch.
    pub(crate) since: f64,
    kept: Vec<Kept>,
    moment: Option<Moment>,
    last: Option<(Event, f64)>,
    cautions: Vec<Caution>,
    uncounted: u64,
    /// Of the last event, s.
    time: f64,
    /// Digits were lost beside a slow coordinate; told once.
    rough: bool,
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
}

impl Tangents {
    /// From the start of a scene: the start state too depends on the parameters. `machine`
    /// must be as [`Machine::new`] made it.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if a system cannot be decomposed; [`Error::NoTangents`].
    pub fn of_scene(machine: &Machine, seeds: &[Seed]) -> Result<Self, Error> {
        let mut tangents = Self::from_here(machine, seeds)?;
        tangents.begin(machine)?;
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
        self.refresh(machine);
        machine.advance_before(to, self)
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
    pub fn retune(&mut self, machine: &mut Machine, tunables: &Tunables) -> Result<(), Error> {
        self.arrive(machine);
        let done = machine.retune(tunables);
        self.settled(machine);
        self.refresh(machine);
        done
    }

    /// The derivatives as they stand, to be gone on from with the machine's own state.
    pub fn state(&mut self, machine: &Machine) -> TangentState {
        self.settle_viscous(machine.motion().model());
        let inputs = self.changes.iter().map(|c| c.inputs).collect();
        TangentState { lines: self.lines.clone(), inputs, since: self.since }
    }

    /// Looks at the lines where the machine stands, and leaves them where they were: how often
    /// one looks must not show.
    pub(crate) fn at_present<T>(&mut self, machine: &Machine, read: impl FnOnce(&Self) -> T) -> T {
        let (lines, since, kept) = (self.lines.clone(), self.since, self.kept.len());
        let inputs: Vec<Inputs> = self.changes.iter().map(|c| c.inputs).collect();
        self.arrive(machine);
        let seen = read(self);
        (self.lines, self.since) = (lines, since);
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
        self.since = state.since;
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

    /// Brings the lines to the present.
    pub(crate) fn arrive(&mut self, machine: &Machine) {
        let motion = machine.motion();
        let now = motion.state().now;
        if now > self.since {
            let leg = Leg::of(motion, self.since, now);
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

    /// Response of a run's system to the change of a line.
    fn response(&mut self, model: &Model, run: &Run, index: usize) -> Arc<Response> {
        // All that leave the systems as they are have one response.
        let changes = matches!(self.seeds[index], Seed::Parameter(_));
        let key = (if changes { index } else { usize::MAX }, run.span);
        if let Some(response) = self.responses.get(&key) {
            return response.clone();
        }
        let variation = variation(model, run.span, &self.changes[index]);
        let make = || Arc::new(Statics::new(model, run.span, &run.system));
        let statics = self.statics.entry(run.span).or_insert_with(make).clone();
        let response = Arc::new(Response::new(&run.system, statics, &variation));
        self.responses.insert(key, response.clone());
        response
    }

    /// Carries the lines along a leg.
    pub(crate) fn cross(&mut self, model: &Model, leg: &Leg) {
        if leg.span <= 0.0 {
            return;
        }
        if leg.is_rough() && !self.rough {
            self.rough = true;
            let doubt = Doubt::Rounding;
            self.warn(Caution { time: self.time, event: None, doubt, transversality: 0.0 });
        }
        let relay = leg.mode.relay;
        let changes: Vec<[Poly; CHANNELS]> =
            self.changes.iter().map(|c| c.loads(&self.parameters, &leg.inputs, relay)).collect();
        for (place, run) in leg.runs.iter().enumerate() {
            let range = model.range(run.span);
            let keeps = place == 0 && leg.is_viscous();
            let mut kept = Vec::new();
            for (index, changes) in changes.iter().enumerate() {
                let response = self.response(model, run, index);
                let path = Path {
                    system: &run.system,
                    start: &run.start,
                    end: &run.end,
                    span: leg.span,
                    loads: &leg.loads,
                    changes,
                };
                let line = &mut self.lines[index];
                let mut body_state = line.part(range.clone());
                let begun = response.carry(&path, &mut body_state);
                line.set_part(range.clone(), &body_state);
                if keeps {
                    kept.push((response, begun, *changes));
                }
            }
            if keeps {
                let (system, start) = (run.system.clone(), run.start.clone());
                let (span, loads) = (leg.span, leg.loads);
                self.kept.push(Kept { system, start, span, loads, lines: kept });
            }
        }
        for change in &mut self.changes {
            change.inputs.shift(leg.span);
        }
    }

    /// Carries the lines through an event.
    pub(crate) fn pass(&mut self, model: &Model, moment: &Moment) {
        if moment.event == Event::Rock(RockEvent::Barrier) {
            self.settle_viscous(model);
        }
        let before: Vec<f64> = self.lines.iter().map(|l| l.instant).collect();
        for (line, change) in self.lines.iter_mut().zip(&self.changes) {
            moment.pass(line, change, model);
        }
        if !self.story {
            self.lines.iter_mut().for_each(|line| line.strikes.clear());
        }
        self.doubt(model, moment, &before);
        let viscous = |rock| rock == RockMode::DissipativeForward;
        if !(viscous(moment.entered.rock) && viscous(moment.mode.rock)) {
            self.kept.clear();
        }
    }

    /// Sums up the dashpot's work of the cycle that ends at the barrier.
    fn settle_viscous(&mut self, model: &Model) {
        let viscosity = model.parameters.rock.viscosity;
        for kept in std::mem::take(&mut self.kept) {
            let (whole, parts) = kept.squares();
            for ((line, change), part) in self.lines.iter_mut().zip(&self.changes).zip(parts) {
                line.psi += viscosity * part + change.rock.viscosity * whole;
            }
        }
    }

    /// Notes where derivatives do not hold on both sides.
    fn doubt(&mut self, model: &Model, moment: &Moment, before: &[f64]) {
        let mut doubts: Vec<Doubt> = moment.doubt(model).into_iter().collect();
        if let Some((other, blur)) = self.last {
            // A contact changes no derivative: with it the order does not matter.
            let both = moment.event != Event::Contact && other != Event::Contact;
            let parted = before.iter().zip(&self.lines).any(|(was, line)| {
                (line.instant - was).abs() > 1e-6 * line.instant.abs().max(was.abs())
            });
            if both && parted && moment.spacing <= blur.max(moment.blur()) {
                doubts.push(Doubt::Tie);
            }
        }
        self.last = Some((moment.event, moment.blur()));
        for doubt in doubts {
            self.warn(Caution {
                time: moment.time,
                event: Some(moment.event),
                doubt,
                transversality: moment.transversality(),
            });
        }
        self.time = moment.time;
    }

    fn warn(&mut self, caution: Caution) {
        if self.cautions.len() < MAX_CAUTIONS {
            self.cautions.push(caution);
        } else {
            self.uncounted += 1;
        }
    }

    /// Other lines, from the start of a way.
    pub(crate) fn start_anew(&mut self, lines: Vec<Line>) {
        self.story = true;
        self.lines = lines;
        for line in &mut self.lines {
            line.started = line.origin + line.unloaded;
        }
        self.kept.clear();
        self.last = None;
    }

    /// Goes a way again that was taped before, from where the lines stand now.
    pub(crate) fn replay(&mut self, model: &Model, tape: &[(Leg, Option<Moment>)]) {
        for (leg, moment) in tape {
            self.cross(model, leg);
            if let Some(moment) = moment {
                self.pass(model, moment);
            }
        }
        self.settle_viscous(model);
    }

    /// The start of the scene: the bit in static equilibrium, or strained as its loads strain it
    /// with the tip just touching; the piston `g0` above, at its velocity.
    fn begin(&mut self, machine: &Machine) -> Result<(), Error> {
        let motion = machine.motion();
        let (model, state) = (motion.model(), motion.state());
        let p = model.piston.len();
        let root = model.piston.mass.sqrt();
        let rock = state.mode.rock;
        for index in 0..self.lines.len() {
            let change = self.changes[index].clone();
            let line = &mut self.lines[index];
            line.q[0] = -change.gap * root;
            line.v[0] = change.velocity * root;
            let span = Span::Bit(Spring::of(rock));
            let system = model.system(span, state.mode)?;
            let statics = Arc::new(Statics::new(model, span, &system));
            let response = Response::new(&system, statics, &variation(model, span, &change));
            // The equilibrium is that of the values: what follows of a polynomial moves it.
            let steady = |loads: [Poly; CHANNELS]| loads.map(|p| Poly::constant(p.0[0]));
            let held = steady(state.loads);
            let loads = steady(change.loads(&self.parameters, &state.inputs, state.mode.relay));
            let still = vec![0.0; 2 * system.blocks()];
            let path = Path {
                system: &system,
                start: &still,
                end: &still,
                span: 0.0,
                loads: &held,
                changes: &loads,
            };
            let body_state = response.standing(&path);
            let line = &mut self.lines[index];
            line.set_part(p..p + model.bit.len(), &body_state);
            if rock == RockMode::FreeFlight {
                line.q[p] -= line.tip(model)[0] / model.bit.bottom[0];
            }
            // A strained bit that has lifted the piston moves it on.
            if machine.kinematics().piston_position < -model.resolutions[0] {
                line.q[0] += line.gap(model)[0] * root;
            }
        }
        Ok(())
    }
}

impl Witness for Tangents {
    fn before(&mut self, machine: &Machine, at: f64, event: Event) {
        let motion = machine.motion();
        let leg = Leg::of(motion, self.since.min(at), at);
        self.cross(motion.model(), &leg);
        self.moment = Some(Moment::before(machine, &leg, at, self.passed + at, event));
        if let Some(tape) = &mut self.tape {
            tape.push((leg, None));
        }
    }

    fn after(&mut self, machine: &Machine) -> bool {
        let Some(mut moment) = self.moment.take() else { return false };
        (self.since, self.passed) = (0.0, 0.0);
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
        let leg = Leg::of(motion, self.since.min(at), at);
        self.cross(motion.model(), &leg);
        (self.since, self.passed) = (0.0, self.passed + at);
        if let Some(tape) = &mut self.tape {
            tape.push((leg, None));
        }
    }
}

/// What has no derivative to begin with: the collision of rigid bodies lasts as the shorter of
/// them has it, and that of stepped ones is read off a lattice.
fn kinks(model: &Model, seeds: &[Seed]) -> Vec<Caution> {
    use Parameter::{BitLength, CrossSection, PistonLength};
    let p = &model.parameters;
    let (piston, bit) = (p.piston.segments == 0, p.bit.segments == 0);
    let kink = |seed: &Seed| match seed {
        Seed::Parameter(PistonLength) => piston && (!bit || p.piston.length == p.bit.length),
        Seed::Parameter(BitLength) => bit && (!piston || p.piston.length == p.bit.length),
        Seed::Parameter(CrossSection) => piston != bit,
        _ => false,
    };
    let caution = Caution { time: 0.0, event: None, doubt: Doubt::Branch, transversality: 0.0 };
    let rigid = p.fidelity == Fidelity::Rigid;
    seeds.iter().filter(|seed| rigid && kink(seed)).map(|_| caution).collect()
}
