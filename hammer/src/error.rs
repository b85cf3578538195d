//! Errors.

use crate::interrupt;
use crate::laws::mode::Mode;
pub use crate::numerics::display::DisplayNumber;
pub use crate::quantities::domain::ParameterError;
use crate::quantities::inputs::Input;
pub use crate::quantities::inputs::InputError;
use crate::quantities::warnings::Suspect;
use thiserror::Error;

/// What exceeded its limit of work.
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
    /// Bit and casing meet and part too often in one step.
    #[error("the chuck chatters")]
    Chuck,
    /// Rods meet and part too often in one step.
    #[error("the joints of the drill string chatter")]
    Joints,
    /// The relay or the chambers switch too often in one step.
    #[error("the drive switches again and again")]
    Drive,
    /// Inputs vary too fast for their power series.
    #[error("an input's derivatives vary too fast")]
    Loads,
    /// The search for the next event needs too many evaluations.
    #[error("an event function hovers at zero")]
    Search,
    /// Forces ring too long in one step for their peaks to be searched.
    #[error("its forces ring too long for the largest to be found: take shorter steps")]
    Peaks,
}

/// Why a linear system could not be decomposed to working accuracy.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SpectrumError {
    /// The eigenvalue iteration did not converge.
    #[error("its eigenvalues do not settle")]
    Unsettled,
    /// An eigenvalue is missing, duplicated or wrong.
    #[error("the sum of its eigenvalues is not the trace of its damping")]
    Trace,
    /// Complex eigenvalues of a real system without their conjugates.
    #[error("its eigenvalues are not in conjugate pairs")]
    Unpaired,
    /// An eigenvalue pair and its vectors do not satisfy the equation of motion.
    #[error("a pair of its eigenvalues leaves a residual")]
    Residual,
    /// An eigenvector overflowed.
    #[error("an eigenvector is not finite")]
    Infinite,
    /// An [`Interrupt`](crate::Interrupt) came.
    #[error("it was cancelled")]
    Cancelled,
    /// A state converted to the modal basis and back differs.
    #[error("its modal basis and the inverse of that do not fit")]
    Mismatch,
}

/// Why a stored state is corrupt.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum CorruptState {
    /// A number is infinite or NaN.
    #[error("a number is not finite")]
    NotFinite,
    /// The last event, the time since and the present time disagree.
    #[error("its times do not agree")]
    Times,
    /// The communication step starts before the last event or after the present.
    #[error("its step does not lie before its present")]
    Step,
    /// An anchor is later than the last event.
    #[error("it is ahead of its last event")]
    Ahead,
    /// A coordinate's index is too large.
    #[error("it has coordinates that its bodies have not")]
    Coordinates,
    /// The power series of a slow coordinate ends before the present.
    #[error("its series do not reach its present")]
    Series,
    /// A chamber's pressure is invalid, or should have reached its level already.
    #[error("its chambers have no pressure or a late one")]
    Chambers,
    /// Too many blows in one step.
    #[error("it has too many blows")]
    Blows,
    /// More events than any run can have.
    #[error("it has counted more than any run does")]
    Counts,
}

/// Every error of the engine.
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
    /// `advance` to an instant that is not finite or in the past.
    #[error("cannot advance from t = {} s to t = {} s", DisplayNumber(*.from), DisplayNumber(*.to))]
    Backwards {
        /// Present time, s.
        from: f64,
        /// The instant asked for, s.
        to: f64,
    },
    /// A loose joint of the drill string is pulled from the start.
    #[error("joint {joint} of the drill string is pulled by {} N at the start: feed and weight must press it; drill.joint.slack 0 holds it both ways", DisplayNumber(-*.force))]
    JointPulled {
        /// From the shank down, from 1.
        joint: usize,
        /// What presses it, N: below 0.
        force: f64,
    },
    /// The air's flows change too fast to be followed, or a chamber has no volume left.
    #[error("the air cannot be followed beyond t = {} s: a chamber has no volume left, or its ports are far too wide", DisplayNumber(*.time))]
    Air {
        /// When, s.
        time: f64,
    },
    /// Zeno behaviour: mode transitions at one instant without end.
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
    /// The scene needs too much work: its frequencies or event rates are far beyond any hammer's.
    #[error(
        "the call takes too much work at t = {} s: {limit} ({mode}){}{}",
        DisplayNumber(*.time), hint(.suspect.as_ref()),
        .work_limit.map_or_else(String::new, |limit| format!("; work_limit = {limit} ends it"))
    )]
    Overwork {
        /// When, s.
        time: f64,
        /// What exceeded its limit.
        limit: WorkLimit,
        /// The mode.
        mode: Mode,
        /// The parameter that is most out of proportion, if any is.
        suspect: Option<Suspect>,
        /// The limit of the call, if it is that which was reached.
        work_limit: Option<usize>,
    },
    /// An [`Interrupt`](crate::Interrupt) ended the work. A machine stands at its last event, or at the
    /// start of the step if there was none, and can go on.
    #[error("cancelled before it was done")]
    Cancelled,
    /// The system has too little memory for the scene.
    #[error(
        "{} elements of the piston, {} of the bit and {} of the casing (degree {degree}) may take \
         {:.0} MB, which the system does not give: take a coarser mesh",
        .elements[0], .elements[1], .elements[2], *.bytes as f64 / 1e6
    )]
    OutOfMemory {
        /// Of the piston's mesh, of the bit's, and of the casing's (0: rigid, or none).
        elements: [usize; 3],
        /// Of the mesh.
        degree: usize,
        /// The memory requested.
        bytes: usize,
    },
    /// The free modes of a stepped body could not be computed to working accuracy.
    #[error("the modes of the {body} cannot be found: its sections differ too much")]
    Modes {
        /// Piston or bit.
        body: &'static str,
    },
    /// The eigenvalues of a system could not be computed to working accuracy.
    #[error("the hammer with {mode} cannot be decomposed: {error}{}", hint(.suspect.as_ref()))]
    Spectrum {
        /// The mode whose linear system failed.
        mode: Mode,
        /// Why.
        error: SpectrumError,
        /// The parameter that is most out of proportion, if any is.
        suspect: Option<Suspect>,
    },
    /// A stored state belongs to a scene of other dimensions.
    #[error("the stored state belongs to a scene with other dimensions")]
    Foreign,
    /// A stored state is corrupt.
    #[error("the stored state is none of a hammer: {what}")]
    Corrupt {
        /// What is wrong with it.
        what: CorruptState,
    },
    /// A number of the state overflowed.
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

    /// With the parameter that is most out of proportion, where a system cannot be decomposed.
    pub(crate) fn suspecting(mut self, far_off: Option<Suspect>) -> Self {
        if let Self::Spectrum { suspect, .. } = &mut self {
            *suspect = far_off;
        }
        self
    }

    /// A refused value of this input.
    pub(crate) fn of_input(input: Input) -> impl Fn(InputError) -> Self {
        move |error| Self::Input { name: input.name(), error }
    }
}

fn hint(suspect: Option<&Suspect>) -> String {
    suspect.map_or_else(String::new, |suspect| format!("; {suspect}"))
}
