//! The drill string of a top hammer: a shank, which the piston strikes, and rods down to the bit.
//!
//! A sleeve of length `Lc` joins each rod to the shank or rod above it, and covers `Lc/2` of each of the two. The
//! sleeve carries the force together with the steel inside it. With a shank of length `Ls` and two rods of length `Lr`,
//! the lengths of the sections are, from the top,
//!
//! ```text
//! Ls - Lc/2,   Lc, Lr - Lc,   Lc, Lr - Lc/2,   the bit's own
//! ```
//!
//! Joints that are screwed tight do not part, so the string and the bit are one body made of these sections.
//! Loose joints (`laws/tie.rs`) part where the rods' faces meet, in the middle of the sleeve; each rod carries half of
//! the sleeve.
//! The shank, each rod, and the last rod together with the bit are then separate bodies.

use crate::quantities::sections::Segment;
use serde::{Deserialize, Serialize};

/// The drill string of a top hammer, between the piston and the bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drill {
    /// Number of rods. With 0 there is no shank either, and the piston strikes the bit.
    pub rods: usize,
    /// The shank that the piston strikes; its length runs from the struck face to the first rod.
    pub shank: Segment,
    /// One rod; all rods are alike, and their length is measured from face to face.
    pub rod: Segment,
    /// The sleeve at the upper end of each rod, with the steel inside it; there is none if its length is 0.
    pub coupling: Segment,
    /// Stiffness and slack of the joints.
    pub joint: Joint,
}

/// The law of the joints between shank and rods, the same for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Stiffness `kj` of the faces and of the thread, N/m; with 0 the joints are screwed tight.
    pub stiffness: f64,
    /// Travel of the lower rod from where the faces press to where the thread pulls, m.
    /// With 0 the joint carries push and pull without play.
    pub slack: f64,
}

impl Drill {
    /// The number of joints that are not screwed tight.
    pub(crate) fn loose(&self) -> usize {
        if self.joint.stiffness > 0.0 { self.rods } else { 0 }
    }

    /// The sections of shank and rods from top to bottom, each with the number of the body that it belongs to.
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
