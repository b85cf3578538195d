//! What can go wrong, by name.

use crate::interrupt;
use crate::laws::mode::Mode;
pub use crate::numerics::display::DisplayNumber;
pub use crate::quantities::domain::ParameterError;
use crate::quantities::inputs::Input;
pub use crate::quantities::inputs::InputError;
use crate::quantities::warnings::Suspect;
use thiserror::Error;

/// What a search takes too much of.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum WorkLimit {
    /// More transitions than mesh, contact and rock can make in that time.
    #[error("too many transitions in too short a time")]
    Transitions,
    /// The contact opens and closes too often in one step.
    #[error("the contact chatters")]
    Contact,
    /// The rock changes its mode too often in one step.
    #[error("the rock changes its mode again and again")]
    Rock,
    /// The relay or the chambers switch too often in one step.
    #[error("the drive switches again and again")]
    Drive,
    /// Inputs vary too fast for their power series.
    #[error("an input's derivatives vary too fast")]
    Loads,
    /// The search for the next event takes too many evaluations.
    #[error("an event function hovers at zero")]
    Search,
}

/// Why a linear system cannot be decomposed to working accuracy.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SpectrumError {
    /// The iteration for the eigenvalues ran out of sweeps.
    #[error("its eigenvalues do not settle")]
    Unsettled,
    /// Some eigenvalue is missing, found twice or wrong.
    #[error("the sum of its eigenvalues is not the trace of its damping")]
    Trace,
    /// Complex eigenvalues of a real system without their conjugates.
    #[error("its eigenvalues are not in conjugate pairs")]
    Unpaired,
    /// A pair of eigenvalues and their vectors do not solve the equation of motion.
    #[error("a pair of its eigenvalues leaves a residual")]
    Residual,
    /// An eigenvector overflowed.
    #[error("an eigenvector is not finite")]
    Infinite,
    /// An [`Interrupt`](crate::Interrupt) came.
    #[error("it was cancelled")]
    Cancelled,
    /// What goes into the modal basis does not come back.
    #[error("its modal basis and the inverse of that do not fit")]
    Mismatch,
}

/// Why a stored state is none of a hammer.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum CorruptState {
    /// A number is infinite or none.
    #[error("a number is not finite")]
    NotFinite,
    /// Last event, time since and present time disagree.
    #[error("its times do not agree")]
    Times,
    /// The communication step starts outside the stretch since the last event.
    #[error("its step does not lie before its present")]
    Step,
    /// An amplitude is taken later than the last event.
    #[error("it is ahead of its last event")]
    Ahead,
    /// A coordinate beyond the last.
    #[error("it has coordinates that its bodies have not")]
    Coordinates,
    /// The power series of a slow coordinate ends before the present.
    #[error("its series do not reach its present")]
    Series,
    /// A chamber's pressure is none, or was to reach its level before the present.
    #[error("its chambers have no pressure or a late one")]
    Chambers,
    /// More blows in a step than are kept.
    #[error("it has too many blows")]
    Blows,
    /// More events than any run has.
    #[error("it has counted more than any run does")]
    Counts,
}

/// Everything the engine can refuse or fail at.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// A parameter out of its domain.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// An input value or derivative that is refused.
    #[error("input {name}: {error}")]
    Input {
        /// Name of the input.
        name: &'static str,
        /// What is wrong with it.
        error: InputError,
    },
    /// `advance` towards an instant that is not finite or lies in the past.
    #[error("cannot advance from t = {} s to t = {} s", DisplayNumber(*.from), DisplayNumber(*.to))]
    Backwards {
        /// Present time, s.
        from: f64,
        /// The instant asked for, s.
        to: f64,
    },
    /// Mode transitions chase one another at one instant without end.
    #[error("{transitions} transitions at t = {} s without end (last modes: {from}; {to})", DisplayNumber(*.time))]
    Chattering {
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
    #[error(
        "the step takes too much work at t = {} s: {limit} ({mode}){}",
        DisplayNumber(*.time), hint(.suspect.as_ref())
    )]
    Overwork {
        /// When, s.
        time: f64,
        /// What there is too much of.
        limit: WorkLimit,
        /// The mode.
        mode: Mode,
        /// The parameter that is furthest from what the bodies can follow, if any is far off.
        suspect: Option<Suspect>,
    },
    /// An [`Interrupt`](crate::Interrupt) ended the work. A machine stands at its last event, or where
    /// the step began if none came before, and can go on from there.
    #[error("cancelled before it was done")]
    Cancelled,
    /// The system does not give the memory that the scene may need.
    #[error(
        "{} elements of the piston and {} of the bit (degree {degree}) may take {:.0} MB, \
         which the system does not give: take a coarser mesh",
        .elements[0], .elements[1], *.bytes as f64 / 1e6
    )]
    OutOfMemory {
        /// Of the piston's mesh and of the bit's.
        elements: [usize; 2],
        /// Of the mesh.
        degree: usize,
        /// What was asked for.
        bytes: usize,
    },
    /// The free modes of a stepped body could not be found to working accuracy.
    #[error("the modes of the {body} cannot be found: its sections differ too much")]
    Modes {
        /// Piston or bit.
        body: &'static str,
    },
    /// The eigenvalues of a system could not be found to working accuracy.
    #[error("the hammer with {mode} cannot be decomposed: {error}")]
    Spectrum {
        /// The mode whose linear system failed.
        mode: Mode,
        /// Why.
        error: SpectrumError,
    },
    /// A stored state of a scene with other dimensions.
    #[error("the stored state belongs to a scene with other dimensions")]
    Foreign,
    /// A stored state that no scene is ever in.
    #[error("the stored state is none of a hammer: {what}")]
    Corrupt {
        /// What is wrong with it.
        what: CorruptState,
    },
    /// The state left the range of numbers.
    #[error("the state is not finite at t = {} s", DisplayNumber(*.time))]
    NotFinite {
        /// When, s.
        time: f64,
    },
}

impl Error {
    /// Refuses to go on with what an interrupt is to end.
    pub(crate) fn if_interrupted() -> Result<(), Self> {
        if interrupt::is_set() { Err(Self::Cancelled) } else { Ok(()) }
    }

    /// A refused value of this input.
    pub(crate) fn of_input(input: Input) -> impl Fn(InputError) -> Self {
        move |error| Self::Input { name: input.name(), error }
    }
}

fn hint(suspect: Option<&Suspect>) -> String {
    suspect.map_or_else(String::new, |suspect| format!("; {suspect}"))
}
