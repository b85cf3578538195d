//! What a scene shows of itself.

use serde::{Deserialize, Serialize};

/// Motion and forces at one instant. SI units, positive downward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Mass-weighted mean displacement of the piston, m.
    pub piston_position: f64,
    /// Its rate, m/s.
    pub piston_velocity: f64,
    /// Its second rate, m/s2.
    pub piston_acceleration: f64,
    /// Mass-weighted mean displacement of the bit, m.
    pub bit_position: f64,
    /// Its rate, m/s.
    pub bit_velocity: f64,
    /// Its second rate, m/s2.
    pub bit_acceleration: f64,
    /// Displacement of the bit/rock interface `w1.u`, m.
    pub bit_tip_position: f64,
    /// Its rate, m/s.
    pub bit_tip_velocity: f64,
    /// Its second rate, m/s2.
    pub bit_tip_acceleration: f64,
    /// `vr = up_mean - ub_mean - g0`, m.
    pub relative_position: f64,
    /// Its rate, m/s.
    pub relative_velocity: f64,
    /// Its second rate, m/s2.
    pub relative_acceleration: f64,
    /// Gap `g`, m.
    pub contact_gap: f64,
    /// Its rate, m/s.
    pub contact_gap_rate: f64,
    /// `F_C`, N.
    pub contact_force: f64,
    /// Its rate, N/s.
    pub contact_force_rate: f64,
    /// `F_R`, N.
    pub rock_force: f64,
    /// Its rate, N/s.
    pub rock_force_rate: f64,
    /// `F_A`, N.
    pub applied_drive_force: f64,
    /// `uu` at the last unloading, m.
    pub hole_depth: f64,
}

/// What has been counted and summed since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Collisions (closings within `2 (T1 + T2)` of the last opening belong to one).
    pub contacts: u64,
    /// Collisions at whose start the piston moves downward.
    pub blows: u64,
    /// Drilling cycles begun (entries into DFC).
    pub rock_cycles: u64,
    /// Mode transitions.
    pub events: u64,
    /// Excursions of a guard that touched its resolution without a decision.
    pub undecided: u64,
    /// Changes of basis (work done by the integrator).
    pub basis_changes: u64,
    /// Evaluations of a guard.
    pub guard_evaluations: u64,
    /// Rotations of the modal state.
    pub samples: u64,
    /// Taylor windows opened by the search.
    pub windows: u64,
}

/// The last blow, and what drilling has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blow {
    /// Instant of impact, s.
    pub time: f64,
    /// Relative mean speed at impact, m/s.
    pub speed: f64,
    /// `Mp speed^2 / 2`, J.
    pub energy: f64,
    /// Time since the blow before, s (0 before the second blow).
    pub period: f64,
    /// Hole advance over the last complete blow period, m.
    pub penetration: f64,
    /// `penetration / period`, m/s.
    pub rop: f64,
    /// Hole advance per time from the first blow to the last, m/s.
    pub rop_mean: f64,
    /// Duration of the last complete collision (first closing to last opening), s.
    pub contact_duration: f64,
}

/// The energy ledger, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Work of `F_A`.
    pub drive: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Work of the feed force.
    pub feed: f64,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Strain energy of the bars.
    pub strain: f64,
    /// Energy of the contact penalty.
    pub contact: f64,
    /// Recoverable energy of the rock.
    pub rock_stored: f64,
    /// `(1 - 1/gamma) KR (p - ul) p'` integrated over DFC and FC.
    pub rock_dissipated: f64,
    /// Sum of `psi`.
    pub viscous: f64,
    /// `beta v.K v` integrated.
    pub damping: f64,
    /// Energy put in by a change of a tunable parameter.
    pub retuned: f64,
    /// Works less all the rest, from the energies at the start.
    pub residual: f64,
}

/// Largest forces over the last communication step, N.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peaks {
    /// Of `F_C`.
    pub contact_force: f64,
    /// Of `F_R`.
    pub rock_force: f64,
}

/// Impulses since the start, N s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulses {
    /// Of `F_C`.
    pub contact: f64,
    /// Of `F_R`.
    pub rock: f64,
}

/// What was asked for of the present instant, kept until that passes.
#[derive(Debug, Default)]
pub(crate) struct Views {
    pub kinematics: Option<Kinematics>,
    pub ledger: Option<(Energies, Impulses)>,
    pub peaks: Option<Peaks>,
}

/// A transition, as the journal keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// When, s.
    pub time: f64,
    /// What `time` lacks of the instant, s.
    pub time_rest: f64,
    /// Name of the event function, `Q1` to `Q11`; `lift` from standstill.
    pub event: &'static str,
    /// The mode entered.
    pub mode: crate::physics::mode::Mode,
}

/// Nodal displacements and velocities, top to bottom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Of the piston's nodes: m, m/s.
    pub piston: Vec<[f64; 2]>,
    /// Of the bit's nodes: m, m/s.
    pub bit: Vec<[f64; 2]>,
}
