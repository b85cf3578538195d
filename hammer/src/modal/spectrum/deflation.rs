//! Deflation: modes that are already eigenvectors are removed before the eigenvalues are computed.
//!
//! * If several modes have equal frequency, at most as many of their combinations are coupled to the attachments as
//!   there are attachments; the other combinations are eigenvectors.
//! * A mode that hardly moves the attachments is an eigenvector too. At the upper end of the spectrum of splines each
//!   mode belongs to one end of a body, and moves the other end only by a rounding.

use crate::modal::spectrum::block::Block;
use crate::modal::structure::Structure;
use crate::numerics::kernel::{inner_product as dot, norm};
use crate::numerics::math;
use num_complex::Complex64 as C;
use std::iter::Sum;
use std::ops::Mul;

/// The structure without the removed modes. It has no more modes of one frequency than attachments.
pub(crate) struct Deflated {
    /// Squared frequencies, ascending.
    pub(crate) omega2: Vec<f64>,
    /// Kelvin-Voigt damping time, s.
    pub(crate) beta: f64,
    /// The uniform translation, if only a dashpot to the ground resists it.
    pub(crate) sliding: Option<Vec<f64>>,
    /// Amplitudes of each attachment in the remaining modes.
    pub(crate) shapes: Vec<Vec<f64>>,
    /// For each attachment, the magnitudes of these amplitudes and their norm.
    pub(crate) sizes: Vec<(Vec<f64>, f64)>,
    /// Stiffness and viscosity of each attachment.
    pub(crate) springs: Vec<(f64, f64)>,
    /// The free modes that make up each remaining mode, with their weights.
    pub(crate) members: Vec<Vec<(usize, f64)>>,
    /// Number of free modes.
    pub(crate) modes: usize,
}

/// Relative difference below which squared frequencies are equal to rounding.
const EQUAL: f64 = 4.0 * f64::EPSILON;

/// If less than this share of a direction remains after orthogonalisation, the remainder is rounding.
const SPANNED: f64 = 1e-14;

impl Deflated {
    /// The remaining structure, and the blocks of the removed modes.
    pub(crate) fn new(structure: &Structure) -> (Self, Vec<Block>) {
        let n = structure.omega2.len();
        let attachments = &structure.attachments;
        let mut remaining = Self {
            omega2: Vec::new(),
            beta: structure.beta,
            sliding: structure.sliding.map(<[f64]>::to_vec),
            shapes: vec![Vec::new(); attachments.len()],
            sizes: Vec::new(),
            springs: attachments.iter().map(|a| (a.stiffness, a.viscosity)).collect(),
            members: Vec::new(),
            modes: n,
        };
        let mut blocks = Vec::new();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| structure.omega2[i].total_cmp(&structure.omega2[j]));
        let equal = |i: &usize, j: &usize| {
            let (a, b) = (structure.omega2[*i], structure.omega2[*j]);
            b - a <= EQUAL * b
        };
        for cluster in order.chunk_by(equal) {
            let omega2 = structure.omega2[cluster[0]];
            for (weights, coupled) in combinations(structure, cluster) {
                if coupled && is_changed(structure, cluster, &weights) {
                    remaining.omega2.push(omega2);
                    for (shape, attachment) in remaining.shapes.iter_mut().zip(attachments) {
                        shape.push(amplitude(attachment.shape, cluster, &weights));
                    }
                    let members = cluster.iter().copied().zip(weights);
                    remaining.members.push(members.filter(|(_, weight)| *weight != 0.0).collect());
                } else {
                    let mut shape = vec![0.0; n];
                    cluster.iter().zip(weights).for_each(|(&i, weight)| shape[i] = weight);
                    blocks.push(Block::free(omega2, structure.beta, shape));
                }
            }
        }
        let sizes = |shape: &Vec<f64>| (shape.iter().map(|x| x.abs()).collect(), norm(shape));
        remaining.sizes = remaining.shapes.iter().map(sizes).collect();
        (remaining, blocks)
    }

    /// Converts amplitudes of the free modes to those of the remaining modes.
    pub(crate) fn merged<T: Copy + Mul<f64, Output = T> + Sum>(&self, shape: &[T]) -> Vec<T> {
        let amplitude = |members: &Vec<(usize, f64)>| match members[..] {
            [(mode, weight)] => shape[mode] * weight,
            _ => members.iter().map(|&(mode, weight)| shape[mode] * weight).sum(),
        };
        self.members.iter().map(amplitude).collect()
    }

    /// Converts amplitudes of the remaining modes to those of the free modes.
    pub(crate) fn unmerged(&self, amplitudes: &[C]) -> Vec<C> {
        let mut shape = vec![C::default(); self.modes];
        for (members, amplitude) in self.members.iter().zip(amplitudes) {
            for &(mode, weight) in members {
                shape[mode] += weight * amplitude;
            }
        }
        shape
    }
}

/// Orthonormal combinations of modes of one frequency, each with a flag that is true if attachments are coupled to it.
/// At most as many are coupled as there are attachments.
fn combinations(structure: &Structure, cluster: &[usize]) -> Vec<(Vec<f64>, bool)> {
    let size = cluster.len();
    let axis = |k: usize| (0..size).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    let attachments = &structure.attachments;
    let uncombined = || (0..size).map(|k| (axis(k), true)).collect();
    if size == 1 {
        return uncombined();
    }
    if let ([only], &[i, j]) = (&attachments[..], cluster) {
        let (a, b) = (only.shape[i], only.shape[j]);
        let length = math::hypot(a, b);
        if length > 0.0 {
            let (a, b) = (a / length, b / length);
            return vec![(vec![a, b], true), (vec![b, -a], false)];
        }
    }
    let mut list: Vec<(Vec<f64>, bool)> = Vec::new();
    let attached = attachments.iter().map(|a| cluster.iter().map(|&i| a.shape[i]).collect());
    let others = (0..size).map(axis);
    let directions = attached.map(|v| (v, true)).chain(others.map(|v| (v, false)));
    for (mut direction, coupled) in directions {
        let before = norm(&direction);
        // Two orthogonalisations are enough (Kahan).
        for _ in 0..2 {
            for (known, _) in &list {
                let share = dot(known, &direction);
                direction.iter_mut().zip(known).for_each(|(x, k)| *x -= share * k);
            }
        }
        let after = norm(&direction);
        // A direction that earlier ones span is left out.
        if after > before * if coupled { SPANNED } else { 0.5 / (size as f64).sqrt() } {
            direction.iter_mut().for_each(|x| *x /= after);
            list.push((direction, coupled));
        }
        if list.len() == size {
            break;
        }
    }
    // If all are coupled, nothing is removed and the modes stay as they are.
    if list.iter().all(|(_, coupled)| *coupled) { uncombined() } else { list }
}

fn amplitude(shape: &[f64], cluster: &[usize], weights: &[f64]) -> f64 {
    cluster.iter().zip(weights).map(|(&i, weight)| weight * shape[i]).sum()
}

/// False if the attachments change a mode by less than a rounding of its own stiffness.
fn is_changed(structure: &Structure, cluster: &[usize], weights: &[f64]) -> bool {
    let omega2 = structure.omega2[cluster[0]];
    structure.attachments.iter().any(|a| {
        // A translation has no stiffness, so anything that acts on it changes it.
        let rate = if omega2 == 0.0 { 1.0 } else { omega2.sqrt() };
        let strength = a.stiffness + a.viscosity * rate;
        let reach = strength * dot(a.shape, a.shape).sqrt();
        reach * amplitude(a.shape, cluster, weights).abs() > 0.25 * f64::EPSILON * omega2
    })
}
