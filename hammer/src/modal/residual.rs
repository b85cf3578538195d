//! How far a block is from an invariant pair.

use crate::modal::block::Block;
use crate::modal::deflation::Deflated;
use crate::numerics::kernel::inner_product as dot;

/// The residual `R = K V + C V B + V B^2` of a block `(V, B)`, as the dual basis would see
/// it, over `B`. Two vectors of one row may be nearly parallel (two modes that do not feel
/// each other need both rows), and a mean and a difference may be lost to rounding:
/// whichever road it was, this tells.
pub(crate) fn defect(system: &Deflated, block: &Block) -> f64 {
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
    let seen = [0, 1].map(|c| dot(&residual[c], &residual[c]).sqrt() + noise(c));
    let spread =
        size[0] * (inverse[0][0] + inverse[1][0]) + size[1] * (inverse[0][1] + inverse[1][1]);
    let defect = spread * (seen[0] + seen[1]) / ((g11 * g22 - g12 * g21).abs() * scale);
    if defect.is_nan() { f64::INFINITY } else { defect }
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
