//! Derivatives of anything that a run returns, as differences of exact runs.
//!
//! A run is exact to about 1e-13 of its numbers and repeats to the last bit, so differences have 7
//! to 9 digits. Each derivative needs two runs besides the one at `x`, and has an error estimate:
//!
//! ```text
//! f'(x) = (f(x+h) - f(x-h)) / 2h          slopes below and above: a, b
//! error = (b - a)^2 / 2 |f'| + 1e-13 |f| / h          curvature of one scale, and rounding
//! ```
//!
//! If that is more than a millionth of the derivative, a third run, at `x + 2h`, gives the error of
//! the central difference, `d = (f(x+2h) - 3 f(x+h) + 3 f(x) - f(x-h)) / 6h`. It is subtracted, and
//! its size is the new error. If that is still too large and is not noise, a step of an eighth is
//! tried too.
//!
//! A number that is a small difference of large ones (the gap between two bodies) is rounded by
//! more than its own size suggests; its error is that much larger.
//!
//! Air is solved to 1e-11 at most in these runs, whatever `air.error` asks of others, and they are exact to that.
//!
//! The response is piecewise smooth. All runs must pass the same events in the same order;
//! otherwise the step shrinks until rounding dominates. If the events still differ, `x` is a
//! *non-smooth point*: it is named ([`NonSmooth`]), and both one-sided derivatives are returned.

mod argument;
mod differences;
mod sample;
mod step;

pub use argument::Argument;
pub use differences::{Derivative, NonSmooth, derivatives};
pub use sample::{Change, Sample};
pub use step::over_step;
