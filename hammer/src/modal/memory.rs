//! Checks, before the work begins, that the memory that a scene may need is available. Without this check, a host with
//! a memory limit could be aborted during the run. The memory is allocated for the check and freed at once.

use crate::error::Error;
use crate::modal::shared;
use crate::modal::system::System;
use crate::numerics::kernel::LANES;
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;

/// Bytes for the motion that is stored until energies and peaks are read.
const STRETCHES: usize = 1 << 24;
/// Number of matrices that a dense solver needs at the same time.
const DENSE: usize = 12;

/// Number of modes of a body: one if it is rigid, otherwise the number of its spline functions.
fn modes(p: &Parameters, body: Body) -> usize {
    let sections = p.sections(body).as_slice().len();
    if !p.is_elastic(body) {
        return 1;
    }
    let cuts = if body == Body::Bit { p.drill.loose() } else { 0 };
    p.spans(body) + sections * (p.mesh.degree - 1) + 1 + cuts
}

/// The memory that a scene may need, bytes: for the dense solution of the bodies' modes, for every system that the
/// hammer can reach with its tables and forms, and for the decomposition of the largest system.
fn needed(p: &Parameters) -> usize {
    let counts: Vec<usize> = p.bodies().map(|body| modes(p, body)).collect();
    // The systems are those of piston and bit separately, of the two together, and of the two with the other bodies.
    let (both, all) = (counts[0] + counts[1], counts.iter().sum::<usize>());
    let (springs, shares) = (4, if counts.len() > 2 { 10 } else { 6 });
    let mut systems = System::room(counts[0], 2)
        + springs * (System::room(counts[1], shares) + System::room(both, shares));
    for other in counts.iter().skip(2) {
        systems += System::room(*other, 4)
            + springs * (System::room(counts[1] + other, shares) + System::room(all, shares));
    }
    if p.drill.loose() > 0 {
        systems += shared::BUDGET;
    }
    let largest = counts.iter().fold(0, |largest, modes| largest.max(*modes));
    // These are the mode shapes, the matrices of the dense solver, and the fields at the points of the quadrature.
    let shapes = 2 * counts.iter().map(|modes| modes * modes).sum::<usize>()
        + (DENSE + 2 * (p.mesh.degree + 1)) * largest * largest;
    let len = 2 * all.next_multiple_of(LANES);
    systems + size_of::<f64>() * (shapes + 2 * len * len) + STRETCHES
}

/// Checks that the memory that a scene may need is available.
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
