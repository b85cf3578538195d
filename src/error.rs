//! Why a call is refused: each is one log line and leaves the instance unchanged.

use hammer::{DisplayNumber, ParameterError};
use std::any::Any;
use thiserror::Error;

/// Why a call is refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CallError {
    /// The standard's state machine forbids the call.
    #[error("{call} is not allowed {phase}")]
    Order {
        /// The call.
        call: String,
        /// The instance's phase, as "before ...".
        phase: &'static str,
    },
    /// A null pointer, or one without the alignment of its type.
    #[error("argument {0} is a null or misaligned pointer")]
    Pointer(&'static str),
    /// More elements than variables.
    #[error("{count} elements in one call, but there are only {variables} variables")]
    TooMany {
        /// The number in the call.
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
    /// It cannot be set now, or ever.
    #[error("{name} cannot be set: {reason}")]
    ReadOnly {
        /// The variable.
        name: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// Not a number, or infinite.
    #[error("{name} = {} is not allowed: it must be a finite number", DisplayNumber(*.value))]
    NotFinite {
        /// The variable or argument.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The output is beyond the range of doubles.
    #[error("{name} is not a finite number: loads or a stored state are far beyond any hammer's")]
    Overflowed {
        /// The output.
        name: &'static str,
    },
    /// An invalid argument.
    #[error("{0}")]
    Argument(String),
    /// A parameter out of its domain.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The engine refuses the call or fails.
    #[error(transparent)]
    Engine(#[from] hammer::Error),
    /// The last step failed.
    #[error("an earlier step failed: reset the instance or restore a state")]
    Failed,
    /// A state that was freed, or never taken.
    #[error("this FMU state does not exist: it was freed, or belongs to another FMU")]
    UnknownState,
    /// More states than there are handles for.
    #[error("too many FMU states are held: free some")]
    TooManyStates,
    /// Serialised state of another build or kind.
    #[error("the serialised state cannot be used: {0}")]
    Serialised(&'static str),
    /// There is no long work to cancel.
    #[error(
        "fmi2CancelStep has nothing to cancel: no other thread is in a step of this instance, in its \
         initialization or in derivatives, and a step is over when fmi2DoStep returns \
         (canRunAsynchronuously is false)"
    )]
    NothingToCancel,
    /// A bug, caught before it reaches the host.
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
