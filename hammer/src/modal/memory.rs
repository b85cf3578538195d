//! Checks that the system has the memory that a scene may need, before the work begins. Otherwise a host with a memory
//! limit would be aborted during the run. The memory is allocated for a test and freed at once.

use crate::error::Error;
use crate::modal::shared;
use crate::modal::system::System;
use crate::numerics::kernel::LANES;
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;

/// Bytes for the motion that is stored until energies and peaks are read.
const STRETCHES: usize = 1 << 24;
/// Matrices that a dense solver needs at the same time.
const DENSE: usize = 12;

/// Modes of a body: one if it is rigid, otherwise as many as its splines have functions.
fn modes(p: &Parameters, body: Body) -> usize {
    let sections = p.sections(body).as_slice().len();
    if !p.is_elastic(body) {
        return 1;
    }
    let cuts = if body == Body::Bit { p.drill.loose() } else { 0 };
    p.spans(body) + sections * (p.mesh.degree - 1) + 1 + cuts
}

/// Bytes of the dense solution of the bodies' modes, of every system that the hammer can reach
/// with its tables and forms, and of the work space to decompose the largest.
fn needed(p: &Parameters) -> usize {
    let each: Vec<usize> = p.bodies().map(|body| modes(p, body)).collect();
    // Piston and bit alone, together, and with the other bodies.
    let (both, all) = (each[0] + each[1], each.iter().sum::<usize>());
    let (springs, shares) = (4, if each.len() > 2 { 10 } else { 6 });
    let mut systems = System::room(each[0], 2)
        + springs * (System::room(each[1], shares) + System::room(both, shares));
    for beside in each.iter().skip(2) {
        systems += System::room(*beside, 4)
            + springs * (System::room(each[1] + beside, shares) + System::room(all, shares));
    }
    if p.drill.loose() > 0 {
        systems += shared::BUDGET;
    }
    let one = each.iter().fold(0, |most, modes| most.max(*modes));
    // Shapes, and the fields at the quadrature's points.
    let shapes = 2 * each.iter().map(|modes| modes * modes).sum::<usize>()
        + (DENSE + 2 * (p.mesh.degree + 1)) * one * one;
    let len = 2 * all.next_multiple_of(LANES);
    systems + size_of::<f64>() * (shapes + 2 * len * len) + STRETCHES
}

/// Tests whether the memory that a scene may need is available.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub(crate) fn reserve(p: &Parameters) -> Result<(), Error> {
    let bytes = needed(p);
    let elastic = p.bodies().filter(|body| p.is_elastic(*body));
    let elements = elastic.map(|body| format!("{} elements of the {}", p.spans(body), body.name()));
    let elements = elements.collect::<Vec<_>>().join(", ");
    let refused = |_| Error::OutOfMemory { elements, degree: p.mesh.degree, bytes };
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(refused)
}
