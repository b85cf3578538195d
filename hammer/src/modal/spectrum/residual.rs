//! Residual of a block: how far it is from an invariant pair.

use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::states::{damped, strained};
use crate::numerics::kernel::{inner_product as dot, norm as size};
use crate::numerics::matrix2::Matrix2;

/// True if the residual `R = K V + C V B + V B^2` of a block `(V, B)` in the dual basis, relative to `B`, is
/// beyond `limit` and the rounding of the equation's terms: differences of large numbers, and the force of a
/// stiff spring in a slow mode, which is nearly zero.
pub(crate) fn misses(system: &Deflated, block: &Block, limit: f64) -> bool {
    let v = block.shapes.each_ref().map(|shape| system.merged(shape));
    let rate = times(&v, &block.b);
    let mut left = times(&rate, &block.b);
    for (c, left) in left.iter_mut().enumerate() {
        let forces = strained(system, &v[c]).into_iter().zip(damped(system, &rate[c]));
        left.iter_mut().zip(forces).for_each(|(r, (k, d))| *r += k + d);
    }
    // The bilinear form `x . C y + x' . y + x . y'` of shapes and their rates.
    let braked = v.each_ref().map(|v| damped(system, v));
    let form =
        |c: usize, d: usize| dot(&rate[c], &v[d]) + dot(&v[c], &rate[d]) + dot(&braked[c], &v[d]);
    let (g11, g12, g22) = (form(0, 0), form(0, 1), form(1, 1));
    let sizes = v.each_ref().map(|v| size(v));
    let spread = sizes[0] * (g22.abs() + g12.abs()) + sizes[1] * (g12.abs() + g11.abs());
    let scale = block.rate[0].max(block.rate[1]);
    // From the dual basis to the block's own terms.
    let factor = spread / ((g11 * g22 - g12 * g12).abs() * scale);
    let sum = |of: [f64; 2]| {
        let sum = factor * (of[0] + of[1]);
        if sum.is_nan() { f64::INFINITY } else { sum }
    };
    let found = sum(left.each_ref().map(|left| size(left)));
    // Few blocks come to the second question, which takes as long as the first.
    found > limit && {
        let rounding = sum([0, 1].map(|c| f64::EPSILON * terms(system, &v[c], &rate[c])));
        found > limit + 16.0 * rounding
    }
}

/// `V B`.
fn times(v: &[Vec<f64>; 2], b: &Matrix2) -> [Vec<f64>; 2] {
    let mix = |p: f64, q: f64| v[0].iter().zip(&v[1]).map(|(x, y)| p * x + q * y).collect();
    [mix(b[0], b[2]), mix(b[1], b[3])]
}

/// Size of the forces of a shape and its rate, before they cancel.
fn terms(system: &Deflated, shape: &[f64], rate: &[f64]) -> f64 {
    let [shape, rate] = [shape, rate].map(|x| x.iter().map(|x| x.abs()).collect::<Vec<f64>>());
    let bars: Vec<f64> = shape.iter().zip(&rate).map(|(x, y)| x + system.beta * y).collect();
    let attached = system
        .sizes
        .iter()
        .zip(&system.springs)
        .map(|((at, size), (k, c))| (k * dot(at, &shape) + c * dot(at, &rate)) * size);
    dot(&system.omega2, &bars) + attached.sum::<f64>()
}
