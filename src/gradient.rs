//! Derivatives: of outputs, and of the stationary cycle.
//!
//! `fmi2GetDirectionalDerivative` answers
//!
//! * outputs by inputs: what a constant added to an input over the last communication step
//!   does at its end (before the first step: at the start);
//! * outputs by real parameters, and by [`OFFSETS`], a constant added to an input since the
//!   start. These are carried along from the start, for who asked by the end of
//!   initialization mode;
//! * the stationary cycle ([`CYCLE`]) of the present parameters and inputs, by both.
//!
//! Value references beyond the table's, announced in `VendorAnnotations`.
//!
//! Also compiled into `build.rs`.

use hammer::Input;
use hammer::periodic::{Cycle, Gradient};
use hammer::tangent::{Derivative, Seed};

/// Value reference of the offset of the first input; the others follow in their order.
pub const OFFSETS: u32 = 9000;
/// Value reference of the number of places where derivatives since the start are one-sided or
/// undefined.
pub const CAUTIONS: u32 = 9100;
/// Value reference of how far a parameter may change before events change their order: as a
/// directional derivative by it.
pub const REACH: u32 = 9101;
/// Value reference of the first number of the stationary cycle.
pub const CYCLE: u32 = 10_000;
/// Value reference of the first setting of its search.
pub const SEARCH: u32 = 10_500;

/// A derivative since the start, or over the last step.
pub type Pick = fn(&Derivative) -> f64;

/// Outputs that have derivatives; the counters' are zero.
#[rustfmt::skip]
pub const PICKS: [(&str, Pick); 28] = [
    ("piston_position", |d| d.kinematics.piston_position),
    ("piston_velocity", |d| d.kinematics.piston_velocity),
    ("bit_position", |d| d.kinematics.bit_position),
    ("bit_velocity", |d| d.kinematics.bit_velocity),
    ("bit_tip_position", |d| d.kinematics.bit_tip_position),
    ("bit_tip_velocity", |d| d.kinematics.bit_tip_velocity),
    ("relative_position", |d| d.kinematics.relative_position),
    ("relative_velocity", |d| d.kinematics.relative_velocity),
    ("contact_gap", |d| d.kinematics.contact_gap),
    ("contact_force", |d| d.kinematics.contact_force),
    ("rock_force", |d| d.kinematics.rock_force),
    ("applied_drive_force", |d| d.kinematics.applied_drive_force),
    ("hole_depth", |d| d.kinematics.hole_depth),
    ("blow_time", |d| d.blow.time),
    ("blow_speed", |d| d.blow.speed),
    ("blow_energy", |d| d.blow.energy),
    ("blow_period", |d| d.blow.period),
    ("blow_penetration", |d| d.blow.penetration),
    ("contact_duration", |d| d.blow.contact_duration),
    ("rop", |d| d.blow.rop),
    ("rop_mean", |d| d.blow.rop_mean),
    ("contact_count", |_| 0.0),
    ("blow_count", |_| 0.0),
    ("rock_cycle_count", |_| 0.0),
    ("event_count", |_| 0.0),
    ("undecided_count", |_| 0.0),
    ("contact_closed", |_| 0.0),
    ("stalled", |_| 0.0),
];

/// Of the ledger, if that is carried.
macro_rules! energy {
    ($field:ident) => {
        |d: &Derivative| d.ledger.map_or(f64::NAN, |(energies, _)| energies.$field)
    };
}

