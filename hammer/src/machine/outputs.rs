//! Motion and forces at the present instant.

use crate::bodies::bar::Bar;
use crate::laws::event::Displacement;
use crate::laws::rock::Coefficients;
use crate::modal::model::Channel;
use crate::motion::{Motion, PointMotion};
use crate::quantities::parameters::Material;

/// Motion and forces at one instant. SI units, positive downward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Mass-weighted mean displacement of the piston, m.
    pub piston_position: f64,
    /// Its rate, m/s.
    pub piston_velocity: f64,
    /// Its second rate, m/s2.
    pub piston_acceleration: f64,
    /// Its third rate, m/s3.
    pub piston_jerk: f64,
    /// Mass-weighted mean displacement of the bit, m.
    pub bit_position: f64,
    /// Its rate, m/s.
    pub bit_velocity: f64,
    /// Its second rate, m/s2.
    pub bit_acceleration: f64,
    /// Its third rate, m/s3.
    pub bit_jerk: f64,
    /// Displacement of the bit/rock interface `w1.u`, m.
    pub bit_tip_position: f64,
    /// Its rate, m/s.
    pub bit_tip_velocity: f64,
    /// Its second rate, m/s2.
    pub bit_tip_acceleration: f64,
    /// `vr = up_mean - ub_mean - g0`, m; with a casing, less the casing's displacement instead,
    /// and with loose joints, less the shank's.
    pub relative_position: f64,
    /// Its rate, m/s.
    pub relative_velocity: f64,
    /// Its second rate, m/s2.
    pub relative_acceleration: f64,
    /// Its third rate, m/s3.
    pub relative_jerk: f64,
    /// Gap `g`, m.
    pub contact_gap: f64,
    /// Its rate, m/s.
    pub contact_gap_rate: f64,
    /// Its second rate, m/s2.
    pub contact_gap_acceleration: f64,
    /// `F_C`, N.
    pub contact_force: f64,
    /// Its rate, N/s.
    pub contact_force_rate: f64,
    /// Its second rate, N/s2.
    pub contact_force_acceleration: f64,
    /// `F_R`, N.
    pub rock_force: f64,
    /// Its rate, N/s.
    pub rock_force_rate: f64,
    /// `F_A`, N.
    pub applied_drive_force: f64,
    /// Its first two rates, N/s and N/s2.
    pub applied_drive_force_rates: [f64; 2],
    /// `uu` at the last unloading, m.
    pub hole_depth: f64,
    /// Displacement of the casing, m (0 without one).
    pub casing_position: f64,
    /// Its rate, m/s.
    pub casing_velocity: f64,
    /// Its second rate, m/s2.
    pub casing_acceleration: f64,
    /// Force of the chuck on the casing, N; positive where the shoulder presses on the bit.
    pub chuck_force: f64,
    /// Its rate, N/s.
    pub chuck_force_rate: f64,
}

/// Motion and stress along the bodies, top to bottom. Nodes are the ends of the mesh's spans
/// ([`crate::Sections::nodes`]) whatever its degree, stresses those at their middles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Displacement (m) and velocity (m/s) of the piston's nodes; a rigid body has one.
    pub piston: Vec<[f64; 2]>,
    /// Displacement (m) and velocity (m/s) of the bit's nodes; at a loose joint, of the lower rod's.
    pub bit: Vec<[f64; 2]>,
    /// Axial stress `E (u' + beta v')` in the piston's spans, tension positive, Pa; times the
    /// section's area it is the axial force. Empty for a rigid body.
    pub piston_stress: Vec<f64>,
    /// Axial stress in the bit's spans, tension positive, Pa.
    pub bit_stress: Vec<f64>,
    /// Displacement (m) and velocity (m/s) of the casing's nodes; empty without one.
    pub casing: Vec<[f64; 2]>,
    /// Axial stress in an elastic casing's spans, tension positive, Pa.
    pub casing_stress: Vec<f64>,
}

