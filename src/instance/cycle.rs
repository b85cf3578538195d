//! The stationary cycle and its branches, on demand.

use super::{Instance, finite};
use crate::fault::Fault;
use crate::gradient::{FEATURES, Known, Place, SETTINGS};
use hammer::periodic::{Branch, Cycle, Search, stationary};
use hammer::tangent::Seed;
use hammer::variables::{Role, Slot, VARIABLES};
use hammer::{Input, InputValues, Machine, Parameters};

/// What a cycle was found for.
#[derive(Clone, PartialEq)]
pub(super) struct Question {
    parameters: Parameters,
    inputs: InputValues,
    settings: [f64; SETTINGS.len()],
    seeds: Vec<Seed>,
}

/// A branch, and how far it was followed.
pub(super) struct Followed {
    /// Of which scene.
    scene: (Parameters, InputValues),
    branch: Branch,
    waypoint: f64,
    value: f64,
    rises: bool,
    over: bool,
}

impl Instance {
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

    pub(super) fn cycle_gradients(
        &mut self,
        by: &[Known],
    ) -> Result<Vec<hammer::periodic::Gradient>, Fault> {
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
        let refuse = |error: hammer::periodic::CycleError| Fault::Argument(error.to_string());
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
        let refuse = |error: hammer::periodic::CycleError| Fault::Argument(error.to_string());
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

/// The name of a variable of the table.
pub(super) fn name_of(reference: u32) -> Option<&'static str> {
    VARIABLES.get(reference as usize).map(|variable| variable.name)
}

/// What a value reference is a derivative by, if it is one of this scene.
pub(super) fn known(reference: u32, parameters: &Parameters) -> Result<Known, Fault> {
    const WANTED: &str = "an input or a real parameter with derivatives";
    let name = name_of(reference);
    let known = Known::of(reference, name).ok_or_else(|| match name {
        Some(name) => {
            Fault::Argument(format!("there is no derivative by {name}: it is not {WANTED}"))
        }
        None => Fault::Reference { reference, wanted: WANTED },
    })?;
    if let Known::Start(Seed::Parameter(parameter)) = known
        && !parameter.is_read(parameters)
    {
        let name = parameter.name();
        let text = format!("there is no derivative by {name}: no body of these sections reads it");
        return Err(Fault::Argument(text));
    }
    let real = VARIABLES.get(reference as usize).is_none_or(|variable| {
        matches!(variable.role, Role::Input { .. } | Role::Parameter { slot: Slot::Real(..), .. })
    });
    if real { Ok(known) } else { Err(Fault::Reference { reference, wanted: WANTED }) }
}
