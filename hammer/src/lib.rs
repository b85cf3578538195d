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
pub mod motion;
pub mod numerics;
pub mod physics;
pub mod search;

pub use error::{Error, Excess, InputFault, ParameterError};
pub use machine::Machine;
pub use machine::blows::{Blow, Blows};
pub use machine::journal::{Counters, Record};
pub use machine::ledger::{Energies, Impulses, Ledger, Sums};
pub use machine::outputs::{Kinematics, Profile};
pub use machine::pace::{MAX_BURST, MAX_CASCADE, Pace, SHORTEST_SPACING};
pub use machine::peaks::Peaks;
pub use machine::state::State;
pub use numerics::vectors::Vectors;
pub use physics::body::{Body, MAX_SEGMENTS, Sections, Segment};
pub use physics::drive::Relay;
pub use physics::event::{Direction, Displacement, Event, Guard, Quantity};
pub use physics::inputs::Input;
pub use physics::mode::Mode;
pub use physics::parameters::{
    Domain, Fidelity, InputValues, MAX_DEGREE, MAX_ELEMENTS, Parameters, RULES, Rule, Source,
    Tunables,
};
pub use physics::rock::{RockEvent, RockMode};
pub use search::TIME_RESOLUTION;
