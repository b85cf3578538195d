//! Free modes of a body in a spline basis: `K phi = lambda M phi`.
//!
//! Everything is dimensionless: lengths are relative to the body's length, masses to its mass.
//! Then `omega^2 = lambda E / (rho L^2)`, and the modes depend only on the shape.
//!
//! ```text
//! M = L L^T,  C = L^-1 K L^-T             Cholesky's factor makes a standard problem
//! C without the direction L^T 1           the rigid mode is known: lambda 0, phi 1
//! C = W diag(lambda) W^T                  nalgebra's dense symmetric solver
//! phi = L^-T W, refined                   as described below
//! ```
//!
//! A dense solver's error is a rounding of the *largest* eigenvalue. Relative to the lowest eigenvalue, this is 1e-16
//! times 400^2 and more for 400 elements. The pairs are therefore refined by the method of Ogita and Aishima (2018,
//! Japan J. Indust. Appl. Math. 35:1007): with `G = X^T M X` and `H = X^T K X`, `X := X (1 + E)`, `E_ij = (H_ij +
//! lambda_j (1 - G)_ij) / (lambda_j - lambda_i)`, to second order. Both products are computed from values and strains
//! at the Gauss points, not from the assembled matrices. Strains are differences of coefficients, so the strains of a
//! low mode have a small relative error. `lambda_i = H_ii / G_ii` is then a sum of squares over a sum of squares.
//!
//! Every loop is scalar, in fixed order, and uses only `+ - * /` and square roots, so results are the same on every
//! processor, to the last binary digit. Nalgebra's matrix product is not used, because it chooses its instructions at
//! run time. `faer` was rejected because its solvers use fused products where a processor has them.

use crate::bodies::spline::{Basis, Node};
use crate::interrupt;
use crate::quantities::sections::Sections;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

/// Eigenpairs of a free body, dimensionless.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairs {
    /// Eigenvalues in ascending order; the first is exactly 0.
    pub lambda: Vec<f64>,
    /// For each mode its spline coefficients; those of the first mode are exactly 1.
    pub shapes: Vec<Vec<f64>>,
}

/// Limit of the sweeps of the implicit QR method per mode; two or three suffice.
const SWEEPS: usize = 60;
/// Limit of the rounds of refinement; one or two suffice.
const ROUNDS: usize = 12;
/// If the corrections are below this, the refinement ends. The error that remains is their square, which is below
/// rounding.
const SMALL: f64 = 1e-9;
/// Largest correction in one round; the next round removes its square.
const STRIDE: f64 = 0.1;
/// If the coupling of two modes, relative to their `lambda`, is below this, it counts as rounding.
const NOISE: f64 = 64.0 * f64::EPSILON;

/// Relative difference below which eigenvalues count as equal.
/// At the upper end of a spline's spectrum each mode belongs to one end of a section, and sections with equal spans
/// have equal eigenvalues up to rounding.
/// The vectors of equal eigenvalues may be any basis of the space that they span.
const TWINS: f64 = 1e-13;

/// The free modes of a body; `None` if they cannot be computed to working accuracy, or if the call is interrupted.
pub fn solve(sections: &Sections, basis: &Basis) -> Option<Pairs> {
    let points = Points::new(sections, basis);
    let mut shapes = dense(&points, basis.functions())?;
    for _ in 0..ROUNDS {
        let correction = points.refine(&mut shapes)?;
        if correction <= SMALL {
            let lambda: Vec<f64> = shapes.iter_mut().map(|c| points.normalise(c)).collect();
            return sorted(lambda, shapes);
        }
    }
    None
}

fn sorted(lambda: Vec<f64>, shapes: Vec<Vec<f64>>) -> Option<Pairs> {
    let mut pairs: Vec<(f64, Vec<f64>)> = lambda.into_iter().zip(shapes).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let valid = pairs.iter().all(|(lambda, c)| *lambda > 0.0 && c.iter().all(|x| x.is_finite()));
    if !valid || !pairs.iter().all(|(lambda, _)| lambda.is_finite()) {
        return None;
    }
    let size = pairs.len() + 1;
    let (mut lambda, mut shapes) = (vec![0.0], vec![vec![1.0; size]]);
    for (value, shape) in pairs {
        let before = lambda[lambda.len() - 1];
        lambda.push(if value - before <= TWINS * value { before } else { value });
        shapes.push(shape);
    }
    Some(Pairs { lambda, shapes })
}

/// The points of the quadrature over a body.
struct Points {
    nodes: Vec<Node>,
    /// Square roots of the points' weights, which add up to 1.
    roots: Vec<f64>,
    length: f64,
}

impl Points {
    fn new(sections: &Sections, basis: &Basis) -> Self {
        let nodes = basis.quadrature();
        let volume = nodes.iter().fold(0.0, |sum, node| sum + node.volume);
        let roots = nodes.iter().map(|node| (node.volume / volume).sqrt()).collect();
        Self { nodes, roots, length: sections.length() }
    }

    /// Values and strains of a mode at the points, each times the root of its point's weight.
    fn fields(&self, c: &[f64]) -> [Vec<f64>; 2] {
        let points = || self.nodes.iter().zip(&self.roots);
        let values = points().map(|(node, root)| root * node.sample.value(c)).collect();
        let strains = points().map(|(node, root)| root * self.length * node.sample.slope(c));
        [values, strains.collect()]
    }

