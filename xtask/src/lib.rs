//! What the project's commands share: the Python environment, and running other programs.

pub mod python;
pub mod run;
