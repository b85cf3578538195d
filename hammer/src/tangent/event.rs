//! The derivative through an event: its instant, what jumps, what is remembered.

use crate::laws::event::Event;
use crate::laws::event::RockEvent;
use crate::laws::mode::Relay;
use crate::laws::mode::RockMode;
use crate::laws::rock::Spring;
use crate::modal::model::Model;
use crate::tangent::change::Change;
use crate::tangent::leg::Moment;
use crate::tangent::line::{Line, Mark, Strike};

/// A slope below this part of the sum of its terms' sizes grazes: rounding leaves it fewer
/// than seven digits.
const GRAZE: f64 = 1e-9;
/// Instants whose derivatives differ by less than this part of them are one.
const SAME: f64 = 1e-9;

/// Why a derivative may hold on one side only, or not at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The guard is crossed with hardly any slope, and forces jump there: the event's instant
    /// goes like a square root.
    Graze,
    /// Two events within their resolution, which a change of the parameter parts differently.
    Tie,
    /// A load varies quickly beside a slow coordinate: the derivative has lost digits.
    Rounding,
    /// A number stands where the law's branches meet: `dp` at `dps`, or equal lengths of
    /// rigid bodies.
    Branch,
}

/// A place where the derivative is one-sided or undefined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caution {
    /// When, s.
    pub time: f64,
    /// The event; none for the scene as a whole.
    pub event: Option<Event>,
    /// Why.
    pub doubt: Doubt,
    /// Transversality: the guard's slope over the sum of its terms' sizes.
    pub transversality: f64,
}

impl Moment {
    /// What makes the derivative doubtful whatever it is by.
    pub(crate) fn doubt(&self, model: &Model) -> Option<Doubt> {
        let parameters = &model.parameters;
        let rock = &parameters.rock;
        let jumps = match self.event {
            Event::Relay(_) | Event::Port { .. } => self.drive[0] != self.drive[1],
            Event::Rock(RockEvent::Barrier) => rock.viscosity > 0.0,
            Event::Rock(RockEvent::Restart) => rock.viscosity * rock.standstill_speed > 0.0,
            _ => false,
        };
        if jumps && self.transversality() < GRAZE {
            return Some(Doubt::Graze);
        }
        let branch = self.gain - rock.standstill_penetration;
        let branches = self.event == Event::Rock(RockEvent::Return);
        (branches && branch.abs() <= parameters.resolutions()[0]).then_some(Doubt::Branch)
    }

    /// Derivative of the event's instant.
    fn instant(&self, line: &Line, change: &Change, model: &Model) -> f64 {
        let tip = line.tip(model);
        match self.event {
            Event::Contact => -line.gap(model)[0] / self.slope[0],
            Event::Relay(_) => {
                let from = self.turned_from();
                let stroke = if from == Some(Relay::Return) { change.stroke } else { 0.0 };
                -(line.relative(model)[0] + stroke) / self.relative[1]
            }
            // Of a drive that has no tangents.
            Event::Port { .. } | Event::Level(_) => line.instant,
            Event::Rock(event) => match event {
                RockEvent::Touch | RockEvent::LiftOff | RockEvent::StandstillLiftOff => {
                    -tip[0] / self.tip[1]
                }
                RockEvent::DissipativeTurn | RockEvent::Turn | RockEvent::Return => {
                    -tip[1] / self.tip[2]
                }
                RockEvent::Restart => -(tip[1] - change.rock.standstill_speed) / self.tip[2],
                RockEvent::Retreat => -(tip[1] + change.rock.standstill_speed) / self.tip[2],
                RockEvent::Barrier => {
                    // A barrier of no height is passed as soon as it is met.
                    let left = line.psi - change.rock.energy_barrier;
                    let power = self.viscosity * self.tip[1] * self.tip[1];
                    if left == 0.0 && power == 0.0 { line.instant } else { -left / power }
                }
            },
        }
    }

