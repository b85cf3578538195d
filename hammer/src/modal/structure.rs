//! Bars in their own modes, with springs and dashpots attached.
//!
//! ```text
//! q_i'' + (beta w_i^2 + drag_i) q_i' + w_i^2 q_i = - sum_a phi_{a,i} (k_a u_a + c_a u_a') + load_i,
//! u_a = phi_a . q
//! ```
//!
//! in the mass-normalised modes of the free bars (the *free modes*).

use crate::numerics::kernel::inner_product;

/// Bars in their own modes, and their attachments.
#[derive(Clone, Debug)]
pub struct Structure<'a> {
    /// Squared frequencies of the free modes, rad2/s2.
    pub omega2: &'a [f64],
    /// Kelvin-Voigt damping time, s.
    pub beta: f64,
    /// Springs and dashpots; at most three.
    pub attachments: Vec<Attachment<'a>>,
    /// A dashpot from a rigid body to the ground.
    pub drag: Option<Drag<'a>>,
}

/// A dashpot from a rigid body to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag<'a> {
    /// The body's free mode.
    pub mode: usize,
    /// Impedance over mass, 1/s.
    pub rate: f64,
    /// The uniform translation of all bodies, if nothing else resists it.
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

impl Structure<'_> {
    /// Rate of the dashpot to the ground on a free mode, 1/s.
    pub(crate) fn drag_on(&self, mode: usize) -> f64 {
        self.drag.filter(|drag| drag.mode == mode).map_or(0.0, |drag| drag.rate)
    }

    /// `C q`, `C` the damping matrix with the dashpots.
    pub(crate) fn damped(&self, q: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> =
            self.omega2.iter().zip(q).map(|(w2, x)| self.beta * w2 * x).collect();
        for a in &self.attachments {
            let force = a.viscosity * inner_product(a.shape, q);
            out.iter_mut().zip(a.shape).for_each(|(o, s)| *o += force * s);
        }
        if let Some(drag) = self.drag {
            out[drag.mode] += drag.rate * q[drag.mode];
        }
        out
    }
}
