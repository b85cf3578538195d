//! The displacement of an attachment, computed from the force in it.
//!
//! A spring far stiffer than the bars hardly moves: its displacement `u = phi . X` in a mode of the
//! shape `X` is a sum of terms that cancel, and the force `k u` is lost in their rounding. But the
//! free modes feel that force, and no other: with `f` the forces in all attachments,
//! ```text
//! X_i B^2 + omega_i^2 (beta X_i B + X_i) = sum_a phi_ai f_a,        u_a (k_a + c_a B) = -f_a
//! ```
//!
//! holds for every free mode `i` to rounding of its own terms, and least squares over all of them
//! give `f` to its own.

use crate::modal::spectrum::block::Block;
use crate::modal::structure::{Attachment, Structure};
use crate::numerics::kernel::inner_product;
use crate::numerics::math;
use crate::numerics::matrix2::{Matrix2, product};

/// If the terms exceed their sum by this factor, the force is more accurate. The value is a choice:
/// the sum then loses at most three digits.
const CANCELS: f64 = 1e3;
/// Largest relative difference between the two; in a block with a larger error, the force is not used.
const ROUGH: f64 = 1e-10;

/// `x y` of a row.
fn times([p, q]: [f64; 2], m: &Matrix2) -> [f64; 2] {
    [p * m[0] + q * m[2], p * m[1] + q * m[3]]
}

/// Each attachment's displacement in the two coordinates of a block; none if the sum over its shape
/// is as accurate.
pub(crate) fn displacements(structure: &Structure, block: &Block) -> Vec<Option<[f64; 2]>> {
    let attachments = &structure.attachments;
    let [first, second] = &block.shapes;
    let sizes: Vec<f64> = first.iter().zip(second).map(|(x, y)| (x * x + y * y).sqrt()).collect();
    let sums = attachments.iter().map(|attachment| {
        let sum = block.shapes.each_ref().map(|shape| inner_product(attachment.shape, shape));
        let sizes = attachment.shape.iter().zip(&sizes).map(|(phi, size)| phi.abs() * size);
        (sum, sizes.sum::<f64>())
    });
    let sums: Vec<([f64; 2], f64)> = sums.collect();
    let cancels = |(sum, terms): &([f64; 2], f64)| *terms > CANCELS * math::hypot(sum[0], sum[1]);
    let springs = attachments.iter().filter(|attachment| attachment.stiffness > 0.0).count();
    let mut list = vec![None; attachments.len()];
    if block.rigid || !sums[..springs].iter().any(cancels) {
        return list;
    }
    let forces = forces(structure, block, springs);
    let known =
        attachments[..springs].iter().zip(&sums).zip(forces).map(|((attachment, sum), force)| {
            let (k, c, b) = (attachment.stiffness, attachment.viscosity, &block.b);
            let m = [k + c * b[0], c * b[1], c * b[2], k + c * b[3]];
            let det = m[0] * m[3] - m[1] * m[2];
            let inverse = [-m[3] / det, m[1] / det, m[2] / det, -m[0] / det];
            let u = times(force, &inverse);
            let apart = math::hypot(u[0] - sum.0[0], u[1] - sum.0[1]);
            (cancels(sum) && apart <= ROUGH * sum.1).then_some(u)
        });
    list.iter_mut().zip(known).for_each(|(at, u)| *at = u);
    list
}

/// Most springs among the attachments, which come first.
const MOST: usize = 3;

/// A dashpot alone, which does not need to be stiff: its forces in the two coordinates by its speeds,
/// and their size before they cancel.
struct Dashpot<'a> {
    shape: &'a [f64],
    forces: [f64; 2],
    size: f64,
}

impl<'a> Dashpot<'a> {
    fn new(attachment: &Attachment<'a>, block: &Block, rate: f64) -> Self {
        let Attachment { shape, viscosity, .. } = *attachment;
        let moved = block.shapes.each_ref().map(|x| inner_product(shape, x));
        let sizes = block.shapes[0].iter().zip(&block.shapes[1]).map(|(x, y)| math::hypot(*x, *y));
        let size: f64 = shape.iter().zip(sizes).map(|(phi, size)| phi.abs() * size).sum();
        let forces = times(moved, &block.b).map(|speed| viscosity * speed);
        Self { shape, forces, size: viscosity * rate * size }
    }
}

