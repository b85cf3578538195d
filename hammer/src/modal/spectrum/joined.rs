//! The modes of bodies that are joined by springs with proportional damping. The springs are added one after another.
//!
//! In the modes of the bodies and all springs added before, the stiffness of a new spring is a dyad. Its damping is
//! proportional to its stiffness, like that of the bodies, so the joint modes are real and orthonormal, `V' V = 1`.
//! These modes do not depend on what acts on the tip. They are the same in every run of a sweep over a rock or a load,
//! and are therefore computed once per process.

use crate::bodies::cache::Recent;
use crate::interrupt;
use crate::modal::spectrum::block::Block;
use crate::modal::structure::{Attachment, Structure};
use crate::numerics::combine::combine_in_order;
use crate::numerics::kernel::{LANES, inner_product};
use crate::numerics::rank_one;
use std::sync::Arc;

/// Memory for the cached modes, bytes. It is enough for all groups of eight rods on the mesh that a drilling rate
/// needs.
const BUDGET: usize = 1 << 24;

/// The exact numbers on which the modes depend: the number of the bodies' modes, their frequencies, and the springs.
type Key = Vec<u64>;

static MODES: Recent<Key, Arc<Modes>> = Recent::new(BUDGET, 1, |modes| modes.bytes());

/// Empties the cache.
pub(crate) fn forget() {
    MODES.forget();
}

fn key(structure: &Structure) -> Key {
    let springs = structure.proportional.iter();
    let springs = springs.flat_map(|a| std::iter::once(&a.stiffness).chain(a.shape));
    let numbers = structure.omega2.iter().chain(springs).map(|x| x.to_bits());
    std::iter::once(structure.omega2.len() as u64).chain(numbers).collect()
}

struct Modes {
    /// Squared frequencies, rad2/s2.
    omega2: Vec<f64>,
    /// Each mode in terms of the bodies' own modes, one after the other, padded to whole groups of lanes.
    shapes: Vec<f64>,
}

/// The modes of joined bodies, and the structure's attachments in them.
pub(crate) struct Joined {
    modes: Arc<Modes>,
    /// Shapes of the structure's attachments in these modes.
    attached: Vec<Vec<f64>>,
    /// The translation of all bodies in these modes, if the structure slides.
    sliding: Option<Vec<f64>>,
}

impl Modes {
    /// The modes of a structure with its proportional springs; `None` if the call is interrupted.
    fn new(structure: &Structure) -> Option<Self> {
        let n = structure.omega2.len();
        let (omega2, stride) = (structure.omega2.to_vec(), n.next_multiple_of(LANES));
        let mut shapes = vec![0.0; n * stride];
        shapes.iter_mut().step_by(stride + 1).for_each(|diagonal| *diagonal = 1.0);
        let mut modes = Self { omega2, shapes };
        for spring in &structure.proportional {
            modes.take_in(spring)?;
        }
        Some(modes)
    }

    fn bytes(&self) -> usize {
        size_of::<f64>() * (self.omega2.len() + self.shapes.len())
    }

    fn take_in(&mut self, spring: &Attachment) -> Option<()> {
        let shape = self.amplitudes(spring.shape);
        let pairs = rank_one::pairs(&self.omega2, spring.stiffness, &shape);
        let mut shapes = Vec::with_capacity(self.shapes.len());
        for (_, mode) in &pairs {
            if interrupt::is_set() {
                return None;
            }
            shapes.extend(self.in_bodies(mode));
        }
        self.omega2 = pairs.into_iter().map(|(omega2, _)| omega2).collect();
        self.shapes = shapes;
        Some(())
    }

    /// A point's amplitudes in these modes, converted from those in the bodies' own modes.
    fn amplitudes(&self, shape: &[f64]) -> Vec<f64> {
        let modes = self.shapes.chunks_exact(shape.len().next_multiple_of(LANES));
        modes.map(|mode| inner_product(mode, shape)).collect()
    }

    /// A shape converted from these modes to the bodies' own modes, padded to whole groups of lanes.
    fn in_bodies(&self, shape: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; shape.len().next_multiple_of(LANES)];
        combine_in_order(&self.shapes, shape, &mut sum);
        sum
    }
}

impl Joined {
    /// The modes of a structure with its proportional springs; `None` if the call is interrupted.
    pub(crate) fn new(structure: &Structure) -> Option<Self> {
        let modes =
            MODES.find(key(structure), |_| Modes::new(structure).map(Arc::new).ok_or(())).ok()?;
        let attached = structure.attachments.iter().map(|a| modes.amplitudes(a.shape)).collect();
        let sliding = structure.sliding.map(|shape| modes.amplitudes(shape));
        Some(Self { modes, attached, sliding })
    }

    /// A structure converted from the bodies' own modes to these modes.
    pub(crate) fn structure<'a>(&'a self, structure: &Structure) -> Structure<'a> {
        let attached = structure.attachments.iter().zip(&self.attached);
        let attached = attached.map(|(a, shape)| Attachment {
            shape,
            stiffness: a.stiffness,
            viscosity: a.viscosity,
        });
        let (attachments, sliding) = (attached.collect(), self.sliding.as_deref());
        Structure { attachments, sliding, ..Structure::free(&self.modes.omega2, structure.beta) }
    }

    /// A block converted from these modes to the bodies' own modes.
    pub(crate) fn block(&self, block: Block) -> Block {
        let count = self.modes.omega2.len();
        let shapes = block.shapes.each_ref().map(|shape| {
            let mut shape = self.modes.in_bodies(shape);
            shape.truncate(count);
            shape
        });
        Block { shapes, ..block }
    }
}
