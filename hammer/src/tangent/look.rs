//! Derivatives of what a scene shows.

use crate::laws::rock::{Coefficients, Spring};
use crate::machine::Machine;
use crate::machine::blows::Blow;
use crate::machine::ledger::{Energies, Impulses};
use crate::machine::outputs::Kinematics;
use crate::machine::peaks::Peaks;
use crate::modal::model::Channel;
use crate::numerics::kernel::inner_product;
use crate::quantities::sections::Body;
use crate::tangent::follow::Tangents;
use crate::tangent::line::Line;
use crate::tangent::spent::Here;
use crate::tangent::summit::Summit;

/// Derivatives by one parameter, at a fixed time, of what [`Kinematics`] tells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "each is the derivative of the field of that name")]
pub struct Motions {
    pub piston_position: f64,
    pub piston_velocity: f64,
    pub piston_acceleration: f64,
    pub bit_position: f64,
    pub bit_velocity: f64,
    pub bit_acceleration: f64,
    pub bit_tip_position: f64,
    pub bit_tip_velocity: f64,
    pub bit_tip_acceleration: f64,
    pub relative_position: f64,
    pub relative_velocity: f64,
    pub relative_acceleration: f64,
    pub contact_gap: f64,
    pub contact_gap_rate: f64,
    pub contact_force: f64,
    pub contact_force_rate: f64,
    pub rock_force: f64,
    pub rock_force_rate: f64,
    pub applied_drive_force: f64,
    pub hole_depth: f64,
}

/// Derivatives of outputs by one parameter, at a fixed time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivative {
    /// Of motion and forces now.
    pub kinematics: Motions,
    /// Of the last blow, and of what drilling has come to.
    pub blow: Blow,
    /// Of the instant of the last event, s.
    pub event_time: f64,
    /// Of energies and impulses, where [`Tangents::with_ledger`] carries them.
    pub ledger: Option<(Energies, Impulses)>,
    /// Of the largest forces of the last step, where [`Tangents::with_peaks`] carries them.
    pub peaks: Option<Peaks>,
}

impl Tangents {
    /// The derivatives now, one for each seed.
    pub fn look(&mut self, machine: &Machine) -> Vec<Derivative> {
        let now = *machine.kinematics();
        let body_state = machine.motion().whole_state();
        self.at_present(machine, |here| {
            let at = Here::of(machine, &body_state);
            let pending = here.ledger.then(|| here.pending(at.model));
            let derivative = |index: usize| {
                let (line, change) = (&here.lines[index], &here.changes[index]);
                let ledger = |more: &Vec<f64>| at.ledger(line, change, line.psi + more[index]);
                Derivative {
                    kinematics: here.kinematics(index, machine, &now, &body_state),
                    blow: line.blow,
                    event_time: line.instant,
                    ledger: pending.as_ref().map(ledger),
                    peaks: here.peaks(index),
                }
            };
            (0..here.lines.len()).map(derivative).collect()
        })
    }

    /// Of the largest forces since the step began.
    pub(crate) fn peaks(&self, index: usize) -> Option<Peaks> {
        let [contact, rock] = self.summits.as_ref()?;
        let of = |summit: &Summit| summit.slopes.get(index).copied().unwrap_or_default();
        Some(Peaks { contact_force: of(contact), rock_force: of(rock) })
    }

