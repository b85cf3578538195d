#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

/// Highest derivative of an input that is accepted.
pub const MAX_INPUT_ORDER: usize = 4;

mod allowance;
pub mod datasheet;
mod energy;
mod error;
mod interrupt;
mod machine;
pub mod means;
pub mod presets;
pub mod sensitivity;
pub mod variables;

// Public only for the project's own tests and evidence.
#[path = "."]
mod engine {
    pub mod air;
    pub mod bodies;
    pub mod laws;
    pub mod modal;
    pub mod motion;
    pub mod numerics;
    pub mod quantities;
    pub mod scene;
    pub mod search;
}
#[cfg(not(feature = "internals"))]
use engine::{air, bodies, laws, modal, motion, numerics, quantities, scene, search};
#[cfg(feature = "internals")]
#[doc(hidden)]
pub use engine::{air, bodies, laws, modal, motion, numerics, quantities, scene, search};

pub use bodies::resolution::{MeshAdvice, Reading};
pub use energy::ledger::{Energies, Impulses};
pub use energy::peaks::Peaks;
pub use error::{
    CorruptState, DisplayNumber, Error, InputError, ParameterError, SpectrumError, WorkLimit,
};
pub use interrupt::{Interrupt, in_threads};
pub use laws::event::{Event, RockEvent};
pub use laws::mode::{Chamber, Mode, Port, Relay, RockMode, Tie, TieState, Ties};
pub use machine::Machine;
pub use machine::blows::{Account, Blow, MAX_STEP_BLOWS};
pub use machine::journal::{Counters, Record};
pub use machine::outputs::{Kinematics, Profile};
pub use machine::state::State;
pub use machine::stops::{Stop, Stops};
pub use machine::zeno::{MAX_BURST, MAX_SIMULTANEOUS, SHORTEST_SPACING};
pub use modal::shared::forget as forget_shared_systems;
pub use motion::PointMotion;
pub use num_complex::Complex64;
pub use numerics::vectors::Vectors;
pub use quantities::air::{AirChamber, AirLaw};
pub use quantities::domain::Domain;
pub use quantities::inputs::Input;
pub use quantities::parameters::*;
pub use quantities::quantity;
pub use quantities::scales::Timescales;
pub use quantities::sections::{
    Body, MAX_RODS, MAX_SECTIONS, MAX_SEGMENTS, Sections, Segment, Segments,
};
pub use quantities::warnings::{Suspect, buried, starved, unfed, unlikely};
pub use scene::Scene;
pub use search::TIME_RESOLUTION;
