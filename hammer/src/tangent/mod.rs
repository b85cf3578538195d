//! Derivatives of the motion, exact through every event.
//!
//! A [`Tangents`] walks with a [`crate::Machine`] and carries, for each [`Seed`], the
//! derivative of the whole state at a fixed time:
//!
//! ```text
//! along a stretch   (dx)' = A dx + dA x + df            in closed form (see `response`)
//! at an event       d tau = -(g_x dx + g_p) / g'        guard g, slope g' before the event
//!                   dx+   = R_x dx- + R_p + (R_x f- + R_t - f+) d tau
//! ```
//!
//! Positions and velocities are continuous at every event of the hammer, and the elastic
//! forces too: only the dashpot at the rock and the relay make `f` jump. What the rock
//! remembers changes by explicit formulas, whose derivatives are taken.
//!
//! A derivative through an event that only grazes its guard, or through two events at one
//! instant whose order a change would turn, holds on one side at most: such a place is
//! noted as a [`Caution`], never passed in silence. [`Tangents::reach`] says for how large a
//! change of the parameter the order of events stays what it is, to first order.
//!
//! The derivative of the ledger (`spent`) and of the largest forces of a step (`summit`) is carried
//! for who asks for it: [`Tangents::with_ledger`], [`Tangents::with_peaks`].
//!
//! Nothing of this costs anything for a machine that nobody follows.

mod change;
mod event;
mod follow;
mod keeper;
pub(crate) mod leg;
pub(crate) mod line;
mod look;
mod reshape;
pub(crate) mod response;
mod seed;
mod spent;
mod start;
mod statics;
mod summit;
mod variation;
mod varying;
mod viscous;
mod walk;
mod weave;

pub use event::{Caution, Doubt};
pub use follow::{TangentState, Tangents};
pub use keeper::advance_from;
pub use line::Strike;
pub use look::{Derivative, Motions};
pub use seed::{Dimension, Ordinal, Parameter, Seed};
