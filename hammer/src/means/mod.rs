//! The long-run response of a hammer: a motion that repeats, or means over blows with their errors.

mod averages;
mod steady;

pub use averages::{Averages, Means, NUMBERS, Numbers};
pub use steady::{Kind, MOST_REPEATING, Steady, Wanted, steady};
