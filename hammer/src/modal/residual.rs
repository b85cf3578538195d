//! How far a block is from an invariant pair.

use crate::modal::block::Block;
use crate::modal::deflation::Deflated;
use crate::numerics::kernel::inner_product as dot;

/// How far a block is from one that solves the equation of motion, over its own terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Defect {
    /// What is left of the equation.
    pub(crate) seen: f64,
    /// With what rounding hides of the block's own terms.
    pub(crate) possible: f64,
    /// What rounding leaves of the equation's terms: a stiff spring's force on a slow mode is
    /// none, and a difference of large numbers.
    pub(crate) rounding: f64,
}

/// The residual `R = K V + C V B + V B^2` of a block `(V, B)`, as the dual basis would see
/// it, over `B`; and the same with what rounding may have left of it, though it is not seen. Two
/// vectors of one row may be nearly parallel (two modes that do not feel
/// each other need both rows), and a mean and a difference may be lost to rounding:
/// whichever road it was, this tells.
pub(crate) fn defect(system: &Deflated, block: &Block) -> Defect {
    let b = &block.b;
    let merged = |v: &[f64]| -> Vec<f64> {
        let amplitude = |m: &Vec<(usize, f64)>| m.iter().map(|&(h, w)| w * v[h]).sum();
        system.members.iter().map(amplitude).collect()
    };
    let times = |v: &[Vec<f64>; 2]| -> [Vec<f64>; 2] {
        let mix = |p: f64, q: f64| v[0].iter().zip(&v[1]).map(|(x, y)| p * x + q * y).collect();
        [mix(b[0], b[2]), mix(b[1], b[3])]
    };
    let v = [merged(&block.shapes[0]), merged(&block.shapes[1])];
    let rate = times(&v);
    let mut residual = times(&rate);
    let mut gram = [[0.0; 2]; 2];
    for c in 0..2 {
        for (i, w2) in system.omega2.iter().enumerate() {
            residual[c][i] += w2 * (v[c][i] + system.beta * rate[c][i]);
        }
        for (shape, (k, damping)) in system.shapes.iter().zip(&system.springs) {
            let force = k * dot(shape, &v[c]) + damping * dot(shape, &rate[c]);
            residual[c].iter_mut().zip(shape).for_each(|(r, x)| *r += force * x);
        }
        for d in 0..2 {
            gram[c][d] = form(system, [&v[c], &rate[c]], [&v[d], &rate[d]]);
        }
    }
    let scale = block.rate[0].max(block.rate[1]);
    let [[g11, g12], [g21, g22]] = gram;
    let inverse = [[g22, g12], [g21, g11]].map(|row| row.map(f64::abs));
    let size = [&v[0], &v[1]].map(|x| dot(x, x).sqrt());
    // What rounding leaves of the residual's terms is there even where they cancel.
    let noise =
        |c: usize| f64::EPSILON * scale * (scale * size[c] + dot(&rate[c], &rate[c]).sqrt());
    let spread =
        size[0] * (inverse[0][0] + inverse[1][0]) + size[1] * (inverse[0][1] + inverse[1][1]);
    let factor = spread / ((g11 * g22 - g12 * g21).abs() * scale);
    let sum = |of: &dyn Fn(usize) -> f64| {
        let sum = factor * (of(0) + of(1));
        if sum.is_nan() { f64::INFINITY } else { sum }
    };
    let rounding = |c: usize| f64::EPSILON * terms(system, &v[c], &rate[c]);
    let left = |c: usize| dot(&residual[c], &residual[c]).sqrt();
    let possible = sum(&|c| left(c) + noise(c));
    Defect { seen: sum(&left), possible, rounding: sum(&rounding) }
}

/// Size of the forces of a shape and its rate, before they cancel.
fn terms(system: &Deflated, shape: &[f64], rate: &[f64]) -> f64 {
    let of = |(w2, (x, y)): (&f64, (&f64, &f64))| w2 * (x.abs() + system.beta * y.abs());
    let bars: f64 = system.omega2.iter().zip(shape.iter().zip(rate)).map(of).sum();
    let attached = system.shapes.iter().zip(&system.springs).map(|(at, (k, c))| {
        let moved = |x: &[f64]| at.iter().zip(x).map(|(a, x)| (a * x).abs()).sum::<f64>();
        (k * moved(shape) + c * moved(rate)) * dot(at, at).sqrt()
    });
    bars + attached.sum::<f64>()
}

/// The bilinear form `x . C y + x' . y + x . y'` of two shapes and their rates.
fn form(system: &Deflated, x: [&Vec<f64>; 2], y: [&Vec<f64>; 2]) -> f64 {
    let mut sum = dot(x[1], y[0]) + dot(x[0], y[1]);
    for (i, w2) in system.omega2.iter().enumerate() {
        sum += system.beta * w2 * x[0][i] * y[0][i];
    }
    for (shape, (_, c)) in system.shapes.iter().zip(&system.springs) {
        sum += c * dot(shape, x[0]) * dot(shape, y[0]);
    }
    sum
}
