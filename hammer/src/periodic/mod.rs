//! The stationary cycle as a solved equation.
//!
//! The return (Poincaré) map `P` leads from a section to the next: from just after the relay turned
//! to driving, or the drive chamber's supply opened, to the next such event (the `returns`-th
//! next), or over one period of a drive that is given over time. Positions are measured from the
//! rock line, so that the drift of the hole is out of it. The cycle is the fixed point
//!
//! ```text
//! x = P(x; p),      dx/dp = (I - P_x)^-1 P_p,      Floquet multipliers: eigenvalues of P_x
//! ```
//!
//! found by Newton's method. `P_x` is never formed: waves die within a cycle, so few of its
//! multipliers differ from zero, and a handful of Krylov vectors ([`krylov`]) suffices, each a
//! central difference of the map. `P_p` are [`differences`](crate::sensitivity) of the map, too.
//! Where Newton's method does not help, the map itself is the fallback; orbits that do not attract
//! are found from a start nearby, and [`Cycle::is_stable`] tells them.

mod averages;
mod branch;
mod eigen;
mod error;
mod find;
mod krylov;
mod point;
mod response;
mod return_map;
mod steady;

pub use averages::{Averages, Means, NUMBERS, Numbers};
pub use branch::{Branch, BranchPoint};
pub use error::CycleError;
pub use find::{Cycle, Gradient, Orbit, Search, find};
pub use num_complex::Complex64;
pub use response::{Response, Strike};
pub use return_map::{Piece, Schedule};
pub use steady::{Kind, MOST_RETURNS, Steady, Wanted, steady};
