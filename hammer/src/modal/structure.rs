//! Bars in their own modes, with springs and dashpots attached.
//!
//! In the mass-normalised modes of the free bars (the *free modes*), the motion obeys
//!
//! ```text
//! q_i'' + beta w_i^2 q_i' + w_i^2 q_i = - sum_a phi_{a,i} (k_a u_a + c_a u_a') + load_i,
//! u_a = phi_a . q
//! ```

use crate::numerics::kernel::inner_product;

/// Bars in their own modes, and their attachments.
#[derive(Clone, Debug)]
pub struct Structure<'a> {
    /// Squared frequencies of the free modes, rad2/s2.
    pub omega2: &'a [f64],
    /// Kelvin-Voigt damping time, s.
    pub beta: f64,
    /// Springs and dashpots of any stiffness and viscosity; at most four.
    pub attachments: Vec<Attachment<'a>>,
    /// Springs between neighbouring bodies that are damped like the bars: `c = beta k`.
    pub proportional: Vec<Attachment<'a>>,
    /// The uniform translation of all bodies, if only a dashpot to the ground resists it.
    pub sliding: Option<&'a [f64]>,
}

/// A spring and dashpot acting on the displacement `shape . q`.
#[derive(Clone, Copy, Debug)]
pub struct Attachment<'a> {
    /// Modal amplitudes of the point (or of the difference of two points), kg^-1/2.
    pub shape: &'a [f64],
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Viscosity, N s/m.
    pub viscosity: f64,
}

impl<'a> Structure<'a> {
    /// Bars to which nothing is attached.
    pub fn free(omega2: &'a [f64], beta: f64) -> Self {
        Self { omega2, beta, attachments: Vec::new(), proportional: Vec::new(), sliding: None }
    }

    /// `C q`, where the damping matrix `C` includes the dashpots.
    pub(crate) fn damped(&self, q: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> =
            self.omega2.iter().zip(q).map(|(w2, x)| self.beta * w2 * x).collect();
        for a in self.attachments.iter().chain(&self.proportional) {
            let force = a.viscosity * inner_product(a.shape, q);
            out.iter_mut().zip(a.shape).for_each(|(o, s)| *o += force * s);
        }
        out
    }
}
