//! Two nearly coincident roots: their common factor by Cauchy integrals and Newton's method.
//!
//! A nearly critically damped mode has two nearly parallel eigenvectors. It is represented by one
//! quadratic factor `(s - sigma)^2 + delta` with the mean and the divided difference of the
//! eigenvector, which both stay smooth where the roots coincide.

use crate::modal::spectrum::block::Block;
use crate::modal::spectrum::quotient::Factor;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::{norm, sin_cos};
use num_complex::Complex64 as C;

/// Nodes of a Cauchy integral: 0.3^64 and 0.5^64 are below rounding.
const CAUCHY_NODES: usize = 64;

/// A circle that encloses two roots and nothing else.
pub(crate) struct Circle<'a> {
    secular: &'a Secular,
    centre: f64,
    /// Nodes, each also relative to the centre.
    nodes: Vec<(C, Root)>,
}

impl<'a> Circle<'a> {
    /// Points around two roots that keep every pole and every other root well outside; none if
    /// something lies between them (then they are not confluent).
    pub(crate) fn around(secular: &'a Secular, roots: &[Root], i: usize, j: usize) -> Option<Self> {
        let (a, b) = (secular.value(roots[i]), secular.value(roots[j]));
        let centre = 0.5 * (a + b).re;
        let mut reach = centre.abs();
        for (k, &root) in roots.iter().enumerate() {
            if k != i && k != j {
                reach = reach.min(norm(secular.value(root) - centre));
            }
        }
        for pole in &secular.poles {
            reach = reach.min(norm(pole - centre));
        }
        let radius = 0.3 * reach;
        if norm(a - b) > radius {
            return None;
        }
        let pole = roots[i].pole;
        let nodes = (0..CAUCHY_NODES).map(|m| {
            let angle = 2.0 * std::f64::consts::PI * (m as f64 + 0.5) / CAUCHY_NODES as f64;
            let (sin, cos) = sin_cos(angle);
            let z = radius * C::new(cos, sin);
            (z, Root { pole, offset: (centre - secular.poles[pole]) + z })
        });
        Some(Self { secular, centre, nodes: nodes.collect() })
    }

    /// The factor `(s - sigma)^2 + delta` of the two roots inside; none if the iteration does not
    /// converge.
    pub(crate) fn factor(&self) -> Option<Factor> {
        // Argument principle: sums of the first and second powers of the two roots.
        let count = CAUCHY_NODES as f64;
        let (mut once, mut twice) = (0.0, 0.0);
        let mut values = Vec::with_capacity(CAUCHY_NODES);
        for &(z, root) in &self.nodes {
            let (f, slope, _) = self.secular.function(root);
            let slope = slope / f;
            once += (z * z * slope).re / count;
            twice += (z * z * z * slope).re / count;
            values.push(f);
        }
        let shift = 0.5 * once;
        let delta = shift * shift - 0.5 * twice;
        // The secular function over the factor, from the circle to its centre.
        let mut cofactor = [0.0; 2];
        for (&(z, _), f) in self.nodes.iter().zip(values) {
            let y = z - shift;
            let square = y * y + delta;
            let weight = f * z / (square * square) / count;
            cofactor[0] += (weight * y).re;
            cofactor[1] += weight.re;
        }
        Factor::new(self.centre + shift, delta).refined(self.secular, cofactor)
    }
}

/// The block of a factor, with vectors from one row of the matrix.
pub(crate) fn block(secular: &Secular, factor: &Factor, row: usize) -> Block {
    let [sigma, delta] = factor.values();
    let [mean, difference] = factor.vectors(secular, row);
    let scale = 0.5 * sigma.abs();
    let norm = mean.iter().chain(&difference).map(|x| x * x).sum::<f64>().sqrt();
    let mean = mean.iter().map(|x| x / norm).collect();
    let second = difference.iter().map(|x| x * scale / norm).collect();
    Block::quadratic(sigma, delta, scale, [mean, second])
}