/// Outputs whose derivatives are carried only where these are asked for too: the ledger's, and
/// the largest forces of the last step.
#[rustfmt::skip]
pub const ON_DEMAND: [(&str, Demand, Pick); 15] = [
    ("contact_impulse", Demand::Ledger, |d| d.ledger.map_or(f64::NAN, |(_, i)| i.contact)),
    ("rock_impulse", Demand::Ledger, |d| d.ledger.map_or(f64::NAN, |(_, i)| i.rock)),
    ("energy_drive", Demand::Ledger, energy!(drive)),
    ("energy_gravity", Demand::Ledger, energy!(gravity)),
    ("energy_feed", Demand::Ledger, energy!(feed)),
    ("energy_kinetic", Demand::Ledger, energy!(kinetic)),
    ("energy_strain", Demand::Ledger, energy!(strain)),
    ("energy_contact", Demand::Ledger, energy!(contact)),
    ("energy_rock_stored", Demand::Ledger, energy!(rock_stored)),
    ("energy_rock_dissipated", Demand::Ledger, energy!(rock_dissipated)),
    ("energy_viscous", Demand::Ledger, energy!(viscous)),
    ("energy_damping", Demand::Ledger, energy!(damping)),
    ("energy_retuned", Demand::Ledger, energy!(retuned)),
    ("contact_force_peak", Demand::Peaks, |d| d.peaks.map_or(f64::NAN, |p| p.contact_force)),
    ("rock_force_peak", Demand::Peaks, |d| d.peaks.map_or(f64::NAN, |p| p.rock_force)),
];

/// What a derivative needs that is not carried unasked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// Works, losses and impulses.
    Ledger,
    /// Largest forces.
    Peaks,
}

/// Leading multipliers that are told.
const MULTIPLIERS: usize = 6;

/// A number of the cycle, and its derivative if it has one.
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: fn(&Cycle) -> f64,
    /// Its derivative.
    pub derivative: Option<fn(&Gradient) -> f64>,
}

const fn plain(name: &'static str, value: fn(&Cycle) -> f64) -> Feature {
    Feature { name, value, derivative: None }
}

const fn smooth(
    name: &'static str,
    value: fn(&Cycle) -> f64,
    derivative: fn(&Gradient) -> f64,
) -> Feature {
    Feature { name, value, derivative: Some(derivative) }
}

/// A number of the first blow, and its derivative.
type Strike = (fn(&Cycle) -> f64, fn(&Gradient) -> f64);

macro_rules! strike {
    ($field:ident) => {
        (
            |c: &Cycle| c.strikes.first().map_or(0.0, |s| s.$field),
            |g: &Gradient| g.strikes.first().map_or(0.0, |s| s.$field),
        )
    };
}

/// The numbers of a cycle, by value reference from [`CYCLE`] on.
#[rustfmt::skip]
pub const FEATURES: [Feature; 25] = {
    const PHASE: Strike = strike!(time);
    const SPEED: Strike = strike!(speed);
    const ENERGY: Strike = strike!(energy);
    const REBOUND: Strike = strike!(rebound);
    [
        smooth("period", |c| c.period, |g| g.period),
        smooth("advance", |c| c.advance, |g| g.advance),
        smooth("rop", |c| c.rop, |g| g.rop),
        smooth("blow_phase", PHASE.0, PHASE.1),
        smooth("blow_speed", SPEED.0, SPEED.1),
        smooth("blow_energy", ENERGY.0, ENERGY.1),
        smooth("rebound_speed", REBOUND.0, REBOUND.1),
        Feature { name: "reach", value: |_| f64::INFINITY, derivative: Some(|g| g.reach) },
        plain("blows", |c| c.strikes.len() as f64),
        plain("events", |c| c.events as f64),
        smooth("contact_force_peak", |c| c.peaks[0], |g| g.peaks[0]),
        smooth("rock_force_peak", |c| c.peaks[1], |g| g.peaks[1]),
        smooth("energy_drive", |c| c.energies.drive, |g| g.energies.drive),
        smooth("energy_gravity", |c| c.energies.gravity, |g| g.energies.gravity),
        smooth("energy_feed", |c| c.energies.feed, |g| g.energies.feed),
        smooth("energy_rock_dissipated", |c| c.energies.rock_dissipated, |g| g.energies.rock_dissipated),
        smooth("energy_viscous", |c| c.energies.viscous, |g| g.energies.viscous),
        smooth("energy_damping", |c| c.energies.damping, |g| g.energies.damping),
        plain("distance", |c| c.distance),
        plain("steps", |c| c.steps[0] as f64),
        plain("newton_steps", |c| c.steps[1] as f64),
        plain("cautions", |c| c.cautions.len() as f64),
        plain("multipliers", |c| c.multipliers.len().min(MULTIPLIERS) as f64),
        plain("fingerprint", |c| c.fingerprint()),
        plain("stable", |c| f64::from(u8::from(c.is_stable()))),
    ]
};

