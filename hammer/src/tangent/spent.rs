//! The derivative of the ledger: works, losses, what is stored, impulses.
//!
//! Along a stretch the work of a load follows from where it acts at both ends, the
//! rock's loss from where the tip is, and the dashpot's work is `viscous`'s. Impulses of the
//! contact and of the rock follow from the bodies' momenta:
//!
//! ```text
//! J_C = int F_A + Mp G dt - [Mp vp],    J_R = int feed + Mb G dt + J_C - [Mb vb]
//! ```
//!
//! and the bars' damping is what the balance leaves, for that holds exactly. Where a power `P`
//! jumps at an event, a sum at a fixed time takes `(P- - P+) d tau`. Of the work of a load that
//! varies along a stretch `varying` tells.

use crate::laws::event::{Event, RockEvent};
use crate::laws::mode::{Mode, RockMode};
use crate::laws::rock::Spring;
use crate::machine::Machine;
use crate::machine::ledger::{Energies, Impulses};
use crate::modal::model::{Channel, Model};
use crate::modal::system::CHANNELS;
use crate::numerics::kernel::inner_product;
use crate::numerics::poly::Poly;
use crate::quantities::parameters::Rock;
use crate::tangent::change::Change;
use crate::tangent::leg::{Leg, Moment, Place};
use crate::tangent::line::Line;
use crate::tangent::varying::Works;

const VISCOUS: RockMode = RockMode::DissipativeForward;

/// Where a line is, and the hammer with it.
pub(crate) struct Here<'a> {
    pub model: &'a Model,
    pub mode: Mode,
    /// `[q | q']` of all modes.
    pub body_state: &'a [f64],
    pub tip: f64,
    pub gap: f64,
}

/// The work of a load on a displacement that goes from one place to another, by what both are and
/// their changes are at the ends; `moment` is zero for a load that does not vary (see `varying`).
fn work(
    [load, change]: [&Poly; 2],
    span: f64,
    [start, end]: [f64; 2],
    [starts, ends]: [f64; 2],
    moment: f64,
) -> f64 {
    if load.is_constant() && change.is_constant() {
        return load.0[0] * (ends - starts) + change.0[0] * (end - start);
    }
    let grown = |g: &Poly, start: f64, end: f64| g.at(span) * end - g.0[0] * start;
    grown(change, start, end) + grown(load, starts, ends) - moment
}

/// `1 - 1/gamma` and its derivative.
fn lost_part(rock: &Rock, change: &Change) -> [f64; 2] {
    let gamma = rock.unloading_ratio;
    [rock.lost_part(), change.rock.unloading_ratio / (gamma * gamma)]
}

impl Leg {
    /// Adds what a line, which was at `from`, has spent along the leg; `changes` are those of
    /// the loads, `works` what their variation adds.
    pub(crate) fn spend(
        &self,
        line: &mut Line,
        from: &Place,
        change: &Change,
        (changes, works): (&[Poly; CHANNELS], &Works),
        model: &Model,
    ) {
        let to = line.place(model);
        let Some([start, end]) = &self.ends else { return };
        let along = |of: fn(&Place) -> f64| ([of(start), of(end)], [of(from), of(&to)]);
        let (piston, bit) = (along(|p| p.piston), along(|p| p.bit));
        let top = along(|p| p.top);
        let [mp, mb] = [model.piston.mass, model.bit.mass];
        let load = |channel: Channel| [&self.loads[channel as usize], &changes[channel as usize]];
        let [drive, feed, fall] = [Channel::Drive, Channel::Feed, Channel::Gravity].map(load);
        let spent = &mut line.spent;
        let [driven, fed] = works.0;
        spent.work[Channel::Drive as usize] += work(drive, self.span, piston.0, piston.1, driven);
        spent.work[Channel::Feed as usize] += work(feed, self.span, top.0, top.1, fed);
        for (body, (mass, mean)) in [(mp, piston), (mb, bit)].into_iter().enumerate() {
            let heavier = change.masses[body] * fall[0].0[0];
            spent.work[Channel::Gravity as usize] += mass
                * work(fall, self.span, mean.0, mean.1, 0.0)
                + heavier * (mean.0[1] - mean.0[0]);
            let push = if body == 0 { drive[1] } else { feed[1] };
            let weight = heavier + mass * fall[1].0[0];
            spent.push[body] += push.integral(self.span) + weight * self.span;
        }
        if let Spring::Loading | Spring::Viscous = Spring::of(self.mode.rock) {
            let rock = &model.parameters.rock;
            let [part, parted] = lost_part(rock, change);
            let squares = (end.tip - start.tip) * (end.tip + start.tip);
            spent.rock += part * rock.stiffness * (end.tip * to.tip - start.tip * from.tip)
                + 0.5 * (parted * rock.stiffness + part * change.rock.stiffness) * squares;
        }
    }
}

