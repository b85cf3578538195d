//! The reasons why a call is refused. Each makes one log line, and leaves the instance unchanged.

use hammer::{DisplayNumber, ParameterError};
use std::any::Any;
use thiserror::Error;

/// The reason why a call is refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CallError {
    /// The standard's state machine forbids the call.
    #[error("{call} is not allowed {phase}")]
    Order {
        /// Name of the call.
        call: String,
        /// The phase of the instance, in words such as "before initialization".
        phase: &'static str,
    },
    /// An argument is a null pointer, or a pointer without the alignment of its type.
    #[error("argument {0} is a null or misaligned pointer")]
    Pointer(&'static str),
    /// There are more elements in the call than variables.
    #[error("{count} elements in one call, but there are only {variables} variables")]
    TooMany {
        /// The number of elements in the call.
        count: usize,
        /// The number of variables.
        variables: usize,
    },
    /// No variable of that type has this value reference.
    #[error("value reference {reference} is not that of {wanted}")]
    Reference {
        /// The value reference.
        reference: u32,
        /// What was expected, with its article.
        wanted: &'static str,
    },
    /// A variable cannot be set now, or ever.
    #[error("{name} cannot be set: {reason}")]
    ReadOnly {
        /// Name of the variable.
        name: &'static str,
        /// The reason, in words.
        reason: &'static str,
    },
    /// A value is not a number, or infinite.
    #[error("{name} = {} is not allowed: it must be a finite number", DisplayNumber(*.value))]
    NotFinite {
        /// Name of the variable or argument.
        name: &'static str,
        /// The given value.
        value: f64,
    },
    /// An output is beyond the range of doubles.
    #[error("{name} is not a finite number: loads or a stored state are far beyond any hammer's")]
    Overflowed {
        /// Name of the output.
        name: &'static str,
    },
    /// An argument is invalid.
    #[error("{0}")]
    Argument(String),
    /// A parameter is out of its domain.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The engine refuses the call or fails.
    #[error(transparent)]
    Engine(#[from] hammer::Error),
    /// An earlier step failed.
    #[error("an earlier step failed: reset the instance or restore a state")]
    Failed,
    /// A state was freed before, or never taken.
    #[error("this FMU state does not exist: it was freed, or belongs to another FMU")]
    UnknownState,
    /// There are no handles left for another state.
    #[error("too many FMU states are held: free some")]
    TooManyStates,
    /// A serialised state comes from another build or is of another kind.
    #[error("the serialised state cannot be used: {0}")]
    Serialised(&'static str),
    /// There is no long work to cancel.
    #[error(
        "fmi2CancelStep has nothing to cancel: no other thread is in a step of this instance, in its \
         initialization or in derivatives, and a step is over when fmi2DoStep returns \
         (canRunAsynchronuously is false)"
    )]
    NothingToCancel,
    /// The library has a bug: a panic was caught before it reached the host.
    #[error("internal error: {0}")]
    Panic(String),
}

impl CallError {
    /// The message of a caught panic.
    pub fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        Self::Panic(text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default())
    }
}