/// The forces in the springs by least squares; those in dashpots alone are known.
fn forces(structure: &Structure, block: &Block, springs: usize) -> [[f64; 2]; MOST] {
    let (b, rate) = (&block.b, block.rate[0].max(block.rate[1]));
    let square = product(b, b);
    let (mut gram, mut right) = ([0.0; 6], [[0.0; 2]; MOST]);
    let (stiff, rest) = structure.attachments.split_at(springs);
    let dashpots: Vec<Dashpot> = rest.iter().map(|a| Dashpot::new(a, block, rate)).collect();
    let shape = |a: usize, i: usize| stiff.get(a).map_or(0.0, |x| x.shape[i]);
    for (i, w2) in structure.omega2.iter().enumerate() {
        let row = [block.shapes[0][i], block.shapes[1][i]];
        let (turned, pushed) = (times(row, b), times(row, &square));
        let mut driven: [f64; 2] =
            std::array::from_fn(|k| pushed[k] + w2 * (structure.beta * turned[k] + row[k]));
        // An equation is rounded by the size of its own terms.
        let stiff = rate * rate + w2 * (1.0 + structure.beta * rate);
        let mut size = math::hypot(row[0], row[1]) * stiff;
        for dashpot in &dashpots {
            let phi = dashpot.shape[i];
            driven.iter_mut().zip(dashpot.forces).for_each(|(d, force)| *d += phi * force);
            size += phi.abs() * dashpot.size;
        }
        if size == 0.0 {
            continue;
        }
        let weight = 1.0 / (size * size);
        let phi: [f64; MOST] = std::array::from_fn(|a| shape(a, i));
        for (sum, [a, b]) in gram.iter_mut().zip([[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]]) {
            *sum += weight * phi[a] * phi[b];
        }
        for (right, phi) in right.iter_mut().zip(phi) {
            right.iter_mut().zip(driven).for_each(|(r, d)| *r += weight * phi * d);
        }
    }
    match springs {
        1 => return [right[0].map(|r| r / gram[0]), [0.0; 2], [0.0; 2]],
        3 => return three(gram, right),
        _ => {}
    }
    let det = gram[0] * gram[2] - gram[1] * gram[1];
    let solve = |p: f64, q: f64, x: [f64; 2], y: [f64; 2]| -> [f64; 2] {
        std::array::from_fn(|k| (p * x[k] - q * y[k]) / det)
    };
    let [x, y, z] = right;
    [solve(gram[2], gram[1], x, y), solve(gram[0], gram[1], y, x), z]
}

/// The forces of three springs, by Cholesky's factors.
fn three(gram: [f64; 6], right: [[f64; 2]; MOST]) -> [[f64; 2]; MOST] {
    let [a, b, d, c, e, f] = gram;
    let gram = nalgebra::Matrix3::new(a, b, c, b, d, e, c, e, f);
    let right = nalgebra::Matrix3x2::from_fn(|row, column| right[row][column]);
    let none = [[f64::NAN; 2]; MOST];
    gram.cholesky().map_or(none, |factors| {
        let forces = factors.solve(&right);
        std::array::from_fn(|a| [forces[(a, 0)], forces[(a, 1)]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::spectrum::Spectrum;

    /// A translation and one free mode of a bar, held by a spring far stiffer than the bar: the
    /// translation is driven by the spring alone, which gives its force in closed form.
    #[test]
    fn a_stiff_spring_moves_by_its_force() {
        let (w2, phi, mut stiff) = (4.0e10, [0.7, -1.1], 0);
        for k in [1e14f64, 1e17, 1e20] {
            let attachment = Attachment { shape: &phi, stiffness: k, viscosity: 0.0 };
            let omega2 = [0.0, w2];
            let structure =
                Structure { attachments: vec![attachment], ..Structure::free(&omega2, 0.0) };
            for block in Spectrum::new(&structure).unwrap().blocks().unwrap() {
                let found = displacements(&structure, &block)[0];
                // X_i (omega_i^2 - x) = -k phi_i u: of the translation, u = x X_0 / (k phi_0).
                let x = -product(&block.b, &block.b)[0];
                let wanted = [0, 1].map(|c| x * block.shapes[c][0] / (k * phi[0]));
                let sum = [0, 1]
                    .map(|c| -> f64 { phi.iter().zip(&block.shapes[c]).map(|(p, x)| p * x).sum() });
                let size = wanted[0].hypot(wanted[1]);
                let Some(u) = found else {
                    // If it is not stiff for this mode, the sum loses three digits of sixteen, and
                    // the block a few units in its last place.
                    assert!((sum[0] - wanted[0]).hypot(sum[1] - wanted[1]) <= 1e-11 * size);
                    continue;
                };
                stiff += 1;
                // Some ten roundings, in the square of the rate as well.
                let apart = (u[0] - wanted[0]).hypot(u[1] - wanted[1]);
                assert!(apart <= 32.0 * f64::EPSILON * size, "{k:e}: {u:?} {wanted:?}");
            }
        }
        assert!(stiff >= 3, "{stiff}");
    }
}