impl Line {
    /// Works and losses of a cycle that ends in a mode, where they go on at these powers; its
    /// period changes by `period`.
    pub(crate) fn spent_over(&self, end: Mode, powers: &Energies, period: f64) -> Energies {
        let spent = &self.spent;
        let work = |channel: Channel, power: f64| spent.work[channel as usize] + power * period;
        let psi = if end.rock == VISCOUS { self.psi } else { 0.0 };
        let (drive, gravity) =
            (work(Channel::Drive, powers.drive), work(Channel::Gravity, powers.gravity));
        let feed = work(Channel::Feed, powers.feed);
        let rock_dissipated = spent.rock + powers.rock_dissipated * period;
        let viscous = spent.viscous + psi + powers.viscous * period;
        let damping = drive + gravity + feed - rock_dissipated - viscous;
        Energies { drive, gravity, feed, rock_dissipated, viscous, damping, ..Default::default() }
    }
}

impl Moment {
    /// True if the dashpot's work of a drilling cycle is complete here.
    pub(crate) fn leaves_viscous(&self) -> bool {
        self.mode.rock == VISCOUS && self.entered.rock != VISCOUS
    }

    /// Adds what jumps here; `psi` is the line's from before the event.
    pub(crate) fn spend(&self, line: &mut Line, psi: f64, model: &Model) {
        let when = line.instant;
        let rock = &model.parameters.rock;
        let jump = (self.drive[0] - self.drive[1]) * when;
        line.spent.push[0] += jump;
        line.spent.work[Channel::Drive as usize] += jump * self.piston[1];
        let [p, v, _] = self.tip;
        if let Event::Rock(event) = self.event {
            // The line that is entered has its own origin.
            let starts = matches!(event, RockEvent::Return | RockEvent::Restart);
            let stretched = if starts { rock.unloading_ratio } else { 1.0 };
            let before = Spring::of(self.mode.rock).lost_power(rock, p, v);
            let after = Spring::of(self.entered.rock).lost_power(rock, stretched * p, v);
            line.spent.rock += (before - after) * when;
        }
        if self.leaves_viscous() {
            line.spent.viscous += psi + self.viscosity * v * v * when;
        }
    }
}

impl<'a> Here<'a> {
    /// Where a machine is now; `body_state` has its modes.
    pub(crate) fn of(machine: &'a Machine, body_state: &'a [f64]) -> Self {
        let motion = machine.motion();
        let model = motion.model();
        let (q, p) = (&body_state[..body_state.len() / 2], model.piston.len());
        let upper = inner_product(&model.piston.bottom, &q[..p]);
        Self {
            model,
            mode: motion.mode(),
            body_state,
            tip: inner_product(&model.bit.bottom, &q[p..]),
            gap: inner_product(&model.bit.top, &q[p..]) - upper,
        }
    }

