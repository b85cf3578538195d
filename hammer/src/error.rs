//! The errors of the engine.

use crate::interrupt;
use crate::laws::mode::{Mode, Tie};
use crate::laws::tie::VENTING;
pub use crate::numerics::display::DisplayNumber;
pub use crate::quantities::domain::ParameterError;
use crate::quantities::inputs::Input;
pub use crate::quantities::inputs::InputError;
use crate::quantities::warnings::Suspect;
use thiserror::Error;

/// The kind of work that exceeded its limit.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum WorkLimit {
    /// There are more transitions than mesh, contact and rock can cause in that time.
    #[error("the mode changes more often than mesh, contact and rock can make it")]
    Transitions,
    /// The bodies of a tie meet and part too often in one step.
    #[error("the {0} chatters")]
    Tie(Tie),
    /// The rock changes its mode too often in one step.
    #[error("the rock changes its mode again and again")]
    Rock,
    /// The relay or the ports switch too often in one step.
    #[error("the drive switches again and again")]
    Drive,
    /// The instant of the rock's energy barrier needs too many integrals.
    #[error("most of it is for the instant at which the rock's dashpot reaches the energy barrier")]
    Barrier,
    /// The air in the chambers needs too many iterations.
    #[error("most of it is for the air in the chambers")]
    Air,
    /// Inputs vary too fast for their power series.
    #[error("an input, or the line at the piston, varies too fast")]
    Loads,
    /// The search for the next event needs too many evaluations.
    #[error("a quantity stays too close to the value at which the mode would change")]
    Search,
    /// Forces ring too long in one step for their peaks to be searched.
    #[error("finding the largest force of so long a step takes too long: take shorter steps")]
    Peaks,
}

/// The reason why a linear system could not be decomposed to working accuracy.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpectrumError {
    /// The eigenvalue iteration did not converge.
    #[error("the iteration for its eigenvalues does not converge")]
    Unsettled,
    /// An eigenvalue is missing, duplicated or wrong.
    #[error("its eigenvalues do not add up to the trace of its damping matrix")]
    Trace,
    /// Complex eigenvalues of a real system lack their conjugates.
    #[error("its complex eigenvalues are not in conjugate pairs")]
    Unpaired,
    /// An eigenvector overflowed.
    #[error("an eigenvector is not finite")]
    Infinite,
    /// An [`Interrupt`](crate::Interrupt) ended the decomposition.
    #[error("it was cancelled")]
    Cancelled,
    /// A state that is converted to the modal basis and back differs from the original.
    #[error("its modal basis times the computed inverse is not the identity")]
    Mismatch,
}

/// The reason why a stored state is corrupt.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CorruptState {
    /// A number is infinite or NaN.
    #[error("it has a number that is not finite")]
    NotFinite,
    /// The instant of the last event, the time since then and the present time disagree.
    #[error("its times contradict each other")]
    Times,
    /// The communication step starts before the last event or after the present.
    #[error("its communication step does not begin between its last event and its present time")]
    Step,
    /// An anchor is later than the last event, or earlier although its group is not a piston that flies alone.
    #[error("one of its reference instants is not that of its last event")]
    Ahead,
    /// An event lies between the last stored event and the present.
    #[error("an event lies between its last one and its present time")]
    Passed,
    /// A coordinate's index is too large.
    #[error("it has more modal coordinates than its bodies have modes")]
    Coordinates,
    /// The power series of a slow coordinate ends before the present.
    #[error("one of its power series ends before its present time")]
    Series,
    /// The air in the chambers is invalid, or contradicts the mode.
    #[error("the air in the chambers is invalid, or is not where the mode has it")]
    Air,
    /// The state has too many blows in one step.
    #[error("it has more blows than one step can have")]
    Blows,
    /// The state's counts are higher than any run can reach.
    #[error("its counts are larger than those of any run")]
    Counts,
}

