//! Derivatives of anything that a run gives, as differences of exact runs.
//!
//! A run is exact to some 1e-13 of its numbers and repeats to the last bit, so differences of runs
//! have 7 to 9 digits. Each derivative takes two runs besides the one at `x`, and comes with its
//! error:
//!
//! ```text
//! f'(x) = (f(x+h) - f(x-h)) / 2h          slopes below and above: a, b
//! error = (b - a)^2 / 2 |f'| + 1e-13 |f| / h          curvature of one scale, and rounding
//! ```
//!
//! Where that is more than a millionth of the derivative a third run, at `x + 2h`, tells what the
//! central difference lacks, `d = (f(x+2h) - 3 f(x+h) + 3 f(x) - f(x-h)) / 6h`: it is taken off, and
//! is the error. If it is still too much, and is no noise, an eighth of the step is tried too.
//!
//! A number that is a small difference of large ones, a gap of the places of two bodies, is rounded
//! by more than its own size tells; its error is that much larger.
//!
//! The response is piecewise smooth. All runs must pass the same events in the same order;
//! where they do not, the step shrinks down to where rounding takes over. If the events still
//! differ, `x` is a *non-smooth point*: it is named ([`NonSmooth`]), and the derivatives on both
//! sides are given.

mod argument;
mod differences;
mod sample;
mod step;

pub use argument::{Argument, Scene};
pub use differences::{Derivative, NonSmooth, derivatives};
pub(crate) use differences::{differentiate, reach};
pub use sample::{Change, Sample};
pub use step::over_step;
