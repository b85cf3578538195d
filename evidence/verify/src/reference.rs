//! The hammer whose solution in double-double arithmetic the crate `oracles` stores.

use hammer::Parameters;
use hammer::presets::Preset;

/// The reference hammer in very viscous rock, with so many linear elements per bar.
///
/// # Panics
/// Never: the preset exists.
pub fn overdamped(elements: usize) -> Parameters {
    let mut p = Preset::named("overdamped").expect("a preset").start().parameters;
    (p.piston.elements, p.bit.elements) = (elements, elements);
    p
}
