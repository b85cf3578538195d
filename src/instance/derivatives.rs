//! Derivatives, on demand.

use super::cycle::{Followed, Question, known, name_of};
use super::{Instance, Phase, finite};
use crate::fault::Fault;
use crate::gradient::{self, Demand, FEATURES, Known, ON_DEMAND, PICKS, Pick, Place, SETTINGS};
use hammer::periodic::{Cycle, Orbit, Search};
use hammer::tangent::{Derivative, Seed, Tangents};
use hammer::{Machine, State};

/// What is known of derivatives and cycles.
pub(super) struct Derivatives {
    /// Value references asked for by the end of initialization mode.
    pub wanted: Vec<u32>,
    /// What else was asked for by then: the ledger, the largest forces.
    pub demanded: [bool; 2],
    /// These, carried along since.
    pub carried: Option<Tangents>,
    /// Start of the last step, and the state there if an event has moved it since.
    pub step: Option<(f64, Option<Box<State>>)>,
    view: Option<Vec<Derivative>>,
    pub settings: [f64; SETTINGS.len()],
    pub cycle: Option<(Question, Cycle)>,
    pub cycle_seeds: Vec<Seed>,
    pub orbit: Option<Orbit>,
    pub branch: Option<Followed>,
    cautious: u64,
}

impl Default for Derivatives {
    fn default() -> Self {
        let search = Search::default();
        Self {
            wanted: Vec::new(),
            demanded: [false; 2],
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
    OnDemand(usize),
    Reach,
    Cycle(usize),
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
            "GetDirectionalDerivative",
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
        let demands = demands(&unknowns);
        let derivatives =
            if motions { self.motion_derivatives(knowns, &by, demands)? } else { Vec::new() };
        let gradients = if cycles { self.cycle_gradients(&by)? } else { Vec::new() };
        let sum = |unknown: &Unknown| -> f64 {
            let part = |k: usize| match unknown {
                Unknown::Output(pick) => pick(&derivatives[k].0),
                Unknown::OnDemand(index) => ON_DEMAND[*index].2(&derivatives[k].0),
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
            None => match ON_DEMAND.iter().position(|(known, ..)| *known == name) {
                Some(index) => Ok(Unknown::OnDemand(index)),
                None => {
                    let text = format!("{name} has no derivative: it is not {wanted}");
                    Err(Fault::Argument(text))
                }
            },
        }
    }

    /// The derivatives by each, with their reaches.
    fn motion_derivatives(
        &mut self,
        references: &[u32],
        by: &[Known],
        demands: [bool; 2],
    ) -> Result<Vec<(Derivative, f64)>, Fault> {
        let mut out = vec![(Derivative::default(), f64::INFINITY); by.len()];
        let steps: Vec<usize> =
            (0..by.len()).filter(|k| matches!(by[*k], Known::Step(_))).collect();
        if !steps.is_empty() {
            let seeds: Vec<Seed> = steps.iter().map(|k| by[*k].seed()).collect();
            for (k, derivative) in steps.iter().zip(self.over_step(&seeds, demands)?) {
                out[*k] = derivative;
            }
        }
        for k in (0..by.len()).filter(|k| matches!(by[*k], Known::Start(_))) {
            out[k] = self.since_start(references[k], by[k].seed(), demands)?;
        }
        Ok(out)
    }

    /// By constants added to inputs over the last step; where there was none, by what shows at
    /// once.
    fn over_step(
        &mut self,
        seeds: &[Seed],
        demands: [bool; 2],
    ) -> Result<Vec<(Derivative, f64)>, Fault> {
        let running = self.phase == Phase::Stepping || self.phase == Phase::Terminated;
        let step = self.derivatives.step.clone().filter(|_| running);
        let machine = self.machine()?;
        let Some((start, moved)) = step else {
            let tangents = if running {
                Tangents::from_here(machine, seeds)?
            } else {
                Tangents::of_scene(machine, seeds)?
            };
            let mut tangents = demanding(tangents, machine, demands);
            return Ok(looked(&mut tangents, machine));
        };
        let present = machine.state();
        let begun = moved.map_or_else(|| present.looked_at(start), |state| *state);
        let end = machine.time();
        machine.restore(&begun)?;
        let found = Tangents::from_here(machine, seeds).and_then(|tangents| {
            let mut tangents = demanding(tangents, machine, demands);
            tangents.advance(machine, end)?;
            Ok(looked(&mut tangents, machine))
        });
        machine.restore(&present)?;
        Ok(found?)
    }

    /// By a parameter, or a constant added to an input, since the start.
    fn since_start(
        &mut self,
        reference: u32,
        seed: Seed,
        demands: [bool; 2],
    ) -> Result<(Derivative, f64), Fault> {
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            if !self.derivatives.wanted.contains(&reference) {
                self.derivatives.wanted.push(reference);
            }
            for (known, new) in self.derivatives.demanded.iter_mut().zip(demands) {
                *known |= new;
            }
            let machine = self.machine()?;
            let tangents = Tangents::of_scene(machine, &[seed])?;
            let mut tangents = demanding(tangents, machine, demands);
            return looked(&mut tangents, machine).pop().ok_or(Fault::Failed);
        }
        let Some(place) = self.derivatives.wanted.iter().position(|r| *r == reference) else {
            let name = name_of(reference).unwrap_or("an offset");
            return Err(Fault::Argument(format!(
                "the derivative by {name} is carried along from the start: ask for it by the end of \
                 initialization mode"
            )));
        };
        let carried = self.derivatives.demanded;
        if demands.iter().zip(carried).any(|(new, known)| *new && !known) {
            let text = "derivatives of energies, impulses and largest forces are carried along \
                        from the start: ask for such an output by the end of initialization mode";
            return Err(Fault::Argument(text.into()));
        }
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
        let demanded = self.derivatives.demanded;
        let machine = self.machine()?;
        let tangents = demanding(Tangents::of_scene(machine, &seeds)?, machine, demanded);
        self.derivatives.carried = Some(tangents);
        Ok(())
    }
}

/// What the unknowns need that is not carried unasked.
fn demands(unknowns: &[Unknown]) -> [bool; 2] {
    [Demand::Ledger, Demand::Peaks].map(|demand| {
        let needs = |u: &Unknown| matches!(u, Unknown::OnDemand(i) if ON_DEMAND[*i].1 == demand);
        unknowns.iter().any(needs)
    })
}

fn demanding(tangents: Tangents, machine: &Machine, [ledger, peaks]: [bool; 2]) -> Tangents {
    let tangents = if ledger { tangents.with_ledger(machine) } else { tangents };
    if peaks { tangents.with_peaks() } else { tangents }
}

fn looked(tangents: &mut Tangents, machine: &Machine) -> Vec<(Derivative, f64)> {
    let derivatives = tangents.look(machine);
    derivatives.into_iter().zip(tangents.reach()).collect()
}
