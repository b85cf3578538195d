//! The long-run response of a hammer: a motion that repeats, or means over blows with their errors.

mod averages;
mod steady;

pub use averages::{Averages, Means};
pub use steady::{Kind, MOST_REPEATING, Simulation, Steady, Waiting, Wanted, steady, steady_of};
