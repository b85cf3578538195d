//! Bodies on springs that hold both ways: their modes together, one spring taken in after another.
//!
//! In the modes of all before it, each spring is a dyad. Its damping is proportional like the bodies'
//! own, so the modes together stay real, `V' V = 1`.

use crate::interrupt;
use crate::modal::block::Block;
use crate::modal::structure::{Attachment, Structure};
use crate::numerics::kernel::inner_product;
use crate::numerics::rank_one;

/// Modes of joined bodies.
pub(crate) struct Joined {
    /// Squared frequencies, rad2/s2.
    omega2: Vec<f64>,
    /// Each mode in the bodies' own.
    shapes: Vec<Vec<f64>>,
    /// Shapes of the structure's attachments in these modes.
    attached: Vec<Vec<f64>>,
}

impl Joined {
    /// Those of a structure with its joints. None if an interrupt comes.
    pub(crate) fn new(structure: &Structure) -> Option<Self> {
        let n = structure.omega2.len();
        let axis = |i| (0..n).map(|k| f64::from(u8::from(i == k))).collect();
        let (omega2, shapes) = (structure.omega2.to_vec(), (0..n).map(axis).collect());
        let mut joined = Self { omega2, shapes, attached: Vec::new() };
        for joint in &structure.joints {
            joined.take_in(joint)?;
        }
        let attached = structure.attachments.iter().map(|a| joined.amplitudes(a.shape));
        joined.attached = attached.collect();
        Some(joined)
    }

    fn take_in(&mut self, joint: &Attachment) -> Option<()> {
        let shape = self.amplitudes(joint.shape);
        let pairs = rank_one::pairs(&self.omega2, joint.stiffness, &shape);
        let modes = pairs.into_iter().map(|(omega2, mode)| {
            let mut shape = self.in_bodies(&mode);
            // A translation is downward.
            if omega2 == 0.0 && shape.iter().sum::<f64>() < 0.0 {
                shape.iter_mut().for_each(|x| *x = -*x);
            }
            (!interrupt::is_set()).then_some((omega2, shape))
        });
        (self.omega2, self.shapes) = modes.collect::<Option<_>>()?;
        Some(())
    }

    /// The structure in these modes.
    pub(crate) fn structure<'a>(&'a self, of: &Structure) -> Structure<'a> {
        let attached = of.attachments.iter().zip(&self.attached);
        let attachments = attached.map(|(a, shape)| Attachment {
            shape,
            stiffness: a.stiffness,
            viscosity: a.viscosity,
        });
        Structure { attachments: attachments.collect(), ..Structure::free(&self.omega2, of.beta) }
    }

    /// A block of these modes in the bodies' own.
    pub(crate) fn block(&self, block: Block) -> Block {
        let shapes = block.shapes.each_ref().map(|shape| self.in_bodies(shape));
        Block { shapes, ..block }
    }

    /// A point's amplitudes in these modes, from those in the bodies' own.
    fn amplitudes(&self, shape: &[f64]) -> Vec<f64> {
        self.shapes.iter().map(|mode| inner_product(mode, shape)).collect()
    }

    fn in_bodies(&self, shape: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; shape.len()];
        for (amplitude, mode) in shape.iter().zip(&self.shapes) {
            sum.iter_mut().zip(mode).for_each(|(s, x)| *s += amplitude * x);
        }
        sum
    }
}
