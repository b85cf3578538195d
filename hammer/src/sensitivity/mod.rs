//! Derivatives of anything that a run returns, as differences of exact runs.
//!
//! A run is exact to about 1e-13 of its numbers and repeats to the last bit, so differences have 7 to 9 digits. Each
//! derivative needs two runs besides the one at `x`, and has an error estimate:
//!
//! ```text
//! f'(x) = (f(x+h) - f(x-h)) / 2h          slopes below and above: a, b
//! error = (b - a)^2 / 2 |f'| + 1e-13 |f| / h          for one length scale, and rounding
//! ```
//!
//! If that is more than a millionth of the derivative, a third run, at `x + 2h`, gives the error of the central
//! difference, `d = (f(x+2h) - 3 f(x+h) + 3 f(x) - f(x-h)) / 6h`. It is subtracted, and its size is the new error. If
//! that is still too large and is not noise, a step of an eighth is tried too.
//!
//! The rounding of a number that is a small difference of large ones (the gap between two bodies) is larger than its
//! size suggests; this is included in its error.
//!
//! In these runs `air.error` is at most 1e-11, whatever the scene has.
//!
//! The response is piecewise smooth. All runs must have the same events in the same order; otherwise the step shrinks
//! until rounding dominates. If the events still differ, `x` is a *non-smooth point*. The result then names the
//! reason ([`NonSmooth`]), and has both one-sided derivatives.

mod argument;
mod differences;
mod sample;
mod step;

pub use argument::Argument;
pub use differences::{Derivative, NonSmooth, derivatives};
pub use sample::{Change, Sample};
pub use step::over_step;
