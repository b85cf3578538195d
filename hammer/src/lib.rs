//! Down-the-hole percussive drilling: physics and exact event-driven integration.
//!
//! A piston strikes a bit, a stress wave runs down, the rock breaks. Between events the
//! hammer is linear with constant coefficients, so nothing is stepped: the state is carried
//! by modal exponentials and polynomials, and the search for the next event is a proof.
//!
//! ```
//! use hammer::{InputValues, Machine, Parameters};
//!
//! let mut hammer = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
//! hammer.advance(0.1)?;
//! assert_eq!(hammer.counters().blows, 2);
//! # Ok::<(), hammer::Error>(())
//! ```

/// Highest derivative of an input that is taken.
pub const MAX_INPUT_ORDER: usize = 4;

pub mod error;
mod machine;
pub mod modal;
pub mod numerics;
pub mod physics;
pub mod search;

pub use error::{Error, ParameterError};
pub use machine::observe::{
    Blow, Counters, Energies, Impulses, Kinematics, Peaks, Profile, Record,
};
pub use machine::state::State;
pub use machine::{MAX_BURST, MAX_CASCADE, Machine, SHORTEST_SPACING, TIME_RESOLUTION};
pub use numerics::vectors::Vectors;
pub use physics::body::{Body, MAX_SEGMENTS, Sections, Segment};
pub use physics::inputs::Input;
pub use physics::mode::{Mode, Relay, RockMode};
pub use physics::parameters::{
    Domain, Fidelity, InputValues, MAX_DEGREE, MAX_ELEMENTS, Parameters, RULES, Rule, Source,
};