/// Every error of the engine.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is out of its domain.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A value or derivative of an input is refused.
    #[error("input {name}: {error}")]
    Input {
        /// Name of the input.
        name: &'static str,
        /// The reason why it is refused.
        #[source]
        error: InputError,
    },
    /// The instant to advance to is in the past, or is not finite.
    #[error("cannot advance from t = {} s to t = {} s", DisplayNumber(*.from), DisplayNumber(*.to))]
    Backwards {
        /// Present time, s.
        from: f64,
        /// The instant to advance to, s.
        to: f64,
    },
    /// A joint of the drill string is pulled apart at the start of the scene.
    #[error("{tie} of the drill string is pulled apart by {} N at the start: raise feed_force until it is pressed, or set {} = 0, which holds it both ways", DisplayNumber(-*.force), .tie.travel_name())]
    TiePulled {
        /// The tie.
        tie: Tie,
        /// The force that presses on the tie, N; it is negative.
        force: f64,
    },
    /// The piston, which nothing stopped, is at a position where a chamber has no volume left.
    #[error("the air cannot be solved beyond t = {} s, where the piston is at relative_position = {} m: the drive chamber has volume above {} m (air.cylinder, air.drive.dead_volume), the return chamber below {} m (air.return.dead_volume, and by contact.stiffness how far the contact gives); {}", DisplayNumber(*.time), DisplayNumber(*.place), DisplayNumber(.range[0]), DisplayNumber(.range[1]), VENTING)]
    Air {
        /// The instant, s.
        time: f64,
        /// The piston's relative position at that instant, m.
        place: f64,
        /// Least and largest position at which both chambers have volume, m.
        range: [f64; 2],
    },
    /// The pressure of supply or exhaust falls to zero because of the rates that were set with it.
    #[error("{name} falls to zero at t = {} s, by the rates that it was set with: an absolute pressure is above 0", DisplayNumber(*.time))]
    Vacuum {
        /// The instant, s.
        time: f64,
        /// Name of the input.
        name: &'static str,
    },
    /// Zeno behaviour: the mode changes without end at one instant.
    #[error("{transitions} changes of mode at t = {} s, without end; the last was from ({from}) to ({to})", DisplayNumber(*.time))]
    Chattering {
        /// The instant, s.
        time: f64,
        /// Number of transitions.
        transitions: u32,
        /// The mode before the last transition.
        from: Mode,
        /// The mode after the last transition.
        to: Mode,
    },
    /// The scene needs too much work: its frequencies or the rates of its events are far beyond those of any hammer.
    #[error(
        "the call takes too much work at t = {} s: {limit} ({mode}){}{}",
        DisplayNumber(*.time), hint(.suspect.as_ref()),
        .work_limit.map_or_else(String::new, |limit| format!("; work_limit = {limit} ends it"))
    )]
    Overwork {
        /// The instant, s.
        time: f64,
        /// The kind of work that exceeded its limit.
        #[source]
        limit: WorkLimit,
        /// The mode at that instant.
        mode: Mode,
        /// The parameter that is most out of proportion, if any is.
        suspect: Option<Suspect>,
        /// The parameter `work_limit`, if that limit was reached.
        work_limit: Option<usize>,
    },
    /// An [`Interrupt`](crate::Interrupt) ended the work. The machine is at the last event of the step or, if there was
    /// none, at its start, and can continue.
    #[error("cancelled before it was done")]
    Cancelled,
    /// The computer has too little memory for the scene.
    #[error(
        "{elements} (degree {degree}) need up to {:.0} MB, which the system does not have: use a coarser \
         mesh", *.bytes as f64 / 1e6
    )]
    OutOfMemory {
        /// The number of elements of each elastic body, in words.
        elements: String,
        /// Degree of the mesh.
        degree: usize,
        /// The memory that is needed.
        bytes: usize,
    },
    /// The free modes of a stepped body could not be computed to working accuracy.
    #[error(
        "the natural modes of the {body} cannot be computed: its sections differ too much in length or area"
    )]
    Modes {
        /// Name of the body.
        body: &'static str,
    },
    /// The eigenvalues of a system could not be computed to working accuracy.
    #[error("the modes of the hammer with {mode} cannot be computed: {error}{}", hint(.suspect.as_ref()))]
    Spectrum {
        /// The mode whose linear system cannot be decomposed.
        mode: Mode,
        /// The reason.
        #[source]
        error: SpectrumError,
        /// The parameter that is most out of proportion, if any is.
        suspect: Option<Suspect>,
    },
    /// A stored state belongs to a scene with other bodies or meshes.
    #[error("the stored state is that of another hammer: its bodies or meshes differ")]
    Foreign,
    /// A stored state is corrupt.
    #[error("the stored state is damaged: {what}")]
    Corrupt {
        /// The defect of the state.
        #[source]
        what: CorruptState,
    },
    /// A number of the state overflowed.
    #[error("the motion has grown beyond all numbers at t = {} s", DisplayNumber(*.time))]
    NotFinite {
        /// The instant, s.
        time: f64,
    },
}

impl Error {
    /// Returns an error if the work is interrupted.
    pub(crate) fn if_interrupted() -> Result<(), Self> {
        if interrupt::is_set() { Err(Self::Cancelled) } else { Ok(()) }
    }

    /// Adds the parameter that is most out of proportion, if this error is that of a system that cannot be decomposed.
    pub(crate) fn suspecting(mut self, parameter: Option<Suspect>) -> Self {
        if let Self::Spectrum { suspect, .. } = &mut self {
            *suspect = parameter;
        }
        self
    }

    /// The error of a refused value of this input.
    pub(crate) fn of_input(input: Input) -> impl Fn(InputError) -> Self {
        move |error| Self::Input { name: input.name(), error }
    }
}

fn hint(suspect: Option<&Suspect>) -> String {
    suspect.map_or_else(String::new, |suspect| format!("; {suspect}"))
}
