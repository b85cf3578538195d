//! Derivatives of any result of a run, as differences of exact runs.
//!
//! The relative error of a run's numbers is about 2e-13, and a run repeats to the last binary digit, so differences
//! have 7 to 9 digits.
//! Each derivative needs two runs besides the one at `x`, and has an error estimate. With the slope `a` from `x-h` to
//! `x` and the slope `b` from `x` to `x+h`,
//!
//! ```text
//! f'(x) = (f(x+h) - f(x-h)) / 2h
//! error = (b - a)^2 / 2 |f'| + 2e-13 |f| / h          truncation with one length scale, and rounding
//! ```
//!
//! If the error is more than a millionth of the derivative, a third run, at `x + 2h`, gives the error of the central
//! difference, `d = (f(x+2h) - 3 f(x+h) + 3 f(x) - f(x-h)) / 6h`. It is subtracted, and its size is the new error.
//! If that is still too large and is not rounding, a step of `h/8` is tried too.
//!
//! The rounding error of a number that is a small difference of large ones (such as the gap between two bodies) is
//! larger than its size suggests. The error estimate includes this.
//!
//! In these runs `air.error` is at most 1e-11, even if the scene has a larger one.
//!
//! The response is piecewise smooth. All runs must have the same events in the same order; otherwise the step shrinks
//! until rounding dominates.
//! If the events still differ, `x` is a *non-smooth point*. The result then gives the reason ([`NonSmooth`]) and both
//! one-sided derivatives.

mod argument;
mod differences;
mod sample;
mod step;

pub use argument::Argument;
pub use differences::{Derivative, NonSmooth, derivatives};
pub use sample::{Change, Sample};
pub use step::over_step;
