//! Bodies on springs that hold both ways: their modes together, one spring taken in after another.
//!
//! With the modes of all before it, each spring leads to a scalar secular equation. Its damping is
//! proportional like the bodies' own, so the modes together stay real, `V' V = 1`.

use crate::error::SpectrumError;
use crate::modal::block::Block;
use crate::modal::spectrum;
use crate::modal::structure::{Attachment, Structure};
use crate::numerics::kernel::inner_product;

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
    /// Those of a structure with its joints.
    ///
    /// # Errors
    /// [`SpectrumError`], if they cannot be computed to working accuracy.
    pub(crate) fn new(structure: &Structure) -> Result<Self, SpectrumError> {
        let n = structure.omega2.len();
        let axis = |i| (0..n).map(|k| f64::from(u8::from(i == k))).collect();
        let (omega2, shapes) = (structure.omega2.to_vec(), (0..n).map(axis).collect());
        let mut joined = Self { omega2, shapes, attached: Vec::new() };
        for joint in &structure.joints {
            joined.take_in(joint)?;
        }
        let attached = structure.attachments.iter().map(|a| joined.amplitudes(a.shape));
        joined.attached = attached.collect();
        Ok(joined)
    }

    fn take_in(&mut self, joint: &Attachment) -> Result<(), SpectrumError> {
        let shape = self.amplitudes(joint.shape);
        let spring = Attachment { shape: &shape, stiffness: joint.stiffness, viscosity: 0.0 };
        let attachments = vec![spring];
        let blocks = spectrum::blocks(&Structure { attachments, ..Structure::free(&self.omega2, 0.0) })?;
        let modes = blocks.into_iter().map(|block| {
            let [b11, b12, b21, b22] = block.b;
            let [shape, _] = block.shapes;
            let size = inner_product(&shape, &shape).sqrt();
            let unit: Vec<f64> = shape.iter().map(|x| x / size).collect();
            (b11 * b22 - b12 * b21, self.in_bodies(&unit))
        });
        (self.omega2, self.shapes) = modes.collect();
        Ok(())
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
