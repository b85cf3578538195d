//! The drill string of a top hammer: a shank, which the piston strikes, and rods down to the bit.
//!
//! Joints that are screwed tight move as one, so string and bit are one body of many sections. A
//! sleeve joins each rod to what is above it, and covers half its length `Lc` of either; there it
//! carries the force together with the steel inside. From the top, with a shank of `Ls` and two rods
//! of `Lr`, the lengths are
//!
//! ```text
//! Ls - Lc/2,   Lc, Lr - Lc,   Lc, Lr - Lc/2,   the bit's own
//! ```

use crate::quantities::sections::Segment;
use serde::{Deserialize, Serialize};

/// The drill string of a top hammer, between the piston and the bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drill {
    /// Number of rods; 0: none, and no shank either: the piston strikes the bit.
    pub rods: usize,
    /// The shank that the piston strikes, from its face to the first rod's.
    pub shank: Segment,
    /// Each rod, from face to face.
    pub rod: Segment,
    /// The sleeve at the upper end of each rod, with the steel inside; of no length: none.
    pub coupling: Segment,
}

impl Drill {
    /// The sections above the bit's own, from top to bottom.
    pub(crate) fn sections(&self) -> impl Iterator<Item = Segment> {
        let Self { rods, shank, rod, coupling } = *self;
        let covered = move |part: Segment, halves: f64| Segment {
            length: part.length - halves * 0.5 * coupling.length,
            ..part
        };
        let joint = move |k| [coupling, covered(rod, if k < rods { 2.0 } else { 1.0 })];
        let string = std::iter::once(covered(shank, 1.0)).chain((1..=rods).flat_map(joint));
        string.filter(move |section| rods > 0 && section.length > 0.0)
    }
}
