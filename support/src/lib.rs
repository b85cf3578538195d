//! Code that the project's commands share: the Python environment, and running other programs.

#![forbid(unsafe_code)]

pub mod python;
pub mod run;
pub mod toolchain;
