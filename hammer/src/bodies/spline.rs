//! B-splines along a stepped body: smooth inside a section, continuous where sections meet.
//!
//! Each section has `spans` equal spans and open uniform knots of the degree `p`. At an end of the section only one
//! function differs from zero, the first or the last, and its value there is 1. Neighbouring sections share the
//! function at the step between them. Degree 1 gives linear two-node elements. The derivative is computed from
//! differences of neighbouring coefficients, `u' = sum_j p B_j^(p-1) (c_j - c_(j-1)) / (t_(j+p) - t_j)`, so it is
//! exactly zero for a translation.

use crate::numerics::math;
use crate::quantities::parameters::MAX_DEGREE;
use crate::quantities::sections::{Sections, Segment};
use std::f64::consts::PI;

/// Largest number of functions that do not vanish on a span.
const WIDTH: usize = MAX_DEGREE + 1;

/// The functions that do not vanish at a point.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Index of the first of these functions.
    first: usize,
    degree: usize,
    value: [f64; WIDTH],
    /// Weights of the differences of neighbouring coefficients, 1/m.
    slope: [f64; WIDTH],
}

impl Sample {
    /// Indices of the functions that do not vanish at the point.
    pub fn range(&self) -> std::ops::RangeInclusive<usize> {
        self.first..=self.first + self.degree
    }

    /// Values of these functions at the point.
    pub fn values(&self) -> &[f64] {
        &self.value[..=self.degree]
    }

    /// Derivatives of these functions at the point, 1/m.
    pub fn function_slopes(&self) -> [f64; WIDTH] {
        let weight = |j: usize| if j < self.degree { self.slope[j] } else { 0.0 };
        std::array::from_fn(|j| if j == 0 { 0.0 } else { weight(j - 1) } - weight(j))
    }

    /// Value of the spline with these coefficients at the point.
    pub fn value(&self, c: &[f64]) -> f64 {
        self.values().iter().zip(&c[self.first..]).map(|(v, c)| v * c).sum()
    }

    /// Derivative of the spline with these coefficients at the point, in the unit of the coefficients over m.
    pub fn slope(&self, c: &[f64]) -> f64 {
        let c = &c[self.first..];
        (0..self.degree).map(|j| self.slope[j] * (c[j + 1] - c[j])).sum()
    }
}

/// A point of the exact quadrature over a body.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// The functions at the point.
    pub sample: Sample,
    /// Weight of an integral over the volume, m3.
    pub volume: f64,
}

/// The functions of one section.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    section: Segment,
    spans: usize,
    /// Distance of the section's top from the body's upper face, m.
    top: f64,
    /// Index of the section's first function.
    first: usize,
}

/// The functions of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    degree: usize,
    parts: Vec<Part>,
    functions: usize,
}

impl Basis {
    /// Splines of a degree on `total` spans.
    pub fn new(sections: &Sections, degree: usize, total: usize) -> Self {
        let (mut parts, mut first, mut top) = (Vec::new(), 0, 0.0);
        for (section, spans) in sections.as_slice().iter().zip(sections.spans(total)) {
            parts.push(Part { section: *section, spans, top, first });
            first += spans + degree - 1;
            top += section.length;
        }
        Self { degree, parts, functions: first + 1 }
    }

    /// Number of functions.
    pub fn functions(&self) -> usize {
        self.functions
    }

    /// The functions at the spans' ends, from the upper face down.
    pub fn at_nodes(&self) -> Vec<Sample> {
        let mut list = vec![self.sample(&self.parts[0], 0, 0.0)];
        for part in &self.parts {
            list.extend((0..part.spans).map(|span| self.sample(part, span, 1.0)));
        }
        list
    }

    /// The functions at the middles of the spans, from the upper face down.
    pub fn at_middles(&self) -> Vec<Sample> {
        let mut list = Vec::new();
        for part in &self.parts {
            list.extend((0..part.spans).map(|span| self.sample(part, span, 0.5)));
        }
        list
    }

    /// Gauss points that integrate a product of two functions exactly.
    pub fn quadrature(&self) -> Vec<Node> {
        self.parts.iter().flat_map(|part| self.points(part)).collect()
    }

