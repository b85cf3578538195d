//! What can go wrong, by name.

pub use crate::numerics::plain::Plain;
pub use crate::physics::domain::ParameterError;
pub use crate::physics::inputs::InputFault;
use crate::physics::mode::Mode;
use thiserror::Error;

/// What a search takes too much of.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Excess {
    /// More transitions than mesh, contact and rock can make in that time.
    #[error("too many transitions in too short a time")]
    Transitions,
    /// More evaluations of guards than a second of any hammer takes.
    #[error("too many evaluations since the last event")]
    Evaluations,
}

/// Everything the engine can refuse or fail at.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// A parameter out of its domain.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An input value or derivative that is refused.
    #[error("input {name}: {fault}")]
    Input {
        /// Name of the input.
        name: &'static str,
        /// What is wrong with it.
        fault: InputFault,
    },
    /// `advance` towards an instant that is not finite or lies in the past.
    #[error("cannot advance from t = {} s to t = {} s", Plain(*.from), Plain(*.to))]
    Backwards {
        /// Present time, s.
        from: f64,
        /// The instant asked for, s.
        to: f64,
    },
    /// Mode transitions chase one another at one instant without end.
    #[error("{transitions} transitions at t = {} s without end (last modes: {from:?}, {to:?})", Plain(*.time))]
    Cascade {
        /// When, s.
        time: f64,
        /// How many.
        transitions: u32,
        /// The last mode left.
        from: Mode,
        /// The last mode entered.
        to: Mode,
    },
    /// The scene asks for more work than any hammer: frequencies or event rates out of reach.
    #[error("the search at t = {} s does not get on: {excess} (mode {mode:?})", Plain(*.time))]
    Overwork {
        /// When, s.
        time: f64,
        /// What there is too much of.
        excess: Excess,
        /// The mode.
        mode: Mode,
    },
    /// The free modes of a stepped body could not be found to working accuracy.
    #[error("the modes of the {body} cannot be found: its sections differ too much")]
    Modes {
        /// Piston or bit.
        body: &'static str,
    },
    /// The eigenvalues of a system could not be found to working accuracy.
    #[error("the spectrum of {mode:?} cannot be resolved: {reason}")]
    Spectrum {
        /// The mode whose linear system failed.
        mode: Mode,
        /// Why.
        reason: &'static str,
    },
    /// A stored state of a scene with other dimensions.
    #[error("the stored state belongs to a scene with other dimensions")]
    Foreign,
    /// A stored state that no scene is ever in.
    #[error("the stored state is none of a hammer: {what}")]
    Forged {
        /// What is wrong with it.
        what: &'static str,
    },
    /// The state left the range of numbers.
    #[error("the state is not finite at t = {} s", Plain(*.time))]
    NotFinite {
        /// When, s.
        time: f64,
    },
}
