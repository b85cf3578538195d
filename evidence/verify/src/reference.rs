//! The hammer whose solutions in double-double arithmetic the crate `oracles` stores.

use hammer::presets::Preset;
use hammer::{Machine, Parameters};
use oracles::law::State;

/// The reference hammer in very viscous rock, on linear elements.
///
/// # Panics
/// Never: the preset exists.
pub fn overdamped() -> Parameters {
    Preset::named("overdamped").expect("a preset").start().0
}

/// The hammer with stored solutions, with so many linear elements in each bar. The oracles have no other stored
/// solutions.
pub fn hammer(elements: usize) -> Parameters {
    let mut p = overdamped();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p
}

/// Nodes of both bodies, top to bottom.
pub fn nodal(machine: &Machine) -> State<f64> {
    let profile = machine.profile();
    let (u, v) = profile.piston.iter().chain(&profile.bit).map(|[u, v]| (*u, *v)).unzip();
    State { u, v, psi: machine.viscous_work_of_cycle() }
}