    /// `body_state` has the state `[q | q']` of all modes now.
    fn kinematics(
        &self,
        index: usize,
        machine: &Machine,
        now: &Kinematics,
        body_state: &[f64],
    ) -> Motions {
        let (line, change) = (&self.lines[index], &self.changes[index]);
        let (state, model) = (machine.motion().state(), machine.motion().model());
        let t = state.now;
        let mut inputs = state.inputs;
        inputs.shift(t);
        let loads = change.loads(&model.parameters, &inputs, state.mode.relay);
        let [drive, feed, fall] = loads.map(|p| p.at(0.0));
        let [piston, bit] = line.means(model);
        let (tip, gap) = (line.tip(model), line.gap(model));
        let spring = Spring::of(state.mode.rock);
        let Coefficients { stiffness: k, viscosity: c } =
            spring.coefficients(&model.parameters.rock);
        let [dk, dc] = change.springs[spring as usize];
        let p = now.bit_tip_position - state.origin.value();
        let closed = state.mode.closed;
        let (stiffness, stiffer) =
            if closed { (model.contact, change.contact) } else { (0.0, 0.0) };
        let force = -stiffness * gap[0] - stiffer * now.contact_gap;
        let rock = k * tip[0] + c * tip[1] + dk * p + dc * now.bit_tip_velocity;
        let [mp, mb] = [model.piston.mass, model.bit.mass];
        let own = |acceleration: f64, mass: f64, body: usize| {
            (acceleration - model.parameters.gravity) * change.masses[body] / mass
        };
        let upper = fall + (drive - force) / mp - own(now.piston_acceleration, mp, 0);
        let lower = fall + (feed + force - rock) / mb - own(now.bit_acceleration, mb, 1);
        let tip_acceleration =
            self.tip_acceleration(index, machine, body_state, [force, rock, feed, fall]);
        Motions {
            piston_position: line.origin + piston[0] + change.gap,
            piston_velocity: piston[1],
            piston_acceleration: upper,
            bit_position: line.origin + bit[0],
            bit_velocity: bit[1],
            bit_acceleration: lower,
            bit_tip_position: line.origin + tip[0],
            bit_tip_velocity: tip[1],
            bit_tip_acceleration: tip_acceleration,
            relative_position: piston[0] - bit[0],
            relative_velocity: piston[1] - bit[1],
            relative_acceleration: upper - lower,
            contact_gap: gap[0],
            contact_gap_rate: gap[1],
            contact_force: force,
            contact_force_rate: -stiffness * gap[1] - stiffer * now.contact_gap_rate,
            rock_force: rock,
            rock_force_rate: k * tip[1]
                + c * tip_acceleration
                + dk * now.bit_tip_velocity
                + dc * now.bit_tip_acceleration,
            applied_drive_force: drive,
            hole_depth: line.origin + line.unloaded,
        }
    }

    /// Tangent of `p''`: the bit's modes under the changed forces `[F_C, F_R, feed, G]`.
    fn tip_acceleration(
        &self,
        index: usize,
        machine: &Machine,
        body_state: &[f64],
        forces: [f64; 4],
    ) -> f64 {
        let (line, change): (&Line, _) = (&self.lines[index], &self.changes[index]);
        let (state, model) = (machine.motion().state(), machine.motion().model());
        let (p, modes) = (model.piston.len(), line.q.len());
        let bit = &model.bit;
        let beta = model.parameters.material.damping_time;
        let (q, v) = body_state.split_at(modes);
        let tip = [inner_product(&bit.bottom, &q[p..]), inner_product(&bit.bottom, &v[p..])];
        let gap = inner_product(&bit.top, &q[p..]) - inner_product(&model.piston.bottom, &q[..p]);
        let contact = if state.mode.closed { -model.contact * gap } else { 0.0 };
        let rock = machine.motion().tip_line().force(tip[0], tip[1]);
        let feed = state.loads[Channel::Feed as usize].at(state.now);
        let [dcontact, drock, dfeed, dfall] = forces;
        let mut sum = 0.0;
        for (i, w2) in bit.omega2.iter().enumerate() {
            let at = |x: &[f64]| x.get(p + i).copied().unwrap_or(0.0);
            let grown = 2.0 * at(&change.amplitude);
            let upper = bit.top[i] * (dfeed + dcontact + grown * (feed + contact));
            let lower = bit.bottom[i] * (drock + grown * rock);
            let weight = if i == 0 { bit.mass.sqrt() * dfall } else { 0.0 };
            let stiff = w2 * line.q[p + i] + at(&change.stiffness) * q[p + i];
            let damped = beta * w2 * line.v[p + i] + at(&change.damping) * v[p + i];
            sum += bit.bottom[i] * (upper - lower + weight - stiff - damped);
        }
        let Some(reshape) = change.reshape.as_ref().filter(|r| r.body == Body::Bit) else {
            return sum;
        };
        let bent: Vec<f64> = q[p..].iter().zip(&v[p..]).map(|(q, v)| q + beta * v).collect();
        let push = |i: usize| bit.top[i] * (feed + contact) - bit.bottom[i] * rock;
        let pushed: Vec<f64> = (0..bit.len()).map(|i| push(i) - bit.omega2[i] * bent[i]).collect();
        let mut changes = vec![0.0; bit.len()];
        reshape.accelerations(&pushed, &bent, &mut changes);
        sum + inner_product(&bit.bottom, &changes)
    }
}
