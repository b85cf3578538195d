//! The polynomial part of a track's motion.

use crate::numerics::poly::Poly;
use serde::{Deserialize, Serialize};

/// The coordinates whose motion under the loads is a polynomial of the time since the epoch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// Uniform translation.
    pub translation: Poly,
    /// Indices and whole motion of the modal coordinates that are slow compared with the loads.
    pub slow: Vec<(usize, Poly)>,
    /// How long `slow` is valid, s; `None` means without limit.
    pub reach: Option<f64>,
}

impl Driven {
    /// A motion that is only a translation.
    pub fn translating(translation: Poly) -> Self {
        Self { translation, slow: Vec::new(), reach: None }
    }

    /// Moves the epoch by `step` (s) and returns true, if the motion of the slow coordinates is still valid afterwards.
    pub(crate) fn shift(&mut self, step: f64) -> bool {
        let is_valid = self.reach.is_none_or(|reach| reach > step);
        if is_valid {
            self.translation.shift(step);
            self.slow.iter_mut().for_each(|(_, poly)| poly.shift(step));
            self.reach.iter_mut().for_each(|reach| *reach -= step);
        }
        is_valid
    }

    /// True if no polynomial is of a higher degree than 2.
    #[inline]
    pub(crate) fn is_parabola(&self) -> bool {
        self.slow.is_empty() && self.translation.degree() <= 2
    }

    /// Coefficients of modal coordinates, with those of the slow ones set to zero.
    pub(crate) fn without_slow(&self, c: &[f64]) -> Vec<f64> {
        let mut fast = c.to_vec();
        for (k, _) in &self.slow {
            fast[*k] = 0.0;
        }
        fast
    }
}
