//! The automaton's discrete state.

use crate::physics::drive::Relay;
use crate::physics::rock::RockMode;
use serde::{Deserialize, Serialize};

/// The whole discrete state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mode {
    /// Piston/bit contact closed.
    pub closed: bool,
    /// Bit/rock law.
    pub rock: RockMode,
    /// Pressure relay.
    pub relay: Relay,
}
