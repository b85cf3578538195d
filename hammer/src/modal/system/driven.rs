//! The polynomial part of a track's motion.

use crate::numerics::poly::Poly;
use serde::{Deserialize, Serialize};

/// Coordinates whose motion under the loads is a polynomial of the time after an epoch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// Uniform translation.
    pub translation: Poly,
    /// Modal coordinates that are slow compared with the loads: their indices, and their whole
    /// motion.
    pub slow: Vec<(usize, Poly)>,
    /// How long `slow` is valid, s; unlimited if there is none.
    pub reach: Option<f64>,
}

impl Driven {
    /// A translation and nothing else.
    pub fn translating(translation: Poly) -> Self {
        Self { translation, slow: Vec::new(), reach: None }
    }

    /// Moves the epoch by `at`, unless the slow coordinates' motion is not valid beyond; returns whether it
    /// did.
    pub(crate) fn shift(&mut self, at: f64) -> bool {
        let goes_on = self.reach.is_none_or(|reach| reach > at);
        if goes_on {
            self.translation.shift(at);
            self.slow.iter_mut().for_each(|(_, poly)| poly.shift(at));
            self.reach.iter_mut().for_each(|reach| *reach -= at);
        }
        goes_on
    }

    /// True if all of it is at most a parabola.
    #[inline]
    pub(crate) fn is_parabola(&self) -> bool {
        self.slow.is_empty() && self.translation.degree() <= 2
    }

    /// Coefficients with those of the slow coordinates left out.
    pub(crate) fn without_slow(&self, c: &[f64]) -> Vec<f64> {
        let mut fast = c.to_vec();
        for (k, _) in &self.slow {
            fast[*k] = 0.0;
        }
        fast
    }
}
