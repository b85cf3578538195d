//! How one section of a stepped body changes what the body does.
//!
//! A tangent does not follow the modes as they turn: near-coincident ones would turn by any angle.
//! It stays in the body's own modes as they are, `u = Phi (1 + dS) y`, where a section's mass and
//! stiffness change by their shares `M_k`, `K_k` of the identity and of `W = diag(omega^2)`:
//!
//! ```text
//! d ln A_k:  dM = M_k, dK = K_k              d ln L_k:  dM = M_k, dK = -K_k
//! ```
//!
//! Ends stay the same numbers of `y`; means would not, as the mass moves. `dS = -z s`, with
//! `s_j = dM_0j` (`j > 0`) and `z` the quadratic-like shape, of mean 1, that rests at both ends, sees
//! to that: `z_j = (a top_j + b bottom_j) / omega_j^2`. Then
//!
//! ```text
//! M' = dM + dS + dS^T,   K' = dK + W dS + dS^T W,
//! dy'' = -M' (y'' without weight) - K' (y + beta y')
//! ```
//!
//! and the rigid mode stays by itself. The loads' weights stay the same numbers too, but for the
//! driving force, which is spread like the mass.

use crate::bodies::bar::Bar;
use crate::modal::model::Model;
use crate::numerics::kernel::inner_product;
use crate::quantities::sections::Body;
use crate::tangent::seed::Dimension;

/// `M'` and `K'` of a body, row by row.
#[derive(Debug)]
pub(crate) struct Reshape {
    pub body: Body,
    pub mass: Vec<f64>,
    pub stiffness: Vec<f64>,
    modes: usize,
}

impl Reshape {
    /// By a dimension of a section; `None` of a body that is not on splines.
    pub(crate) fn of(
        model: &Model,
        body: Body,
        index: usize,
        dimension: Dimension,
    ) -> Option<Self> {
        let bar = if body == Body::Piston { &model.piston } else { &model.bit };
        let [mut mass, mut stiffness] = bar.shares(index)?;
        let section = *model.parameters.sections(body).as_slice().get(index)?;
        let (own, sign) = match dimension {
            Dimension::Length => (section.length, -1.0),
            Dimension::Area => (section.area, 1.0),
        };
        let material = &model.parameters.material;
        mass.iter_mut().for_each(|m| *m *= material.density / own);
        stiffness.iter_mut().for_each(|k| *k *= sign * material.youngs_modulus / own);
        let modes = bar.len();
        let mut moved = mass[..modes].to_vec();
        moved[0] = 0.0;
        // W z and z.
        let (pulled, shape) = resting(bar)?;
        for i in 0..modes {
            for j in 0..modes {
                let at = i * modes + j;
                mass[at] -= shape[i] * moved[j] + moved[i] * shape[j];
                stiffness[at] -= pulled[i] * moved[j] + moved[i] * pulled[j];
            }
        }
        for j in 1..modes {
            // What is zero by the choice of `z`.
            (mass[j], mass[j * modes]) = (0.0, 0.0);
        }
        Some(Self { body, mass, stiffness, modes })
    }

    /// Change of the accelerations of the body: `y''` without weight, `y + beta y'`.
    pub(crate) fn accelerations(&self, pushed: &[f64], strained: &[f64], out: &mut [f64]) {
        let rows = self.mass.chunks_exact(self.modes).zip(self.stiffness.chunks_exact(self.modes));
        for (o, (m, k)) in out.iter_mut().zip(rows) {
            *o -= inner_product(m, pushed) + inner_product(k, strained);
        }
    }

    /// `y.M' y`.
    pub(crate) fn weighed(&self, y: &[f64]) -> f64 {
        form(&self.mass, y)
    }

    /// `y.K' y`.
    pub(crate) fn strained(&self, y: &[f64]) -> f64 {
        form(&self.stiffness, y)
    }
}

fn form(matrix: &[f64], y: &[f64]) -> f64 {
    let rows = matrix.chunks_exact(y.len()).zip(y);
    rows.map(|(row, y_i)| y_i * inner_product(row, y)).sum()
}

/// `W z` and `z`; `None` if no shape rests at both ends.
fn resting(bar: &Bar) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut c = [0.0; 3];
    for ((w2, t), b) in bar.omega2.iter().zip(&bar.top).zip(&bar.bottom).skip(1) {
        c[0] += t * t / w2;
        c[1] += t * b / w2;
        c[2] += b * b / w2;
    }
    let det = c[0] * c[2] - c[1] * c[1];
    let (t, b) = (bar.top[0], bar.bottom[0]);
    let (upper, lower) = ((c[1] * b - c[2] * t) / det, (c[1] * t - c[0] * b) / det);
    if !upper.is_finite() || !lower.is_finite() {
        return None;
    }
    let mut pulled: Vec<f64> =
        bar.top.iter().zip(&bar.bottom).map(|(t, b)| upper * t + lower * b).collect();
    pulled[0] = 0.0;
    let mut shape: Vec<f64> = pulled.iter().zip(&bar.omega2).map(|(p, w2)| p / w2).collect();
    shape[0] = 1.0;
    Some((pulled, shape))
}
