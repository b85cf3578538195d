//! The displacement of an attachment, computed from the force in it.
//!
//! A spring that is far stiffer than the bars hardly moves. In a mode of the shape `X` its displacement `u = phi . X`
//! is a sum of terms that cancel, and the force `k u` is lost in their rounding.
//! But only the forces `f` in the attachments drive the free modes, so that
//!
//! ```text
//! X_i B^2 + omega_i^2 (beta X_i B + X_i) = sum_a phi_ai f_a,        u_a (k_a + c_a B) = -f_a
//! ```
//!
//! holds for every free mode `i` to the rounding of its own terms. Least squares over all free modes give `f` to its
//! own rounding.

use crate::modal::spectrum::block::Block;
use crate::modal::structure::{Attachment, Structure};
use crate::numerics::kernel::inner_product;
use crate::numerics::math;
use crate::numerics::matrix2::{Matrix2, product};

/// If the terms exceed their sum by this factor, the displacement is computed from the force. With this limit the sum
/// loses at most three digits where it is used.
const CANCELS: f64 = 1e3;
/// Largest difference between the displacement from the force and that from the sum, relative to the sum's terms. If it
/// is larger, the block is inaccurate and the force is not used.
const ROUGH: f64 = 1e-10;
/// The amplitude of a free mode in which forces all but cancel is rounded like this share of their terms at least. Weights
/// differ by the square, so that least squares lose two digits at most.
const ROUNDED: f64 = 0.1;

/// The product of a row and a matrix.
fn times([p, q]: [f64; 2], m: &Matrix2) -> [f64; 2] {
    [p * m[0] + q * m[2], p * m[1] + q * m[3]]
}

/// Displacement of each attachment in the two coordinates of a block, computed from its force; `None` if the sum over
/// its shape is as accurate.
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
    let rough = forces(structure, block, springs, &Default::default());
    let forces = forces(structure, block, springs, &rough);
    let known =
        attachments[..springs].iter().zip(&sums).zip(forces).map(|((attachment, sum), force)| {
            let (k, c, b) = (attachment.stiffness, attachment.viscosity, &block.b);
            let m = [k + c * b[0], c * b[1], c * b[2], k + c * b[3]];
            let det = m[0] * m[3] - m[1] * m[2];
            let inverse = [-m[3] / det, m[1] / det, m[2] / det, -m[0] / det];
            let u = times(force, &inverse);
            let difference = math::hypot(u[0] - sum.0[0], u[1] - sum.0[1]);
            (cancels(sum) && difference <= ROUGH * sum.1).then_some(u)
        });
    list.iter_mut().zip(known).for_each(|(slot, u)| *slot = u);
    list
}

/// Largest number of springs among the attachments. They come before the dashpots.
const MAX_SPRINGS: usize = 3;

/// A dashpot without a spring: its forces in the two coordinates, which follow from its velocities, and the size of
/// their terms. Velocities need not be computed from the force, since such a dashpot is not stiff.
struct Dashpot<'a> {
    shape: &'a [f64],
    forces: [f64; 2],
    size: f64,
}

impl<'a> Dashpot<'a> {
    fn new(attachment: &Attachment<'a>, block: &Block, rate: f64) -> Self {
        let Attachment { shape, viscosity, .. } = *attachment;
        let displacements = block.shapes.each_ref().map(|x| inner_product(shape, x));
        let sizes = block.shapes[0].iter().zip(&block.shapes[1]).map(|(x, y)| math::hypot(*x, *y));
        let size: f64 = shape.iter().zip(sizes).map(|(phi, size)| phi.abs() * size).sum();
        let forces = times(displacements, &block.b).map(|velocity| viscosity * velocity);
        Self { shape, forces, size: viscosity * rate * size }
    }
}

