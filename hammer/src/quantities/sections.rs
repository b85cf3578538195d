//! A body as a sequence of sections, and how they share the spans of a mesh.

use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// Largest number of sections that may be given for a body.
pub const MAX_SEGMENTS: usize = 8;

/// Largest number of rods of a drill string.
pub const MAX_RODS: usize = 8;

/// Largest number of sections of a body: those given for a bit, and above them a shank and rods with both halves of
/// their couplings.
pub const MAX_SECTIONS: usize = MAX_SEGMENTS + 1 + 3 * MAX_RODS;

/// A uniform part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// Length, m.
    pub length: f64,
    /// Cross section, m2.
    pub area: f64,
}

/// The sections that are given for a body, from top to bottom: a slice of [`Segment`], which is empty for a uniform body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segments {
    count: usize,
    list: [Segment; MAX_SEGMENTS],
}

impl Segments {
    /// None. Each stored section is an equal part of a body of this length (m) and area (m2).
    pub(crate) fn none(length: f64, area: f64) -> Self {
        let part = Segment { length: length / MAX_SEGMENTS as f64, area };
        Self { count: 0, list: [part; MAX_SEGMENTS] }
    }

    /// Gives the body these sections. A scene with more than [`MAX_SEGMENTS`] is refused.
    pub fn set(&mut self, sections: &[Segment]) {
        self.count = sections.len();
        self.list.iter_mut().zip(sections).for_each(|(stored, section)| *stored = *section);
    }

    /// Gives the body the first sections of those that are stored; 0 makes it uniform.
    pub fn set_count(&mut self, count: usize) {
        self.count = count;
    }

    pub(crate) fn count_mut(&mut self) -> &mut usize {
        &mut self.count
    }

    /// A stored section, which a host may set before the number of sections.
    pub(crate) fn stored_mut(&mut self, index: usize) -> &mut Segment {
        &mut self.list[index]
    }
}

impl Deref for Segments {
    type Target = [Segment];

    fn deref(&self) -> &[Segment] {
        &self.list[..self.count.min(MAX_SEGMENTS)]
    }
}

impl DerefMut for Segments {
    fn deref_mut(&mut self) -> &mut [Segment] {
        &mut self.list[..self.count.min(MAX_SEGMENTS)]
    }
}

/// Which of the bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Body {
    /// The piston.
    Piston,
    /// The bit.
    Bit,
    /// The casing. A scene may be without one.
    Casing,
}

impl Body {
    /// The bodies of every scene.
    pub const ALL: [Self; 2] = [Self::Piston, Self::Bit];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Piston => "piston",
            Self::Bit => "bit",
            Self::Casing => "casing",
        }
    }
}

/// The sections of a body from top to bottom; there is at least one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sections {
    list: [Segment; MAX_SECTIONS],
    count: usize,
}

impl Sections {
    /// The list of these sections; `None` if there are none, or more than [`MAX_SECTIONS`].
    pub fn new(sections: &[Segment]) -> Option<Self> {
        let (last, above) = sections.split_last()?;
        (above.len() < MAX_SECTIONS).then(|| Self::ending(above.iter().copied(), *last))
    }

    /// The list of the sections `above`, followed by the `last` one. Their number must not exceed [`MAX_SECTIONS`].
    pub(crate) fn ending(above: impl Iterator<Item = Segment>, last: Segment) -> Self {
        let (mut list, mut count) = ([last; MAX_SECTIONS], 1);
        for (slot, section) in list[..MAX_SECTIONS - 1].iter_mut().zip(above) {
            *slot = section;
            count += 1;
        }
        Self { list, count }
    }

    /// The sections from top to bottom.
    pub fn as_slice(&self) -> &[Segment] {
        &self.list[..self.count]
    }

    /// Sum of the lengths, m.
    pub fn length(&self) -> f64 {
        self.as_slice().iter().fold(0.0, |sum, s| sum + s.length)
    }

    /// `sum rho A L`, kg.
    pub fn mass(&self, density: f64) -> f64 {
        self.as_slice().iter().fold(0.0, |sum, s| sum + density * s.area * s.length)
    }

    /// Area of the section at a distance below the upper face, m2. Where two sections meet, it is the area of the upper
    /// one.
    pub fn area_at(&self, distance: f64) -> f64 {
        let mut end = 0.0;
        for s in self.as_slice() {
            end += s.length;
            if distance <= end {
                return s.area;
            }
        }
        self.list[self.count - 1].area
    }

    /// The area of all sections, if it is the same for all.
    pub fn one_area(&self) -> Option<f64> {
        let area = self.list[0].area;
        self.as_slice().iter().all(|s| s.area == area).then_some(area)
    }

    /// Divides `total` spans among the sections: each section gets one, and every further span goes to the section
    /// whose spans are longest. There must be at least as many spans as sections.
    pub fn spans(&self, total: usize) -> Vec<usize> {
        let mut spans = vec![1; self.count];
        for _ in self.count..total {
            let size = |k: usize| self.list[k].length / spans[k] as f64;
            let longest = (1..self.count).fold(0, |a, k| if size(k) > size(a) { k } else { a });
            spans[longest] += 1;
        }
        spans
    }

    /// The ends of the spans, from the upper face down, m.
    pub fn nodes(&self, total: usize) -> Vec<f64> {
        let (mut nodes, mut top) = (vec![0.0], 0.0);
        for (s, spans) in self.as_slice().iter().zip(self.spans(total)) {
            nodes.extend((1..=spans).map(|i| top + s.length * (i as f64 / spans as f64)));
            top += s.length;
        }
        nodes
    }
}
