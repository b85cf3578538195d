//! Derivatives and the stationary cycle, on demand.

use super::{Instance, Phase, finite};
use crate::fault::Fault;
use crate::gradient::{self, FEATURES, Known, PICKS, Pick, Place, SETTINGS};
use crate::variables::{Role, Slot, VARIABLES};
use hammer::cycle::{Branch, Cycle, Orbit, Search, stationary};
use hammer::tangent::{Derivative, Seed, Tangents};
use hammer::{Input, InputValues, Machine, Parameters, State};

/// What a cycle was found for.
#[derive(Clone, PartialEq)]
struct Question {
    parameters: Parameters,
    inputs: InputValues,
    settings: [f64; SETTINGS.len()],
    seeds: Vec<Seed>,
}

/// What is known of derivatives and cycles.
pub(super) struct Derivatives {
    /// Value references asked for by the end of initialization mode.
    pub wanted: Vec<u32>,
    /// These, carried along since.
    pub carried: Option<Tangents>,
    /// Start of the last step, and the state there if an event has moved it since.
    pub step: Option<(f64, Option<Box<State>>)>,
    view: Option<Vec<Derivative>>,
    settings: [f64; SETTINGS.len()],
    cycle: Option<(Question, Cycle)>,
    cycle_seeds: Vec<Seed>,
    orbit: Option<Orbit>,
    branch: Option<Followed>,
    cautious: u64,
}

/// A branch, and how far it was followed.
struct Followed {
    /// Of which scene.
    scene: (Parameters, InputValues),
    branch: Branch,
    waypoint: f64,
    value: f64,
    rises: bool,
    over: bool,
}

impl Default for Derivatives {
    fn default() -> Self {
        let search = Search::default();
        Self {
            wanted: Vec::new(),
            carried: None,
            step: None,
            view: None,
            settings: [
                search.laps as f64,
                0.0,
                search.settle as f64,
                search.steps as f64,
                search.limit,
                search.multipliers as f64,
                -1.0,
                0.0,
                0.0,
            ],
            cycle: None,
            cycle_seeds: Vec::new(),
            orbit: None,
            branch: None,
            cautious: 0,
        }
    }
}

impl Derivatives {
    /// The communication point is passed.
    pub(super) fn pass(&mut self) {
        self.view = None;
    }
}

/// What an unknown is.
enum Unknown {
    Output(Pick),
    Reach,
    Cycle(usize),
}

fn name_of(reference: u32) -> Option<&'static str> {
    VARIABLES.get(reference as usize).map(|variable| variable.name)
}

/// The seeds of value references that were let through.
pub(super) fn seeds(references: &[u32]) -> Vec<Seed> {
    references.iter().filter_map(|r| Known::of(*r, name_of(*r))).map(Known::seed).collect()
}

