//! A scene: parameters and inputs, and the graph of bodies and ties that follows from them.

pub mod graph;

use crate::quantities::parameters::{InputValues, Parameters};

/// A scene: parameters and constant inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scene {
    /// Parameters of bodies, laws and drive.
    pub parameters: Parameters,
    /// Inputs, which stay constant.
    pub inputs: InputValues,
}
