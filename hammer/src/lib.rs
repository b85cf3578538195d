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

pub mod bar;
mod barrier;
mod basis;
pub mod error;
pub mod guard;
mod inputs;
mod instant;
pub mod kernel;
mod ledger;
mod machine;
mod math;
pub mod mode;
mod model;
pub mod observe;
mod pairs;
pub mod parameters;
mod peaks;
pub mod poly;
mod receptance;
mod report;
mod rock;
pub mod spectrum;
mod start;
mod state;
pub mod system;
mod transit;
mod watchlist;
mod window;

pub use error::{Error, ParameterError};
pub use inputs::Input;
pub use machine::{MAX_BURST, MAX_CASCADE, Machine, SHORTEST_SPACING, TIME_RESOLUTION};
pub use mode::{Mode, Relay, RockMode};
pub use observe::{Blow, Counters, Energies, Impulses, Kinematics, Peaks, Profile, Record};
pub use parameters::{
    Domain, Fidelity, InputValues, MAX_ELEMENTS, Parameters, RULES, Rule, Source,
};
pub use state::State;
