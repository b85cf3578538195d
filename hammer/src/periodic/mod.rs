//! The stationary cycle as a solved equation.
//!
//! The return map `P` leads from a section to the next: from just after the relay turned to
//! driving to the next such turn (the `laps`-th next), or over one period of a drive that is
//! given over time. Positions are measured from the rock line, so that the drift of the hole
//! is out of it. The cycle is the fixed point
//!
//! ```text
//! x = P(x; p),        dx/dp = (I - P_x)^-1 P_p,        multipliers: eigenvalues of P_x
//! ```
//!
//! found by Newton's method. `P_x` is never formed: waves die within a cycle, so few of its
//! multipliers differ from zero, and a handful of Krylov vectors ([`krylov`]) suffices, each
//! a tangent ([`crate::tangent`]) carried once along the taped lap. Where Newton does not help,
//! the map itself is the fallback; orbits that do not attract are found from a start nearby.

mod branch;
mod eigen;
mod fault;
mod krylov;
mod lap;
mod newton;
mod point;

pub use branch::{Branch, Waypoint};
pub use fault::CycleError;
pub use lap::{Piece, Schedule};
pub use newton::{Cycle, Gradient, Orbit, Search, stationary};
