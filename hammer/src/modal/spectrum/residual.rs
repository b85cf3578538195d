//! Residual of a block: how far it is from an invariant pair.

use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::deflation::Deflated;
use crate::numerics::kernel::{inner_product as dot, norm as size};
use crate::numerics::matrix2::Matrix2;

/// The residual `R = K V + C V B + V B^2` of a block `(V, B)` in the dual basis, relative to `B`;
/// and the same plus its possible rounding. Two vectors from one row may be nearly parallel (two
/// uncoupled modes need both rows), and a mean and a difference may be lost to rounding: the
/// residual decides between them.
pub(crate) fn defect(system: &Deflated, block: &Block) -> f64 {
    Residual::new(system, block).possible()
}

/// True if the residual is beyond `limit` and the rounding of the equation's terms: differences of
/// large numbers, and the force of a stiff spring in a slow mode, which is nearly zero.
pub(crate) fn misses(system: &Deflated, block: &Block, limit: f64) -> bool {
    let residual = Residual::new(system, block);
    let found = residual.found();
    // Few blocks come to the second question, which takes as long as the first.
    found > limit && found > limit + 16.0 * residual.rounding()
}

/// A block in the equation of motion.
struct Residual<'a> {
    system: &'a Deflated,
    /// `V`, and `V B`.
    v: [Vec<f64>; 2],
    rate: [Vec<f64>; 2],
    /// `R`.
    left: [Vec<f64>; 2],
    scale: f64,
    /// From the dual basis to the block's own terms.
    factor: f64,
}

impl<'a> Residual<'a> {
    fn new(system: &'a Deflated, block: &Block) -> Self {
        let b = &block.b;
        let v = block.shapes.each_ref().map(|shape| system.merged(shape));
        let rate = times(&v, b);
        let mut left = times(&rate, b);
        // The dashpots' part of the bilinear form.
        let mut dashpots = [0.0; 3];
        for (shape, (k, damping)) in system.shapes.iter().zip(&system.springs) {
            let moved = v.each_ref().map(|v| dot(shape, v));
            let speed = [moved[0] * b[0] + moved[1] * b[2], moved[0] * b[1] + moved[1] * b[3]];
            for c in 0..2 {
                let force = k * moved[c] + damping * speed[c];
                left[c].iter_mut().zip(shape).for_each(|(r, x)| *r += force * x);
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
            for (r, ((w2, x), y)) in left[c].iter_mut().zip(bars) {
                *r += w2 * (x + system.beta * y);
            }
        }
        // The bilinear form `x . C y + x' . y + x . y'` of shapes and their rates.
        let form = |c: usize, d: usize| {
            dot(&rate[c], &v[d]) + dot(&v[c], &rate[d]) + dot(&strained[c], &v[d]) + dashpots[c + d]
        };
        let (g11, g12, g22) = (form(0, 0), form(0, 1), form(1, 1));
        let scale = block.rate[0].max(block.rate[1]);
        let size = v.each_ref().map(|v| size(v));
        let spread = size[0] * (g22.abs() + g12.abs()) + size[1] * (g12.abs() + g11.abs());
        let factor = spread / ((g11 * g22 - g12 * g12).abs() * scale);
        Self { system, v, rate, left, scale, factor }
    }

    fn sum(&self, of: [f64; 2]) -> f64 {
        let sum = self.factor * (of[0] + of[1]);
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn found(&self) -> f64 {
        self.sum(self.left.each_ref().map(|left| size(left)))
    }

    /// The same plus the rounding of its terms, which remains even where they cancel.
    fn possible(&self) -> f64 {
        let noise = |c: usize| {
            f64::EPSILON * self.scale * (self.scale * size(&self.v[c]) + size(&self.rate[c]))
        };
        self.sum([0, 1].map(|c| size(&self.left[c]) + noise(c)))
    }

    /// Rounding of the equation's terms.
    fn rounding(&self) -> f64 {
        let terms = |c: usize| terms(self.system, &self.v[c], &self.rate[c]);
        self.sum([0, 1].map(|c| f64::EPSILON * terms(c)))
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