/// Value references of the multipliers, real and imaginary part in turn.
pub const MULTIPLIERS_FROM: u32 = CYCLE + 100;

/// A place among the numbers of the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// One of [`FEATURES`].
    Feature(usize),
    /// Part (0: real, 1: imaginary) of a multiplier.
    Multiplier(usize, usize),
    /// One of [`SETTINGS`].
    Setting(usize),
    /// One of [`WAYPOINT`].
    Branch(usize),
}

/// Settings of the search: laps, whether to begin where the last one ended (1: at once; 2: after
/// laps that are simulated), laps simulated first, steps at the most, longest lap (s), Krylov vectors for multipliers; then those of a
/// branch: the value reference it goes along (negative: none), the longest stride over the
/// parameter's start value (its sign: which way at first), and the number of the waypoint wanted,
/// in order from 1; at 0 the branch begins anew from the last cycle.
pub const SETTINGS: [&str; 9] = [
    "laps",
    "continues",
    "settle",
    "steps",
    "longest_lap",
    "krylov_vectors",
    "branch_along",
    "branch_stride",
    "waypoint",
];

/// Where the three settings of a branch begin.
pub const BRANCH: usize = 6;

/// Value reference of the first number of a branch.
pub const BRANCH_FROM: u32 = CYCLE + 200;
/// The parameter's value at a branch's last point; whether it rises where the branch goes on;
/// whether the way to the point was not resolved.
pub const WAYPOINT: [&str; 3] = ["branch_value", "branch_rises", "branch_over"];

impl Place {
    /// The place of a value reference; `None` if it is none of these.
    pub fn of(reference: u32) -> Option<Self> {
        let within = |first: u32, count: usize| {
            let index = reference.checked_sub(first)? as usize;
            (index < count).then_some(index)
        };
        if let Some(index) = within(CYCLE, FEATURES.len()) {
            return Some(Self::Feature(index));
        }
        if let Some(index) = within(MULTIPLIERS_FROM, 2 * MULTIPLIERS) {
            return Some(Self::Multiplier(index / 2, index % 2));
        }
        if let Some(index) = within(BRANCH_FROM, WAYPOINT.len()) {
            return Some(Self::Branch(index));
        }
        within(SEARCH, SETTINGS.len()).map(Self::Setting)
    }
}

/// What a value reference is a derivative by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// A constant added to an input over the last step.
    Step(Input),
    /// A parameter, or a constant added to an input, since the start.
    Start(Seed),
}

impl Known {
    /// By value reference, or by the name that the table has there.
    pub fn of(reference: u32, name: Option<&str>) -> Option<Self> {
        if let Some(index) = reference.checked_sub(OFFSETS)
            && let Some(input) = Input::ALL.get(index as usize)
        {
            return Some(Self::Start(Seed::Input(*input, 0)));
        }
        match Seed::named(name?)? {
            Seed::Input(input, _) => Some(Self::Step(input)),
            seed => Some(Self::Start(seed)),
        }
    }

    /// What it is of a cycle: there an input is what it always is.
    pub fn seed(self) -> Seed {
        match self {
            Self::Step(input) => Seed::Input(input, 0),
            Self::Start(seed) => seed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hammer::tangent::Parameter;
    use hammer::variables::VARIABLES;

    #[test]
    fn references_do_not_meet_and_names_are_those_of_the_table() {
        assert!(crate::waves::Place::of(OFFSETS).is_none());
        assert!(Place::of(REACH).is_none() && Place::of(CYCLE).is_some());
        assert_eq!(Place::of(SEARCH), Some(Place::Setting(0)));
        let named = PICKS.map(|(name, _)| name).into_iter();
        for name in named.chain(ON_DEMAND.map(|(name, ..)| name)) {
            assert!(VARIABLES.iter().any(|v| v.name == name), "{name}");
        }
        for parameter in Parameter::ALL {
            assert!(VARIABLES.iter().any(|v| v.name == parameter.name()), "{}", parameter.name());
        }
    }
}
