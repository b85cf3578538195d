//! Carrying lines along legs and through events.

use crate::laws::event::{Event, RockEvent};
use crate::laws::mode::RockMode;
use crate::modal::model::Model;
use crate::modal::system::CHANNELS;
use crate::numerics::poly::Poly;
use crate::tangent::event::{Caution, Doubt};
use crate::tangent::follow::Tangents;
use crate::tangent::leg::{Leg, Moment, Place, Run};
use crate::tangent::line::Line;
use crate::tangent::response::{Path, Response};
use crate::tangent::seed::Seed;
use crate::tangent::statics::Statics;
use crate::tangent::summit::forces;
use crate::tangent::variation::variation;
use crate::tangent::varying::Works;
use crate::tangent::viscous::{Kept, KeptLine};
use std::cell::OnceCell;
use std::sync::Arc;

/// Cautions kept; more are counted.
const MAX_CAUTIONS: usize = 1000;

impl Tangents {
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
        let from: Vec<Place> = if self.ledger {
            self.lines.iter().map(|line| line.place(model)).collect()
        } else {
            Vec::new()
        };
        let mut works = vec![Works::default(); from.len()];
        self.climb(model, leg, &changes);
        for (place, run) in leg.runs.iter().enumerate() {
            let range = model.range(run.span);
            let keeps = place == 0 && leg.is_viscous();
            let wanted = keeps || self.ledger;
            let (mut kept, turns) = (Vec::new(), OnceCell::new());
            for (index, changes) in changes.iter().enumerate() {
                let response = self.response(model, run, index);
                let path = Path {
                    system: &run.system,
                    start: &run.start,
                    end: &run.end,
                    span: leg.span,
                    loads: &leg.loads,
                    changes,
                    turns: &turns,
                };
                let line = &mut self.lines[index];
                let mut body_state = line.part(range.clone());
                let mut ends = if wanted {
                    [vec![0.0; run.start.len()], vec![0.0; run.start.len()]]
                } else {
                    Default::default()
                };
                if !response.rests(&path, &body_state) {
                    response.carry(&path, &mut body_state, wanted.then_some(&mut ends));
                    line.set_part(range.clone(), &body_state);
                }
                if let Some(works) = works.get_mut(index) {
                    works.add(leg, run, &path, &response, &ends);
                }
                if keeps {
                    kept.push(KeptLine { response, ends, changes: *changes });
                }
            }
            if keeps {
                let system = run.system.clone();
                let ends = [run.start.clone(), run.end.clone()];
                let (span, loads) = (leg.span, leg.loads);
                self.kept.push(Kept { system, ends, span, loads, lines: kept });
            }
        }
        let lines = self.lines.iter_mut().zip(&self.changes).zip(&changes);
        for (((line, change), loads), (from, works)) in lines.zip(from.iter().zip(&works)) {
            leg.spend(line, from, change, (loads, works), model);
        }
        for change in &mut self.changes {
            change.inputs.shift(leg.span);
        }
        self.fresh = false;
    }

    /// Looks for the peaks of a leg, at whose start the lines stand.
    fn climb(&mut self, model: &Model, leg: &Leg, changes: &[[Poly; CHANNELS]]) {
        let Some(mut summits) = self.summits.take() else { return };
        let from = (self.step - self.since).max(0.0);
        for (summit, force) in summits.iter_mut().zip(forces(model, leg)) {
            summit.cut = None;
            let top = force.and_then(|f| Some((f.top(from, leg.span, summit.value)?, f)));
            let Some((top, force)) = top else { continue };
            // An event that begins the leg takes its start along.
            let begun = if top.at == 0.0 && self.fresh { top.rate } else { 0.0 };
            summit.cut = (top.at >= leg.span).then_some(top.rate);
            summit.value = top.value;
            summit.slopes.clear();
            let (run, turns) = (force.run, OnceCell::new());
            let range = model.range(run.span);
            for (index, changes) in changes.iter().enumerate() {
                let path = Path {
                    system: &run.system,
                    start: &run.start,
                    end: &top.z,
                    span: top.at,
                    loads: &leg.loads,
                    changes,
                    turns: &turns,
                };
                let mut line = self.lines[index].clone();
                let mut body_state = line.part(range.clone());
                self.response(model, run, index).carry(&path, &mut body_state, None);
                line.set_part(range.clone(), &body_state);
                let slope = force.slope(&top, &line, &self.changes[index], model);
                summit.slopes.push(slope + begun * line.instant);
            }
        }
        self.summits = Some(summits);
    }

    /// Carries the lines through an event.
    pub(crate) fn pass(&mut self, model: &Model, moment: &Moment) {
        let ledger = self.ledger;
        let paid = moment.event == Event::Rock(RockEvent::Barrier);
        if paid || ledger && moment.leaves_viscous() {
            self.settle_viscous(model);
        }
        let before: Vec<f64> = self.lines.iter().map(|l| l.instant).collect();
        for (line, change) in self.lines.iter_mut().zip(&self.changes) {
            let psi = line.psi;
            moment.pass(line, change, model);
            if ledger {
                moment.spend(line, psi, model);
            }
        }
        self.fresh = true;
        for summit in self.summits.iter_mut().flatten() {
            let rate = summit.cut.take().unwrap_or_default();
            for (slope, line) in summit.slopes.iter_mut().zip(&self.lines) {
                *slope += rate * line.instant;
            }
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
    pub(super) fn settle_viscous(&mut self, model: &Model) {
        let sums = self.pending(model);
        self.kept.clear();
        self.lines.iter_mut().zip(sums).for_each(|(line, sum)| line.psi += sum);
    }

    /// What is not in `psi` yet of the dashpot's work.
    pub(crate) fn pending(&self, model: &Model) -> Vec<f64> {
        let viscosity = model.parameters.rock.viscosity;
        let mut sums = vec![0.0; self.lines.len()];
        for kept in &self.kept {
            let (whole, parts) = kept.squares();
            for ((sum, change), part) in sums.iter_mut().zip(&self.changes).zip(parts) {
                *sum += viscosity * part + change.rock.viscosity * whole;
            }
        }
        sums
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
        // A way is one step.
        (self.step, self.fresh) = (f64::NEG_INFINITY, false);
        self.summits = self.summits.take().map(|_| Default::default());
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
}