impl Kinematics {
    /// At the present instant.
    pub(crate) fn of(motion: &Motion) -> Self {
        let (state, model) = (motion.state(), motion.model());
        let (t, tracks) = (state.now, motion.present());
        let point = |displacement| motion.point(&tracks, displacement, t);
        let (tip, bit) = (point(Displacement::Tip), point(Displacement::BitMean));
        let (gap, piston) = (point(Displacement::Gap), point(Displacement::PistonMean));
        let (contact, line) = (motion.contact(), motion.tip_line());
        let origin = state.origin.value();
        let force = contact.force(gap.displacement);
        let rock = line.force(tip.displacement, tip.velocity);
        let [drive, feed, fall, anvil] = state.loads.map(|load| load.at(t));
        // The mean accelerations follow from the forces on each body.
        let rates = state.loads.map(|load| load.derivative());
        let [drive_rate, feed_rate, _, anvil_rate] = rates.map(|rate| rate.at(state.now));
        let force_rate = contact.force(gap.velocity);
        let rock_rate = line.force(tip.velocity, tip.acceleration);
        let casing = match &model.casing {
            Some(body) => {
                let places = [Displacement::Chuck, Displacement::Casing, Displacement::CasingTop];
                let pushed =
                    [feed - drive - anvil + body.mass * fall, feed_rate - drive_rate - anvil_rate];
                Cased::of(motion, body.mass, pushed, places.map(point))
            }
            None => Cased::default(),
        };
        let cased = model.casing.is_some();
        let [tied, tied_rate] = if cased { casing.force } else { [feed, feed_rate] };
        let [pressed, pressed_rate] = [tied + anvil, tied_rate + anvil_rate];
        let (piston_acceleration, bit_acceleration) = (
            fall + (drive - force) / model.piston.mass,
            fall + (pressed + force - rock) / model.string_mass(),
        );
        let (piston_jerk, bit_jerk) = (
            (drive_rate - force_rate) / model.piston.mass,
            (pressed_rate + force_rate - rock_rate) / model.string_mass(),
        );
        let beside = if cased {
            casing.motion
        } else if model.chain.joints > 0 {
            // The body that the piston strikes: what acts on it is the joint below.
            let [vr, below] = [Displacement::Relative, Displacement::Joint(0)].map(point);
            let tie = motion.ties().find(|(x, _)| *x == Displacement::Joint(0));
            let tie = tie.map_or_else(Coefficients::default, |(_, tie)| tie);
            let (held, mass) =
                (tie.force(below.displacement, below.velocity), model.string[0].mass);
            let held_rate = tie.force(below.velocity, below.acceleration);
            [
                piston.displacement - vr.displacement,
                piston.velocity - vr.velocity,
                fall + (pressed + force + held) / mass,
                (pressed_rate + force_rate + held_rate) / mass,
            ]
        } else {
            [bit.displacement, bit.velocity, bit_acceleration, bit_jerk]
        };
        let [lift, bit_lift] =
            [Displacement::PistonMean, Displacement::BitMean].map(|x| motion.ahead(x));
        Self {
            piston_position: origin
                + piston.displacement
                + model.parameters.contact.initial_gap
                + lift,
            piston_velocity: piston.velocity,
            piston_acceleration,
            piston_jerk,
            bit_position: origin + bit.displacement + bit_lift,
            bit_velocity: bit.velocity,
            bit_acceleration,
            bit_jerk,
            bit_tip_position: origin + tip.displacement,
            bit_tip_velocity: tip.velocity,
            bit_tip_acceleration: tip.acceleration,
            relative_position: piston.displacement - beside[0],
            relative_velocity: piston.velocity - beside[1],
            relative_acceleration: piston_acceleration - beside[2],
            relative_jerk: piston_jerk - beside[3],
            contact_gap: gap.displacement,
            contact_gap_rate: gap.velocity,
            contact_gap_acceleration: gap.acceleration,
            contact_force: force,
            contact_force_rate: force_rate,
            contact_force_acceleration: contact.force(gap.acceleration),
            rock_force: rock,
            rock_force_rate: rock_rate,
            applied_drive_force: drive,
            applied_drive_force_rates: [
                drive_rate,
                rates[Channel::Drive as usize].derivative().at(state.now),
            ],
            hole_depth: motion.milestone().hole.value(),
            casing_position: casing.place,
            casing_velocity: casing.motion[1],
            casing_acceleration: casing.motion[2],
            chuck_force: casing.force[0],
            chuck_force_rate: casing.force[1],
        }
    }
}

/// A casing at the present instant.
#[derive(Clone, Copy, Debug, Default)]
struct Cased {
    /// Displacement from the start, m.
    place: f64,
    /// Mean displacement from the origin, m, and its rates.
    motion: [f64; 4],
    /// The chuck's force on it, N, and its rate.
    force: [f64; 2],
}

impl Cased {
    /// Of this mass, under loads (N, N/s): its chuck, its mean and its upper end.
    fn of(
        motion: &Motion,
        mass: f64,
        pushed: [f64; 2],
        [chuck, casing, top]: [PointMotion; 3],
    ) -> Self {
        let (state, laws) = (motion.state(), motion.parameters());
        let tie = laws.chuck.line(state.mode.chuck);
        let force = -tie.force(chuck.displacement, chuck.velocity);
        let force_rate = -tie.force(chuck.velocity, chuck.acceleration);
        let string = laws.casing.impedance;
        let acceleration = (pushed[0] - force - string * top.velocity) / mass;
        let jerk = (pushed[1] - force_rate - string * top.acceleration) / mass;
        let at = casing.displacement - laws.chuck.offset(state.mode.chuck);
        Self {
            place: state.origin.value() + at,
            motion: [at, casing.velocity, acceleration, jerk],
            force: [force, force_rate],
        }
    }
}

impl Profile {
    /// At the present instant.
    pub(crate) fn of(motion: &Motion) -> Self {
        let (state, model) = (motion.state(), motion.model());
        let whole = motion.whole_state();
        let (q, v) = whole.split_at(model.modes());
        let Material { youngs_modulus: e, damping_time: beta, .. } = model.parameters.material;
        let mut first = 0;
        let mut along = |bar: &Bar, shift: f64| {
            let own = first..first + bar.len();
            first = own.end;
            let (q, v, shift) = (&q[own.clone()], &v[own], state.origin.value() + shift);
            let nodes = bar.nodal(q, v).iter().map(|[u, v]| [shift + u, *v]).collect();
            let strains = bar.strains(q, v);
            let stress = strains.iter().map(|[strain, rate]| e * (strain + beta * rate));
            (nodes, stress.collect())
        };
        let gap = model.parameters.contact.initial_gap;
        let (piston, piston_stress) = along(&model.piston, gap - motion.lifted(0));
        let (mut bit, mut bit_stress) = (Vec::new(), Vec::new());
        for (body, bar) in model.string.iter().enumerate() {
            let (nodes, stress): (Vec<_>, Vec<_>) = along(bar, -motion.lifted(body));
            bit.pop(); // At a joint, what is below.
            bit.extend(nodes);
            bit_stress.extend(stress);
        }
        let offset = model.parameters.chuck.offset(state.mode.chuck);
        let casing = model.casing.as_ref().map(|bar| along(bar, -offset));
        let (casing, casing_stress) = casing.unwrap_or_default();
        Self { piston, bit, piston_stress, bit_stress, casing, casing_stress }
    }
}
