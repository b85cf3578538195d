//! The dynamic state of a scene: all that a restart needs, and nothing that can be made again.

use crate::machine::ledger::Sums;
use crate::machine::observe::{Blow, Counters, Peaks};
use crate::modal::model::Span;
use crate::modal::system::CHANNELS;
use crate::numerics::instant::Double;
use crate::numerics::poly::Poly;
use crate::physics::inputs::Inputs;
use crate::physics::mode::Mode;
use crate::physics::parameters::Parameters;
use crate::physics::rock::Memory;
use serde::{Deserialize, Serialize};

/// A modal track at the last event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// Bodies and spring.
    pub span: Span,
    /// Modal vector at `at`.
    pub z: Vec<f64>,
    /// Its instant after the epoch, s (not after 0).
    pub at: f64,
    /// Uniform translation after the epoch.
    pub translation: Poly,
    /// `z.Q z` where the damping was last summed, J.
    pub form: f64,
}

/// Where drilling stood at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Milestone {
    /// Time.
    pub time: Double,
    /// Hole depth.
    pub hole: Double,
}

/// Dynamic state; times are relative to `epoch`, displacements to `origin`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Parameters, with the tunables as they are now.
    pub parameters: Parameters,
    /// Discrete state.
    pub mode: Mode,
    /// Instant of the last event.
    pub epoch: Double,
    /// Present time after the epoch, s.
    pub now: f64,
    /// Present time as the host names it, s.
    pub time: f64,
    /// Input polynomials after the epoch.
    pub inputs: Inputs,
    /// Loads after the epoch.
    pub loads: [Poly; CHANNELS],
    /// Bit, and piston; or both as one.
    pub anchors: Vec<Anchor>,
    /// Zero of the present rock line.
    pub origin: Double,
    /// Rock memory relative to the origin.
    pub memory: Memory,
    /// Viscous work of the present cycle before the epoch, J.
    pub psi: f64,
    /// Sums before the epoch.
    pub sums: Sums,
    /// Mechanical energy at the start, J.
    pub energy_start: f64,
    /// Counters, but for the work in hand.
    pub counters: Counters,
    /// Last blow.
    pub blow: Blow,
    /// At the first blow, and at the last.
    pub blows: [Option<Milestone>; 2],
    /// Start of the present or last collision.
    pub collision: Option<Double>,
    /// Last opening of the contact.
    pub opened: Option<Double>,
    /// Peaks of the present step before the epoch.
    pub peaks: Peaks,
    /// Start of the present step after the epoch, s (0 if before).
    pub step_start: f64,
    /// Transitions at the present instant.
    pub simultaneous: u32,
    /// Transitions since the instant beside it, up to [`crate::MAX_BURST`].
    pub burst: (u32, Double),
}