impl Instance {
    /// `sum_k d unknown / d known_k direction_k`.
    ///
    /// # Errors
    /// Variables that have no derivative or are none to differentiate by; a parameter that was
    /// not asked for in time; a cycle that is not found.
    pub fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
    ) -> Result<Vec<f64>, Fault> {
        use Phase::{Initialization, Instantiated, Stepping, Terminated};
        self.demand(
            "fmi2GetDirectionalDerivative",
            &[Instantiated, Initialization, Stepping, Terminated],
        )?;
        for value in direction {
            finite("dvKnown", *value)?;
        }
        let unknowns = unknowns.iter().map(|r| self.unknown(*r)).collect::<Result<Vec<_>, _>>()?;
        let read = self.settings.parameters()?;
        let known = |r: &u32| known(*r, &read);
        let by = knowns.iter().map(known).collect::<Result<Vec<_>, _>>()?;
        let cycles = unknowns.iter().any(|u| matches!(u, Unknown::Cycle(_)));
        let motions = unknowns.iter().any(|u| !matches!(u, Unknown::Cycle(_)));
        let derivatives = if motions { self.motion_derivatives(knowns, &by)? } else { Vec::new() };
        let gradients = if cycles { self.cycle_gradients(&by)? } else { Vec::new() };
        let sum = |unknown: &Unknown| -> f64 {
            let part = |k: usize| match unknown {
                Unknown::Output(pick) => pick(&derivatives[k].0),
                Unknown::Reach => derivatives[k].1,
                Unknown::Cycle(index) => {
                    FEATURES[*index].derivative.map_or(0.0, |f| f(&gradients[k]))
                }
            };
            // What is not asked for may be infinite.
            (0..by.len()).filter(|k| direction[*k] != 0.0).map(|k| part(k) * direction[k]).sum()
        };
        Ok(unknowns.iter().map(sum).collect())
    }

    fn unknown(&self, reference: u32) -> Result<Unknown, Fault> {
        if reference == gradient::REACH {
            return Ok(Unknown::Reach);
        }
        if let Some(Place::Feature(index)) = Place::of(reference) {
            let feature = &FEATURES[index];
            return match feature.derivative {
                Some(_) => Ok(Unknown::Cycle(index)),
                None => Err(Fault::Argument(format!("cycle {} has no derivative", feature.name))),
            };
        }
        let name = name_of(reference);
        let wanted = "an output with derivatives";
        let name = name.ok_or(Fault::Reference { reference, wanted })?;
        match PICKS.iter().find(|(known, _)| *known == name) {
            Some((_, pick)) => Ok(Unknown::Output(*pick)),
            None => Err(Fault::Argument(format!("{name} has no derivative: it is not {wanted}"))),
        }
    }

    /// The derivatives by each, with their reaches.
    fn motion_derivatives(
        &mut self,
        references: &[u32],
        by: &[Known],
    ) -> Result<Vec<(Derivative, f64)>, Fault> {
        let mut out = vec![(Derivative::default(), f64::INFINITY); by.len()];
        let steps: Vec<usize> =
            (0..by.len()).filter(|k| matches!(by[*k], Known::Step(_))).collect();
        if !steps.is_empty() {
            let seeds: Vec<Seed> = steps.iter().map(|k| by[*k].seed()).collect();
            for (k, derivative) in steps.iter().zip(self.over_step(&seeds)?) {
                out[*k] = derivative;
            }
        }
        for k in (0..by.len()).filter(|k| matches!(by[*k], Known::Start(_))) {
            out[k] = self.since_start(references[k], by[k].seed())?;
        }
        Ok(out)
    }

    /// By constants added to inputs over the last step; where there was none, by what shows at
    /// once.
    fn over_step(&mut self, seeds: &[Seed]) -> Result<Vec<(Derivative, f64)>, Fault> {
        let running = self.phase == Phase::Stepping || self.phase == Phase::Terminated;
        let step = self.derivatives.step.clone().filter(|_| running);
        let machine = self.machine()?;
        let Some((start, moved)) = step else {
            let mut tangents = if running {
                Tangents::from_here(machine, seeds)?
            } else {
                Tangents::of_scene(machine, seeds)?
            };
            return Ok(looked(&mut tangents, machine));
        };
        let present = machine.state();
        let begun = moved.map_or_else(|| present.looked_at(start), |state| *state);
        let end = machine.time();
        machine.restore(&begun)?;
        let found = Tangents::from_here(machine, seeds).and_then(|mut tangents| {
            tangents.advance(machine, end)?;
            Ok(looked(&mut tangents, machine))
        });
        machine.restore(&present)?;
        Ok(found?)
    }

    /// By a parameter, or a constant added to an input, since the start.
    fn since_start(&mut self, reference: u32, seed: Seed) -> Result<(Derivative, f64), Fault> {
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            if !self.derivatives.wanted.contains(&reference) {
                self.derivatives.wanted.push(reference);
            }
            let machine = self.machine()?;
            let mut tangents = Tangents::of_scene(machine, &[seed])?;
            return looked(&mut tangents, machine).pop().ok_or(Fault::Failed);
        }
        let Some(place) = self.derivatives.wanted.iter().position(|r| *r == reference) else {
            let name = name_of(reference).unwrap_or("an offset");
            return Err(Fault::Argument(format!(
                "the derivative by {name} is carried along from the start: ask for it by the end of \
                 initialization mode"
            )));
        };
        let (Some(tangents), Some(machine)) = (&mut self.derivatives.carried, &self.machine) else {
            return Err(Fault::Failed);
        };
        if self.derivatives.view.is_none() {
            self.derivatives.view = Some(tangents.look(machine));
        }
        let reach = tangents.reach();
        match (&self.derivatives.view, reach.get(place)) {
            (Some(view), Some(reach)) => Ok((view[place], *reach)),
            _ => Err(Fault::Failed),
        }
    }

    /// Number of places since the start where the derivatives do not hold on both sides.
    pub(super) fn cautions(&self) -> f64 {
        self.derivatives.carried.as_ref().map_or(0, Tangents::cautious) as f64
    }

    /// Places that the log has not told of yet.
    pub(super) fn fresh_cautions(&mut self) -> Option<String> {
        let tangents = self.derivatives.carried.as_ref()?;
        let (told, now) = (self.derivatives.cautious, tangents.cautious());
        self.derivatives.cautious = now;
        let last = tangents.cautions().last()?;
        (now > told).then(|| {
            let event = last.event.map_or("the scene".into(), |event| event.to_string());
            format!(
                "derivatives hold on one side at most: {} places, the last {event} at {} s ({:?}, \
                 transversality {:.1e})",
                now - told,
                last.time,
                last.doubt,
                last.transversality
            )
        })
    }

    /// Begins to carry what was asked for.
    pub(super) fn begin_derivatives(&mut self) -> Result<(), Fault> {
        if self.derivatives.wanted.is_empty() {
            return Ok(());
        }
        let seeds = seeds(&self.derivatives.wanted);
        let machine = self.machine()?;
        let tangents = Tangents::of_scene(machine, &seeds)?;
        self.derivatives.carried = Some(tangents);
        Ok(())
    }

    /// A number of the stationary cycle.
    pub(super) fn cycle_number(&mut self, place: Place) -> Result<f64, Fault> {
        match place {
            Place::Setting(index) => Ok(self.derivatives.settings[index]),
            Place::Branch(index) => {
                self.cycle()?;
                let truth = |t: bool| f64::from(u8::from(t));
                let branch = self.derivatives.branch.as_ref();
                let at = branch.map(|b| [b.value, truth(b.rises), truth(b.over)]);
                at.map(|at| at[index])
                    .ok_or_else(|| Fault::Argument("no branch is followed".into()))
            }
            Place::Feature(index) => Ok((FEATURES[index].value)(self.cycle()?)),
            Place::Multiplier(index, part) => {
                let multiplier = self.cycle()?.multipliers.get(index).copied().unwrap_or_default();
                Ok([multiplier.re, multiplier.im][part])
            }
        }
    }

    /// Sets how the cycle is sought.
    ///
    /// # Errors
    /// A number that is none, or below its least.
    pub(super) fn set_search(&mut self, index: usize, value: f64) -> Result<(), Fault> {
        let name = SETTINGS[index];
        finite(name, value)?;
        let (least, most) = [
            (1.0, 64.0),
            (0.0, 2.0),
            (0.0, 1e4),
            (0.0, 1e4),
            (1e-6, 1e3),
            (0.0, 200.0),
            (-1.0, 1e4),
            (-1.0, 1.0),
            (0.0, 1e9),
        ][index];
        if !(least..=most).contains(&value) {
            let text =
                format!("cycle {name} = {value} is not allowed: it must be {least} to {most}");
            return Err(Fault::Argument(text));
        }
        self.derivatives.settings[index] = value;
        Ok(())
    }

    fn cycle_gradients(&mut self, by: &[Known]) -> Result<Vec<hammer::cycle::Gradient>, Fault> {
        for known in by {
            let seed = known.seed();
            if !self.derivatives.cycle_seeds.contains(&seed) {
                self.derivatives.cycle_seeds.push(seed);
            }
        }
        let seeds = self.derivatives.cycle_seeds.clone();
        let cycle = self.cycle()?;
        let found = |known: &Known| seeds.iter().position(|s| *s == known.seed());
        let gradient = |known| found(known).and_then(|k| cycle.gradients.get(k)).cloned();
        by.iter().map(|known| gradient(known).ok_or(Fault::Failed)).collect()
    }

    /// The cycle of the present parameters and inputs.
    fn cycle(&mut self) -> Result<&Cycle, Fault> {
        let value = |input: Input| self.input(input);
        let question = Question {
            parameters: self.settings.parameters()?,
            inputs: InputValues {
                feed_force: value(Input::FeedForce),
                drive_force: value(Input::DriveForce),
                drive_pressure: value(Input::DrivePressure),
                return_pressure: value(Input::ReturnPressure),
            },
            settings: self.derivatives.settings,
            seeds: self.derivatives.cycle_seeds.clone(),
        };
        let known = self.derivatives.cycle.take().filter(|(asked, _)| *asked == question);
        let answer = match known {
            Some((_, cycle)) => cycle,
            None => self.seek(&question)?,
        };
        Ok(&self.derivatives.cycle.insert((question, answer)).1)
    }

    fn seek(&mut self, question: &Question) -> Result<Cycle, Fault> {
        let [laps, continues, settle, steps, limit, multipliers, along, stride, waypoint] =
            question.settings;
        let mut machine = Machine::new(&question.parameters, &question.inputs, 0.0)?;
        let start = self.derivatives.orbit.clone().filter(|_| continues > 0.0);
        let search = Search {
            laps: laps as usize,
            settle: if continues == 1.0 && start.is_some() { 0 } else { settle as usize },
            start,
            steps: steps as usize,
            limit,
            multipliers: multipliers as usize,
            ..Search::default()
        };
        let refuse = |error: hammer::cycle::CycleError| Fault::Argument(error.to_string());
        if waypoint > 0.0 {
            return self.follow(question, &search, [along, stride, waypoint]);
        }
        let cycle = stationary(&mut machine, &search, &question.seeds).map_err(refuse)?;
        self.derivatives.orbit = Some(cycle.orbit.clone());
        self.derivatives.branch = None;
        Ok(cycle)
    }

    /// The branch's next point.
    fn follow(
        &mut self,
        question: &Question,
        search: &Search,
        [along, stride, waypoint]: [f64; 3],
    ) -> Result<Cycle, Fault> {
        let refuse = |error: hammer::cycle::CycleError| Fault::Argument(error.to_string());
        let last = self.derivatives.branch.as_ref().map_or(0.0, |b| b.waypoint);
        if waypoint != last + 1.0 {
            let text = format!("cycle waypoint = {waypoint} does not follow {last}");
            return Err(Fault::Argument(text));
        }
        if stride == 0.0 {
            return Err(Fault::Argument("cycle branch_stride = 0 leads nowhere".into()));
        }
        if self.derivatives.branch.is_none() {
            let seed = known(along.max(0.0) as u32, &question.parameters)?.seed();
            let orbit = self.derivatives.orbit.clone().filter(|_| along >= 0.0);
            let none = "a branch begins at a cycle, along a parameter: set branch_along, find one";
            let orbit = orbit.ok_or_else(|| Fault::Argument(none.into()))?;
            let (p, inputs) = (&question.parameters, &question.inputs);
            let branch =
                Branch::new(p, inputs, seed, search, &orbit, stride > 0.0).map_err(refuse)?;
            let value = f64::NAN;
            let scene = (*p, *inputs);
            let followed =
                Followed { scene, branch, waypoint: 0.0, value, rises: true, over: false };
            self.derivatives.branch = Some(followed);
        }
        let followed = self.derivatives.branch.as_mut().ok_or(Fault::Failed)?;
        if followed.scene != (question.parameters, question.inputs) {
            let text = "the scene has changed since the branch began: set cycle waypoint = 0";
            return Err(Fault::Argument(text.into()));
        }
        let next = followed.branch.next(stride.abs(), &question.seeds).map_err(refuse)?;
        (followed.waypoint, followed.value) = (waypoint, next.value);
        (followed.rises, followed.over) = (next.rising, next.over);
        Ok(next.cycle)
    }
}

fn looked(tangents: &mut Tangents, machine: &Machine) -> Vec<(Derivative, f64)> {
    let derivatives = tangents.look(machine);
    derivatives.into_iter().zip(tangents.reach()).collect()
}

fn known(reference: u32, parameters: &Parameters) -> Result<Known, Fault> {
    const WANTED: &str = "an input or a real parameter with derivatives";
    let name = name_of(reference);
    let known = Known::of(reference, name).ok_or_else(|| match name {
        Some(name) => {
            Fault::Argument(format!("there is no derivative by {name}: it is not {WANTED}"))
        }
        None => Fault::Reference { reference, wanted: WANTED },
    })?;
    if let Known::Start(Seed::Parameter(parameter)) = known
        && !gradient::is_read(parameter, parameters)
    {
        let name = parameter.name();
        let text =
            format!("there is no derivative by {name}: the bodies have sections of their own");
        return Err(Fault::Argument(text));
    }
    let real = VARIABLES.get(reference as usize).is_none_or(|variable| {
        matches!(variable.role, Role::Input { .. } | Role::Parameter { slot: Slot::Real(..), .. })
    });
    if real { Ok(known) } else { Err(Fault::Reference { reference, wanted: WANTED }) }
}
