//! Residual of a block: how far it is from an invariant pair.

use crate::modal::block::Block;
use crate::modal::deflation::Deflated;
use crate::numerics::kernel::inner_product as dot;
use crate::numerics::matrix2::Matrix2;

/// Errors of a block in the equation of motion, relative to the block's own terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Defect {
    /// Residual of the equation.
    pub(crate) found: f64,
    /// The same, plus the rounding of the block's own terms.
    pub(crate) possible: f64,
    /// Rounding of the equation's terms: differences of large numbers, and the force of a stiff
    /// spring in a slow mode, which is nearly zero.
    pub(crate) rounding: f64,
}

/// The residual `R = K V + C V B + V B^2` of a block `(V, B)` in the dual basis, relative to `B`;
/// and the same plus its possible rounding. Two vectors from one row may be nearly parallel (two
/// uncoupled modes need both rows), and a mean and a difference may be lost to rounding: the
/// residual decides between them.
pub(crate) fn defect(system: &Deflated, block: &Block) -> Defect {
    let b = &block.b;
    let v = block.shapes.each_ref().map(|shape| system.merged(shape));
    let rate = times(&v, b);
    let mut residual = times(&rate, b);
    // The dashpots' part of the bilinear form.
    let mut dashpots = [0.0; 3];
    for (shape, (k, damping)) in system.shapes.iter().zip(&system.springs) {
        let moved = v.each_ref().map(|v| dot(shape, v));
        let speed = [moved[0] * b[0] + moved[1] * b[2], moved[0] * b[1] + moved[1] * b[3]];
        for c in 0..2 {
            let force = k * moved[c] + damping * speed[c];
            residual[c].iter_mut().zip(shape).for_each(|(r, x)| *r += force * x);
        }
        dashpots[0] += damping * moved[0] * moved[0];
        dashpots[1] += damping * moved[0] * moved[1];
        dashpots[2] += damping * moved[1] * moved[1];
    }
    let strained = v.each_ref().map(|v| -> Vec<f64> {
        v.iter().zip(&system.omega2).map(|(x, w2)| system.beta * w2 * x).collect()
    });
    for c in 0..2 {
        let bars = system.omega2.iter().zip(&v[c]).zip(&rate[c]);
        for (r, ((w2, x), y)) in residual[c].iter_mut().zip(bars) {
            *r += w2 * (x + system.beta * y);
        }
    }
    // The bilinear form `x . C y + x' . y + x . y'` of shapes and their rates.
    let form = |c: usize, d: usize| {
        dot(&rate[c], &v[d]) + dot(&v[c], &rate[d]) + dot(&strained[c], &v[d]) + dashpots[c + d]
    };
    let (g11, g12, g22) = (form(0, 0), form(0, 1), form(1, 1));
    let scale = block.rate[0].max(block.rate[1]);
    let size = v.each_ref().map(|x| dot(x, x).sqrt());
    // The rounding of the residual's terms remains even where the terms cancel.
    let noise =
        |c: usize| f64::EPSILON * scale * (scale * size[c] + dot(&rate[c], &rate[c]).sqrt());
    let spread = size[0] * (g22.abs() + g12.abs()) + size[1] * (g12.abs() + g11.abs());
    let factor = spread / ((g11 * g22 - g12 * g12).abs() * scale);
    let sum = |of: &dyn Fn(usize) -> f64| {
        let sum = factor * (of(0) + of(1));
        if sum.is_nan() { f64::INFINITY } else { sum }
    };
    let rounding = |c: usize| f64::EPSILON * terms(system, &v[c], &rate[c]);
    let left = |c: usize| dot(&residual[c], &residual[c]).sqrt();
    let possible = sum(&|c| left(c) + noise(c));
    Defect { found: sum(&left), possible, rounding: sum(&rounding) }
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
