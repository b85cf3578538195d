//! The memory that a scene may need, asked for before the work begins: the system refuses then, where
//! a host that has set a limit would be aborted in the midst of it.
//!
//! What is asked for is given back at once: it is tried, not held.

use crate::error::Error;
use crate::modal::system::{CHANNELS, System};
use crate::numerics::kernel::LANES;
use crate::quantities::parameters::{Fidelity, Parameters};
use crate::quantities::sections::Body;

/// Numbers kept between looks at the energies and the peaks, bytes.
const STRETCHES: usize = 1 << 24;
/// Matrices of a dense solver at one time.
const DENSE: usize = 12;

/// Modes of a body: one if it is rigid, or the functions of its splines.
fn modes(p: &Parameters, body: Body) -> usize {
    let sections = p.sections(body).as_slice().len();
    match p.fidelity {
        Fidelity::Rigid => 1,
        Fidelity::Elastic => p.spans(body) + sections * (p.mesh.degree - 1) + 1,
    }
}

/// Bytes of numbers: the dense solution of both bodies' modes, every system that the hammer can come
/// into with its tables and forms, and room to decompose the largest.
fn needed(p: &Parameters) -> usize {
    let [piston, bit] = Body::ALL.map(|body| modes(p, body));
    let (both, more) = (piston + bit, 1 + CHANNELS);
    let springs = 4;
    let systems = System::room(piston, 2)
        + springs * (System::room(bit, more + 1) + System::room(both, more + 2));
    let one = piston.max(bit);
    // Shapes, and the fields at the quadrature's points.
    let shapes = 2 * (piston * piston + bit * bit) + (DENSE + 2 * (p.mesh.degree + 1)) * one * one;
    let len = 2 * both.next_multiple_of(LANES);
    systems + size_of::<f64>() * (shapes + 2 * len * len) + STRETCHES
}

/// Tries for the memory that a scene may need.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub(crate) fn reserve(p: &Parameters) -> Result<(), Error> {
    let bytes = needed(p);
    let elements = Body::ALL.map(|body| p.spans(body));
    let refused = |_| Error::OutOfMemory { elements, degree: p.mesh.degree, bytes };
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(refused)
}