    /// Derivatives of kinetic, strain, contact and recoverable rock energy.
    pub(crate) fn stored(&self, line: &Line, change: &Change) -> [f64; 4] {
        let model = self.model;
        let (q, v) = self.body_state.split_at(line.q.len());
        let at = |x: &[f64], i: usize| x.get(i).copied().unwrap_or(0.0);
        let (mut kinetic, mut strain) = (0.0, 0.0);
        for (i, w2) in model.piston.omega2.iter().chain(&model.bit.omega2).enumerate() {
            // A line carries the motion of a mode's upper end over its amplitude there.
            let grown = at(&change.amplitude, i);
            kinetic += v[i] * (line.v[i] - grown * v[i]);
            strain += w2 * q[i] * (line.q[i] - grown * q[i]);
            strain += 0.5 * at(&change.stiffness, i) * q[i] * q[i];
        }
        if let Some(reshape) = &change.reshape {
            let range = model.range_of(reshape.body);
            kinetic += 0.5 * reshape.weighed(&v[range.clone()]);
            strain += 0.5 * reshape.strained(&q[range]);
        }
        let (tip, gap) = (line.tip(model)[0], line.gap(model)[0]);
        let [k, dk] = if self.mode.closed { [model.contact, change.contact] } else { [0.0; 2] };
        let contact = k * self.gap * gap + 0.5 * dk * self.gap * self.gap;
        let (rock, d, p) = (&model.parameters.rock, &change.rock, self.tip);
        let (gamma, half) = (rock.unloading_ratio, 0.5 * p * p);
        let stored = match Spring::of(self.mode.rock) {
            Spring::Free => 0.0,
            Spring::Loading | Spring::Viscous => {
                let stiffer = d.stiffness - rock.stiffness * d.unloading_ratio / gamma;
                (rock.stiffness * p * tip + stiffer * half) / gamma
            }
            Spring::Unloading => {
                let stiffer = gamma * d.stiffness + d.unloading_ratio * rock.stiffness;
                gamma * rock.stiffness * p * tip + stiffer * half
            }
        };
        [kinetic, strain, contact, stored]
    }

    /// Derivatives of the bodies' momenta.
    fn momenta(&self, line: &Line, change: &Change) -> [f64; 2] {
        let (model, means) = (self.model, line.means(self.model));
        let v = &self.body_state[line.q.len()..];
        let of = |body: usize, mass: f64, first: usize| {
            mass * means[body][1] + change.masses[body] * v[first] / mass.sqrt()
        };
        [of(0, model.piston.mass, 0), of(1, model.bit.mass, model.piston.len())]
    }

    /// The sums begin here.
    pub(crate) fn begin(&self, line: &mut Line, change: &Change) {
        line.spent = Default::default();
        line.spent.stored = self.stored(line, change).iter().sum();
        line.spent.momenta = self.momenta(line, change);
        if self.mode.rock == VISCOUS {
            line.spent.viscous = -line.psi;
        }
    }

    /// Derivatives of the ledger; `psi` is that of the present drilling cycle's dashpot.
    pub(crate) fn ledger(&self, line: &Line, change: &Change, psi: f64) -> (Energies, Impulses) {
        let spent = &line.spent;
        let [kinetic, strain, contact, rock_stored] = self.stored(line, change);
        let held = kinetic + strain + contact + rock_stored - spent.stored;
        let viscous = spent.viscous + if self.mode.rock == VISCOUS { psi } else { 0.0 };
        let momenta = self.momenta(line, change);
        let gained = |body: usize| momenta[body] - spent.momenta[body];
        let struck = spent.push[0] - gained(0);
        let work = spent.work.iter().sum::<f64>() + spent.retuned;
        let energies = Energies {
            drive: spent.work[Channel::Drive as usize],
            gravity: spent.work[Channel::Gravity as usize],
            feed: spent.work[Channel::Feed as usize],
            kinetic,
            strain,
            contact,
            rock_stored,
            rock_dissipated: spent.rock,
            viscous,
            damping: work - held - spent.rock - viscous,
            retuned: spent.retuned,
            residual: 0.0,
        };
        (energies, Impulses { contact: struck, rock: spent.push[1] + struck - gained(1) })
    }
}