    /// Scales a mode so that `phi.M phi` is 1 and its upper end positive. Returns its Rayleigh quotient.
    fn normalise(&self, c: &mut [f64]) -> f64 {
        let [values, strains] = self.fields(c);
        let mass = dot(&values, &values);
        let factor = if c[0] < 0.0 { -1.0 } else { 1.0 } / mass.sqrt();
        c.iter_mut().for_each(|x| *x *= factor);
        dot(&strains, &strains) / mass
    }

    /// Refines all modes once, except the rigid one. Returns the largest correction, or `None` if it is not finite or
    /// the call is interrupted.
    fn refine(&self, shapes: &mut [Vec<f64>]) -> Option<f64> {
        for c in shapes.iter_mut() {
            // Remove the rigid motion, which is the mean and is known to rounding.
            let [values, _] = self.fields(c);
            let mean = dot(&values, &self.roots);
            c.iter_mut().for_each(|x| *x -= mean);
            self.normalise(c);
        }
        let fields: Vec<_> = shapes.iter().map(|c| self.fields(c)).collect();
        let lambda: Vec<f64> = fields.iter().map(|[v, s]| dot(s, s) / dot(v, v)).collect();
        let mut changes: Vec<Vec<f64>> = shapes.iter().map(|c| vec![0.0; c.len()]).collect();
        let mut largest = 0.0f64;
        for i in 0..shapes.len() {
            if interrupt::is_set() {
                return None;
            }
            for j in 0..i {
                // `(1 - G)_ij` and `H_ij`.
                let orthogonality = -dot(&fields[i][0], &fields[j][0]);
                let coupling = dot(&fields[i][1], &fields[j][1]);
                let rotation = |from: f64, to: f64| {
                    let (numerator, gap) = (coupling + to * orthogonality, to - from);
                    let is_rounding = numerator.abs() <= NOISE * to.max(from);
                    let angle = if is_rounding && gap.abs() <= 1e-3 * to {
                        0.5 * orthogonality
                    } else {
                        numerator / gap
                    };
                    // If the eigenvalues are equal but coupled, any rotation helps.
                    if angle.is_finite() { angle.clamp(-STRIDE, STRIDE) } else { STRIDE }
                };
                let into_j = rotation(lambda[i], lambda[j]);
                let into_i = rotation(lambda[j], lambda[i]);
                largest = largest.max(into_j.abs()).max(into_i.abs());
                add(&mut changes[j], into_j, &shapes[i]);
                add(&mut changes[i], into_i, &shapes[j]);
            }
        }
        for (c, change) in shapes.iter_mut().zip(&changes) {
            add(c, 1.0, change);
        }
        largest.is_finite().then_some(largest)
    }
}

/// The modes except the rigid one, with an error of a rounding of the largest eigenvalue.
fn dense(points: &Points, size: usize) -> Option<Vec<Vec<f64>>> {
    let (mut mass, mut stiffness) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    for (node, root) in points.nodes.iter().zip(&points.roots) {
        let (sample, weight) = (&node.sample, root * root);
        let slopes = sample.function_slopes();
        for (i, (a, s)) in sample.range().zip(sample.values().iter().zip(&slopes)) {
            for (j, (b, t)) in sample.range().zip(sample.values().iter().zip(&slopes)) {
                mass[(i, j)] += weight * a * b;
                stiffness[(i, j)] += weight * points.length * points.length * s * t;
            }
        }
    }
    let lower = Cholesky::new(mass)?.unpack();
    // This makes L^-1 K L^-T: K is symmetric, so the transpose of L^-1 K is K L^-T.
    let half = lower.solve_lower_triangular(&stiffness)?;
    let mut c = lower.solve_lower_triangular(&half.transpose())?;
    let mut rigid: DVector<f64> = DVector::zeros(size);
    for j in 0..size {
        for i in j..size {
            rigid[j] += lower[(i, j)];
        }
    }
    // The reflection that maps the rigid mode to the first axis.
    let norm = rigid.dot(&rigid).sqrt();
    let mut axis = rigid;
    axis[0] += if axis[0] < 0.0 { -norm } else { norm };
    let scale = 2.0 / axis.dot(&axis);
    reflect(&mut c, &axis, scale);
    c.transpose_mut();
    reflect(&mut c, &axis, scale);
    let elastic = c.remove_row(0).remove_column(0);
    if elastic.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let symmetric = (&elastic + elastic.transpose()) * 0.5;
    if interrupt::is_set() {
        return None;
    }
    let solved = SymmetricEigen::try_new(symmetric, f64::EPSILON, SWEEPS * size)?;
    let mut shapes = solved.eigenvectors.insert_row(0, 0.0);
    reflect(&mut shapes, &axis, scale);
    lower.tr_solve_lower_triangular_mut(&mut shapes);
    Some(shapes.column_iter().map(|column| column.iter().copied().collect()).collect())
}

/// `m := (1 - scale axis axis^T) m`.
fn reflect(m: &mut DMatrix<f64>, axis: &DVector<f64>, scale: f64) {
    for mut column in m.column_iter_mut() {
        let factor = -scale * axis.dot(&column);
        column.axpy(factor, axis, 1.0);
    }
}

fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

/// `a . b` as eight partial sums in a fixed order, which the compiler can vectorise without changing the result.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let remainder: f64 = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a.zip(b) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6]))
        + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
        + remainder
}