    fn points(&self, part: &Part) -> Vec<Node> {
        let rule = gauss(self.degree + 1);
        let volume = part.section.area * part.section.length / part.spans as f64;
        let span_nodes = |span| {
            let node = |(x, weight): &(f64, f64)| Node {
                sample: self.sample(part, span, *x),
                volume: volume * weight,
            };
            rule.iter().map(node).collect::<Vec<_>>()
        };
        (0..part.spans).flat_map(span_nodes).collect()
    }

    /// The functions at `x` of a span, where `x` is 0 at its upper end and 1 at its lower end, by the recurrence of Cox
    /// and de Boor.
    fn sample(&self, part: &Part, span: usize, x: f64) -> Sample {
        let p = self.degree;
        // Knots are in units of the span, and are repeated at the section's ends.
        let knot = |i: usize| i.saturating_sub(p).min(part.spans) as f64;
        let (position, index) = (span as f64 + x, span + p);
        let (mut value, mut lower) = ([0.0; WIDTH], [0.0; WIDTH]);
        value[0] = 1.0;
        for d in 1..=p {
            lower = value;
            value = [0.0; WIDTH];
            for j in 0..d {
                let (low, high) = (knot(index + 1 + j - d), knot(index + 1 + j));
                let share = lower[j] / (high - low);
                value[j] += (high - position) * share;
                value[j + 1] += (position - low) * share;
            }
        }
        let per_length = p as f64 * part.spans as f64 / part.section.length;
        let slope = std::array::from_fn(|j| {
            if j >= p {
                return 0.0;
            }
            per_length * lower[j] / (knot(index + 1 + j) - knot(index + 1 + j - p))
        });
        Sample { first: part.first + span, degree: p, value, slope }
    }
}

/// Nodes on (0, 1) and weights of the Gauss-Legendre rule, which is exact to degree `2 n - 1`. The nodes are found by
/// Newton's method on the Legendre polynomial, from Tricomi's estimate of its zeros.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut value) = (1.0, x);
        for k in 2..=n {
            let next = ((2 * k - 1) as f64 * x * value - (k - 1) as f64 * before) / k as f64;
            (before, value) = (value, next);
        }
        (value, n as f64 * (x * value - before) / (x * x - 1.0))
    };
    let rule = (0..n).map(|i| {
        let mut x = -math::cos(PI * (i as f64 + 0.75) / (n as f64 + 0.5));
        for _ in 0..8 {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        let slope = legendre(x).1;
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> Sections {
        let parts = [(0.3, 2e-3), (0.05, 5e-3), (0.2, 1e-3)];
        let list = parts.map(|(length, area)| Segment { length, area });
        Sections::new(&list).expect("sections")
    }

    /// Bound of the rounding of a recurrence of up to seven steps with positive numbers of at most 1.
    const CLOSE: f64 = 1e-14;

    #[test]
    fn functions_add_up_to_one_and_ends_belong_to_one_of_them() {
        for degree in 1..=MAX_DEGREE {
            let basis = Basis::new(&body(), degree, 9);
            assert_eq!(basis.functions(), 9 + 3 * degree - 2);
            let ones = vec![1.0; basis.functions()];
            for Node { sample, .. } in basis.quadrature() {
                assert!((sample.value(&ones) - 1.0).abs() < CLOSE);
                assert_eq!(sample.slope(&ones), 0.0);
            }
            let nodes = basis.at_nodes();
            assert_eq!((nodes.len(), basis.at_middles().len()), (10, 9));
            let mut ends = vec![0.0; basis.functions()];
            (ends[0], ends[basis.functions() - 1]) = (1.0, 2.0);
            assert!((nodes[0].value(&ends) - 1.0).abs() < CLOSE);
            assert!((nodes[9].value(&ends) - 2.0).abs() < CLOSE);
        }
    }

    #[test]
    fn gauss_points_integrate_what_they_should() {
        for n in 1..=WIDTH {
            for power in 0..2 * n {
                let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                // The sum has n positive terms below 1, each rounded a few times.
                assert!((sum - 1.0 / (power + 1) as f64).abs() < 1e-14, "{n} {power}: {sum}");
            }
        }
        let basis = Basis::new(&body(), 3, 9);
        let volume: f64 = basis.quadrature().iter().map(|node| node.volume).sum();
        assert!((volume - body().mass(1.0)).abs() < 1e-14 * volume);
    }
}