    /// Carries a line through the event.
    pub(crate) fn pass(&self, line: &mut Line, change: &Change, model: &Model) {
        let when = self.instant(line, change, model);
        let apart = when - line.instant;
        if apart.abs() > SAME * when.abs().max(line.instant.abs()) {
            line.reach = line.reach.min((self.spacing / apart).abs());
        }
        let tip = line.tip(model);
        // How far the event's place moves with its instant, `p' d tau`, without a quotient
        // where that cancels.
        let carried = match self.event {
            Event::Rock(RockEvent::Touch | RockEvent::LiftOff | RockEvent::StandstillLiftOff) => {
                -tip[0]
            }
            Event::Rock(RockEvent::DissipativeTurn | RockEvent::Turn | RockEvent::Return) => 0.0,
            _ if when.is_finite() => self.tip[1] * when,
            _ => 0.0,
        };
        match self.event {
            Event::Contact => self.note(line, change, model, when),
            Event::Relay(_) => {
                let jump = self.drive[1] - self.drive[0];
                line.v[0] -= jump / model.piston.mass.sqrt() * when;
            }
            Event::Port { .. } | Event::Level(_) => {}
            Event::Rock(event) => self.remember(event, line, change, model, carried),
        }
        line.instant = when;
    }

    fn remember(
        &self,
        event: RockEvent,
        line: &mut Line,
        change: &Change,
        model: &Model,
        carried: f64,
    ) {
        let rock = &model.parameters.rock;
        let after = self.entered.rock;
        let (gamma, grown) = (rock.unloading_ratio, change.rock.unloading_ratio);
        let place = line.tip(model)[0] + carried;
        let viscosity = Spring::of(after).coefficients(rock).viscosity;
        let jump = (viscosity - self.viscosity) * carried;
        if jump != 0.0 {
            let p = model.piston.len();
            line.v[p..].iter_mut().zip(&model.bit.bottom).for_each(|(v, x)| *v += jump * x);
        }
        let p = self.tip[0];
        match event {
            RockEvent::DissipativeTurn | RockEvent::Turn => {
                let unloaded = place * (1.0 - 1.0 / gamma) + p * grown / (gamma * gamma);
                line.gain = unloaded - line.unloaded;
                line.unloaded = unloaded;
                line.shift(model, unloaded);
            }
            RockEvent::Return | RockEvent::Restart if after == RockMode::DissipativeForward => {
                line.shift(model, place * (1.0 - gamma) - p * grown);
            }
            _ => {}
        }
        if after == RockMode::DissipativeForward {
            line.psi = -viscosity * self.tip[1] * carried;
        }
    }

    /// What the story of the blows takes from a closing or an opening.
    fn note(&self, line: &mut Line, change: &Change, model: &Model, when: f64) {
        let [piston, _] = line.means(model);
        if self.mode.closed {
            line.blow.contact_duration = when - line.collision;
            if let Some(strike) = line.strikes.last_mut() {
                strike.rebound = -(piston[1] + self.piston[2] * when);
            }
            return;
        }
        if self.collides {
            line.collision = when;
        }
        if !self.strikes {
            return;
        }
        let here = Mark { time: when, hole: line.origin + line.unloaded };
        let speed = line.relative(model)[1] + self.relative[2] * when;
        let (blow, told) = (&mut line.blow, &self.blow);
        blow.time = when;
        blow.speed = speed;
        blow.energy = model.piston.mass * told.speed * speed
            + 0.5 * change.masses[0] * told.speed * told.speed;
        if let Some(last) = line.blows[1] {
            (blow.penetration, blow.period) = (here.hole - last.hole, here.time - last.time);
            blow.rop = (blow.penetration - told.rop * blow.period) / told.period;
        }
        if let Some(first) = line.blows[0]
            && self.drilled > 0.0
        {
            let (depth, span) = (here.hole - first.hole, here.time - first.time);
            blow.rop_mean = (depth - told.rop_mean * span) / self.drilled;
        }
        line.blows[0].get_or_insert(here);
        line.blows[1] = Some(here);
        let (time, energy) = (when, blow.energy);
        line.strikes.push(Strike { time, speed, energy, rebound: 0.0 });
    }
}
