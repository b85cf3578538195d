//! Results of a [run](crate::run): the transitions, the sampled states, or why it was given up.

use crate::law::{Event, Memory, Mode, State};
use serde::{Deserialize, Serialize};

/// Events closer than this are simultaneous, s: contact first, then joints, rock, drive.
pub(crate) const INSTANT: f64 = 1e-15;

/// Why a run was given up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GivenUp {
    /// More than a hundred transitions at one instant, s.
    Zeno(f64),
    /// More series than allowed, by this time, s.
    Long(f64),
}

impl std::fmt::Display for GivenUp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Zeno(time) => write!(f, "transitions without end at {time} s"),
            Self::Long(time) => write!(f, "too many series by {time} s"),
        }
    }
}

impl std::error::Error for GivenUp {}

/// A transition that happened.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Passed<T> {
    /// When, s.
    pub time: T,
    /// Which.
    pub event: Event,
    /// The mode after it.
    pub mode: Mode,
    /// Rate of the guard there, in its quantity's unit per second; 0 where an action or another event moved it across
    /// the level.
    pub rate: T,
}

/// Energies, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies<T> {
    /// Work of `F_A`, and of its reaction on a casing.
    pub drive: T,
    /// Work of gravity.
    pub gravity: T,
    /// Work of the feed force.
    pub feed: T,
    /// Kinetic energy, strain energy, energy of contact and joints, recoverable rock energy.
    pub stored: [T; 4],
    /// Dissipated on the loading lines.
    pub rock: T,
    /// Dissipated in the dashpot.
    pub viscous: T,
    /// Dissipated in the material, in joints and in the string above a casing: the exact remainder of the balance.
    pub damping: T,
    /// Added by retuning.
    pub retuned: T,
}

/// A sampled state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sampled<T> {
    /// When, s.
    pub time: f64,
    /// The mode then.
    pub mode: Mode,
    /// The rock's memory then.
    pub memory: Memory<T>,
    /// The continuous state then.
    pub state: State<T>,
    /// Contact force and rock force, N.
    pub forces: [T; 2],
    /// Forces by which the joints push their bodies apart, N.
    pub joints: Vec<T>,
    /// Force on the piston, N.
    pub force: T,
    /// The ledger then.
    pub energies: Energies<T>,
    /// Pressures of the chambers of air, Pa, and the mass taken from its supply, kg; zeros without.
    pub pressures: [T; 2],
    /// Mass taken from the supply, kg.
    pub taken: T,
}
