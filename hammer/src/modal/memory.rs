//! Checks that the system has the memory that a scene may need, before the work begins. Otherwise a
//! host with a memory limit would be aborted during the run. The memory is allocated for a test and
//! freed at once.

use crate::error::Error;
use crate::modal::shared;
use crate::modal::system::System;
use crate::numerics::kernel::LANES;
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;

/// Numbers stored between reads of the energies and the peaks, bytes.
const STRETCHES: usize = 1 << 24;
/// Matrices that a dense solver needs at the same time.
const DENSE: usize = 12;

/// Modes of a body: one if it is rigid, otherwise as many as its splines have functions.
fn modes(p: &Parameters, body: Body) -> usize {
    let sections = p.sections(body).as_slice().len();
    if !p.is_elastic(body) {
        return 1;
    }
    let joints = if body == Body::Bit { p.drill.joints() } else { 0 };
    p.spans(body) + sections * (p.mesh.degree - 1) + 1 + joints
}

/// Bytes of the dense solution of the bodies' modes, of every system that the hammer can reach
/// with its tables and forms, and of the work space to decompose the largest.
fn needed(p: &Parameters) -> usize {
    let [piston, bit] = Body::ALL.map(|body| modes(p, body));
    let casing = if p.has_casing() { modes(p, Body::Casing) } else { 0 };
    let (both, more) = (piston + bit, 4);
    let springs = 4;
    let mut systems = System::room(piston, 2)
        + springs * (System::room(bit, more + 1) + System::room(both, more + 2));
    if p.has_casing() {
        let [lower, all] = [bit + casing, both + casing];
        systems += System::room(casing, 4)
            + springs * (System::room(lower, more + 5) + System::room(all, more + 6));
    }
    if p.drill.joints() > 0 {
        systems += shared::BUDGET;
    }
    let one = piston.max(bit).max(casing);
    // Shapes, and the fields at the quadrature's points.
    let shapes = 2 * (piston * piston + bit * bit + casing * casing)
        + (DENSE + 2 * (p.mesh.degree + 1)) * one * one;
    let len = 2 * (both + casing).next_multiple_of(LANES);
    systems + size_of::<f64>() * (shapes + 2 * len * len) + STRETCHES
}

/// Tests whether the memory that a scene may need is available.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub(crate) fn reserve(p: &Parameters) -> Result<(), Error> {
    let bytes = needed(p);
    let casing = if p.is_elastic(Body::Casing) { p.spans(Body::Casing) } else { 0 };
    let elements = [p.spans(Body::Piston), p.spans(Body::Bit), casing];
    let refused = |_| Error::OutOfMemory { elements, degree: p.mesh.degree, bytes };
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(refused)
}
