//! The drill string of a top hammer: a shank, which the piston strikes, and rods down to the bit.
//!
//! A sleeve joins each rod to the shank or rod above it, and covers half of its own length `Lc` of either. There the
//! sleeve carries the force together with the steel inside. From the top, with a shank of `Ls` and two rods of `Lr`,
//! the lengths of the sections are
//!
//! ```text
//! Ls - Lc/2,   Lc, Lr - Lc,   Lc, Lr - Lc/2,   the bit's own
//! ```
//!
//! Joints that are screwed tight do not part, so string and bit are one body of these sections. Loose joints
//! (`laws/tie.rs`) part where the rods' faces meet, in the middle of the sleeve, of which each rod carries one half.
//! Shank, rods, and the last rod with the bit are then separate bodies.

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
    /// The sleeve at the upper end of each rod, with the steel inside; length 0: none.
    pub coupling: Segment,
    /// How the joints hold.
    pub joint: Joint,
}

/// The joints between shank and rods, all alike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Stiffness `kj` of the faces and of the thread, N/m; 0: screwed tight.
    pub stiffness: f64,
    /// Travel of the lower rod from where the faces press to where the thread pulls, m; 0: the joint holds both ways.
    pub slack: f64,
}

impl Drill {
    /// The number of joints that are not screwed tight.
    pub(crate) fn loose(&self) -> usize {
        if self.joint.stiffness > 0.0 { self.rods } else { 0 }
    }

    /// The sections above the bit's own, from top to bottom, with the number of the body that each
    /// belongs to.
    pub(crate) fn sections(&self) -> impl Iterator<Item = (usize, Segment)> {
        let Self { rods, shank, rod, coupling, .. } = *self;
        let covered = move |part: Segment, halves: f64| Segment {
            length: part.length - halves * 0.5 * coupling.length,
            ..part
        };
        let half = Segment { length: 0.5 * coupling.length, ..coupling };
        let loose = self.loose() > 0;
        let joint = move |k: usize| {
            let rod = covered(rod, if k < rods { 2.0 } else { 1.0 });
            let sleeve = if loose {
                [Some((k - 1, half)), Some((k, half))]
            } else {
                [Some((0, coupling)), None]
            };
            let body = if loose { k } else { 0 };
            sleeve.into_iter().flatten().chain([(body, rod)])
        };
        let string = std::iter::once((0, covered(shank, 1.0))).chain((1..=rods).flat_map(joint));
        string.filter(move |(_, section)| rods > 0 && section.length > 0.0)
    }
}
