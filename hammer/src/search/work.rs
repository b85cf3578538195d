//! What a search takes.

/// Work done by a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Evaluations of a guard or its bounds.
    pub evaluations: u64,
    /// Rotations of a track.
    pub samples: u64,
    /// Taylor windows opened.
    pub windows: u64,
}

impl Work {
    /// One look a tabulated step ahead.
    #[inline]
    pub(super) fn count_evaluation(&mut self) {
        self.evaluations += 1;
        self.samples += 1;
    }
}