/// The forces in the springs, by least squares. The forces in dashpots without a spring are known. `rough` are estimates
/// of the forces: where they all but cancel in a free mode, as those at the ends of a light bit, its amplitude is small
/// but rounded as they are. Without them its equation would outweigh all others, which leaves only the forces' sum known.
fn forces(
    structure: &Structure,
    block: &Block,
    springs: usize,
    rough: &[[f64; 2]; MAX_SPRINGS],
) -> [[f64; 2]; MAX_SPRINGS] {
    let (b, rate) = (&block.b, block.rate[0].max(block.rate[1]));
    let square = product(b, b);
    let (mut gram, mut right) = ([0.0; 6], [[0.0; 2]; MAX_SPRINGS]);
    let (stiff, rest) = structure.attachments.split_at(springs);
    let dashpots: Vec<Dashpot> = rest.iter().map(|a| Dashpot::new(a, block, rate)).collect();
    let shape = |a: usize, i: usize| stiff.get(a).map_or(0.0, |x| x.shape[i]);
    for (i, w2) in structure.omega2.iter().enumerate() {
        let row = [block.shapes[0][i], block.shapes[1][i]];
        let (velocity, acceleration) = (times(row, b), times(row, &square));
        let mut force: [f64; 2] =
            std::array::from_fn(|k| acceleration[k] + w2 * (structure.beta * velocity[k] + row[k]));
        // The rounding of an equation is in proportion to the size of its terms.
        let stiff = rate * rate + w2 * (1.0 + structure.beta * rate);
        let mut size = math::hypot(row[0], row[1]) * stiff;
        for dashpot in &dashpots {
            let phi = dashpot.shape[i];
            force.iter_mut().zip(dashpot.forces).for_each(|(sum, force)| *sum += phi * force);
            size += phi.abs() * dashpot.size;
        }
        let phi: [f64; MAX_SPRINGS] = std::array::from_fn(|a| shape(a, i));
        let terms = phi.iter().zip(rough).map(|(phi, f)| phi.abs() * math::hypot(f[0], f[1]));
        size = size.max(ROUNDED * terms.sum::<f64>());
        if size == 0.0 {
            continue;
        }
        let weight = 1.0 / (size * size);
        for (sum, [a, b]) in gram.iter_mut().zip([[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]]) {
            *sum += weight * phi[a] * phi[b];
        }
        for (right, phi) in right.iter_mut().zip(phi) {
            right.iter_mut().zip(force).for_each(|(r, force)| *r += weight * phi * force);
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
fn three(gram: [f64; 6], right: [[f64; 2]; MAX_SPRINGS]) -> [[f64; 2]; MAX_SPRINGS] {
    let [a, b, d, c, e, f] = gram;
    let gram = nalgebra::Matrix3::new(a, b, c, b, d, e, c, e, f);
    let right = nalgebra::Matrix3x2::from_fn(|row, column| right[row][column]);
    let unknown = [[f64::NAN; 2]; MAX_SPRINGS];
    gram.cholesky().map_or(unknown, |factors| {
        let forces = factors.solve(&right);
        std::array::from_fn(|a| [forces[(a, 0)], forces[(a, 1)]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::spectrum::Spectrum;

    /// A spring far stiffer than a bar holds the bar, which has its translation and one elastic mode. Only the spring
    /// drives the translation, which gives the spring's force in closed form.
    #[test]
    fn a_stiff_spring_moves_by_its_force() {
        let (w2, phi, mut stiff) = (4.0e10, [0.7, -1.1], 0);
        for k in [1e14f64, 1e17, 1e20] {
            let attachment = Attachment { shape: &phi, stiffness: k, viscosity: 0.0 };
            let omega2 = [0.0, w2];
            let structure =
                Structure { attachments: vec![attachment], ..Structure::free(&omega2, 0.0) };
            for block in Spectrum::new(&structure).unwrap().blocks().unwrap() {
                let displacement = displacements(&structure, &block)[0];
                // X_i (omega_i^2 - x) = -k phi_i u, which for the translation gives u = x X_0 / (k phi_0).
                let x = -product(&block.b, &block.b)[0];
                let expected = [0, 1].map(|c| x * block.shapes[c][0] / (k * phi[0]));
                let sum = [0, 1]
                    .map(|c| -> f64 { phi.iter().zip(&block.shapes[c]).map(|(p, x)| p * x).sum() });
                let size = expected[0].hypot(expected[1]);
                let Some(u) = displacement else {
                    // If the spring is not stiff for this mode, the sum loses up to three digits of sixteen, and the
                    // block itself is off by a few units in its last place.
                    assert!((sum[0] - expected[0]).hypot(sum[1] - expected[1]) <= 1e-11 * size);
                    continue;
                };
                stiff += 1;
                // There are some ten roundings, some of them in the square of the rate.
                let error = (u[0] - expected[0]).hypot(u[1] - expected[1]);
                assert!(error <= 32.0 * f64::EPSILON * size, "{k:e}: {u:?} {expected:?}");
            }
        }
        assert!(stiff >= 3, "{stiff}");
    }

    /// A stiff spring between a heavy piston and a light bit, which another spring holds. Only the first spring drives the
    /// piston's translation, which gives its force in closed form. The bit hardly needs a force to follow, so that those
    /// at its ends cancel in every second of its modes.
    #[test]
    fn a_spring_above_a_light_bit_moves_by_its_force() {
        let (top, mut stiff) = (36.0, 0);
        let omega2: Vec<f64> = [0.0, 1.2e10, 0.0]
            .into_iter()
            .chain((1..6).map(|j| 1.4e13 * f64::from(j * j)))
            .collect();
        let (mut contact, mut rock) = (vec![1.7, -2.9, -top], vec![0.0, 0.0, top]);
        for j in 1..6 {
            let end = top * std::f64::consts::SQRT_2;
            contact.push(-end);
            rock.push(if j % 2 == 0 { end } else { -end });
        }
        for k in [1e11, 3e11, 1e12, 1e13, 1e14] {
            let spring = |shape, stiffness| Attachment { shape, stiffness, viscosity: 0.0 };
            let attachments = vec![spring(&contact[..], k), spring(&rock, 1.5e11)];
            let structure = Structure { attachments, ..Structure::free(&omega2, 0.0) };
            for block in Spectrum::new(&structure).unwrap().blocks().unwrap() {
                let Some(u) = displacements(&structure, &block)[0] else { continue };
                stiff += 1;
                let x = -product(&block.b, &block.b)[0];
                let expected = [0, 1].map(|c| x * block.shapes[c][0] / (k * contact[0]));
                let size = expected[0].hypot(expected[1]);
                let error = (u[0] - expected[0]).hypot(u[1] - expected[1]);
                // Two digits may be lost where weights are unequal.
                let allowed = 32.0 * f64::EPSILON * size / (ROUNDED * ROUNDED);
                assert!(error <= allowed, "{k:e}: {u:?} {expected:?}");
            }
        }
        assert!(stiff >= 5, "{stiff}");
    }
}
