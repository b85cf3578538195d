//! Why there is no cycle.

use crate::error::Error;
use thiserror::Error;

/// Why there is no cycle.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CycleError {
    /// The scene itself fails.
    #[error(transparent)]
    Engine(#[from] Error),
    /// A drive that is given over time needs to be told what it repeats.
    #[error(
        "drive.source is Force or Pressure: give the inputs over one period, which a cycle needs"
    )]
    NoSchedule,
    /// A relay or air has their own period.
    #[error("drive.source is Relay or Air, with a period of its own: give no inputs over a period")]
    NotScheduled,
    /// A schedule that is not in order.
    #[error("the inputs over the period must be in order of time, between 0 and {period} s")]
    Disordered {
        /// s.
        period: f64,
    },
    /// The motion does not come back to the section.
    #[error("no cycle begins: the drive has not turned to driving, or opened its supply, for {after} s{}", if *stalled { ": the piston rests on the bit" } else { "" })]
    NoReturn {
        /// s.
        after: f64,
        /// See [`Machine::stalled`](crate::Machine::stalled).
        stalled: bool,
    },
    /// A parameter that is zero has no size to measure a way along it by.
    #[error(
        "no branch can begin at {value}: its steps are parts of the start value, which must not be 0"
    )]
    NoScale {
        /// Its value.
        value: f64,
    },
    /// The return map jumps, or its cycle ends; or the branch bends more tightly than one looks.
    #[error(
        "the branch of cycles ends at {value}: the return map jumps there, or the branch turns more \
         sharply than steps of {step:e} of the start value can follow"
    )]
    Edge {
        /// The parameter's last value.
        value: f64,
        /// The shortest stride that was tried, over the parameter's start value.
        step: f64,
    },
    /// The linear equations of a branch's tangent have no solution that is good enough.
    #[error("the direction of the branch of cycles cannot be computed at {value}")]
    NoTangent {
        /// The parameter's value.
        value: f64,
    },
    /// Neither Newton's method nor the map comes near enough.
    #[error(
        "no cycle of {returns} returns found: after {steps} steps the return map still moves the state by {distance:e}"
    )]
    NotFound {
        /// Returns of the map that it was to close after.
        returns: usize,
        /// Steps made.
        steps: usize,
        /// What is left.
        distance: f64,
    },
}
