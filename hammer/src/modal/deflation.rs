//! Equal frequencies taken out before the eigenvalues are looked for.

use crate::modal::block::Block;
use crate::modal::structure::Structure;
use crate::numerics::math;

/// A structure with modes of distinct frequencies only.
///
/// With a single attachment, two modes of equal frequency combine into one that feels it
/// and one that does not; the latter is an eigenvector already.
pub(crate) struct Deflated {
    /// Squared frequencies, ascending.
    pub(crate) omega2: Vec<f64>,
    /// Kelvin-Voigt damping time, s.
    pub(crate) beta: f64,
    /// Amplitudes of each attachment in the modes left.
    pub(crate) shapes: Vec<Vec<f64>>,
    /// Stiffness and viscosity of each attachment.
    pub(crate) springs: Vec<(f64, f64)>,
    /// Which free modes stand behind a mode that is left, with their weights.
    pub(crate) members: Vec<Vec<(usize, f64)>>,
    /// Number of free modes.
    pub(crate) modes: usize,
}

impl Deflated {
    /// The structure that is left, and the blocks of the modes taken out.
    pub(crate) fn new(structure: &Structure) -> (Self, Vec<Block>) {
        let n = structure.omega2.len();
        let attachments = &structure.attachments;
        let mut left = Self {
            omega2: Vec::new(),
            beta: structure.beta,
            shapes: vec![Vec::new(); attachments.len()],
            springs: attachments.iter().map(|a| (a.stiffness, a.viscosity)).collect(),
            members: Vec::new(),
            modes: n,
        };
        let mut blocks = Vec::new();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| structure.omega2[i].total_cmp(&structure.omega2[j]));
        let single = attachments.len() == 1;
        let mut at = 0;
        while at < n {
            let i = order[at];
            let omega2 = structure.omega2[i];
            let twin = order.get(at + 1).copied().filter(|&j| {
                let b = structure.omega2[j];
                single && b - omega2 <= 4.0 * f64::EPSILON * b
            });
            left.omega2.push(omega2);
            if let Some(j) = twin {
                let phi = attachments[0].shape;
                let norm = math::hypot(phi[i], phi[j]);
                let (ci, cj) = (phi[i] / norm, phi[j] / norm);
                left.shapes[0].push(norm);
                left.members.push(vec![(i, ci), (j, cj)]);
                let mut shape = vec![0.0; n];
                (shape[i], shape[j]) = (cj, -ci);
                blocks.push(Block::free(omega2, structure.beta, shape));
                at += 2;
            } else {
                for (shape, attachment) in left.shapes.iter_mut().zip(attachments) {
                    shape.push(attachment.shape[i]);
                }
                left.members.push(vec![(i, 1.0)]);
                at += 1;
            }
        }
        (left, blocks)
    }
}
