//! A uniform bar of linear two-node elements with consistent mass, in its own modes.
//!
//! On a uniform mesh the generalised eigenproblem `K phi = omega^2 M phi` has the
//! closed form `phi_j = a cos(theta j)`,
//! `omega^2 = 6 E / (rho h^2) (1 - cos theta) / (2 + cos theta)`,
//! with `theta = i pi / n` when both ends are free and `(i + 1/2) pi / n` when the
//! lower end is clamped; it satisfies the end rows too. No eigensolver is needed,
//! and the modes are exact to rounding for any number of elements. Modes are
//! mass-normalised: `phi.M phi = 1`.

use crate::numerics::math;
use std::f64::consts::PI;

/// A bar in modal form; a rigid body is a bar with its first mode alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Mass, kg.
    pub mass: f64,
    /// Squared circular frequencies, rad2/s2, ascending; 0 is the rigid mode.
    pub omega2: Vec<f64>,
    /// Modal amplitudes at the upper end, kg^-1/2.
    pub top: Vec<f64>,
    /// Modal amplitudes at the lower end, kg^-1/2.
    pub bottom: Vec<f64>,
    angle: Vec<f64>,
}

/// Dimensions and material of a bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Density, kg/m3.
    pub density: f64,
    /// Cross section, m2.
    pub area: f64,
    /// Length, m.
    pub length: f64,
}

impl Bar {
    /// One unknown: a body of this mass.
    pub fn rigid(mass: f64) -> Self {
        let a = 1.0 / mass.sqrt();
        Self { mass, omega2: vec![0.0], top: vec![a], bottom: vec![a], angle: vec![0.0] }
    }

    /// Both ends free: `elements + 1` modes, the first rigid.
    pub fn free(section: Section, elements: usize) -> Self {
        Self::with_angles(section, elements, 0.0, elements + 1)
    }

    /// Lower end clamped: `elements` modes, none rigid.
    pub fn clamped(section: Section, elements: usize) -> Self {
        let mut bar = Self::with_angles(section, elements, 0.5, elements);
        bar.bottom.fill(0.0);
        bar
    }

    fn with_angles(section: Section, elements: usize, offset: f64, modes: usize) -> Self {
        let n = elements as f64;
        let h = section.length / n;
        let mass = section.density * section.area * section.length;
        let stiffness = 6.0 * section.youngs_modulus / (section.density * h * h);
        let mut bar = Self {
            mass,
            omega2: Vec::with_capacity(modes),
            top: Vec::with_capacity(modes),
            bottom: Vec::with_capacity(modes),
            angle: Vec::with_capacity(modes),
        };
        for i in 0..modes {
            let theta = (i as f64 + offset) * PI / n;
            let half = math::sin(theta / 2.0);
            // 2 + cos theta, and 1 - cos theta without cancellation.
            let (inertia, elastic) = (3.0 - 2.0 * half * half, 2.0 * half * half);
            let ends_only = theta == 0.0 || i == elements;
            let sum = if ends_only { n } else { n / 2.0 };
            let amplitude = 1.0 / (mass / n / 3.0 * inertia * sum).sqrt();
            bar.omega2.push(stiffness * elastic / inertia);
            bar.top.push(amplitude);
            bar.bottom.push(if i % 2 == 0 { amplitude } else { -amplitude });
            bar.angle.push(theta);
        }
        bar
    }

    /// Number of modes.
    pub fn len(&self) -> usize {
        self.omega2.len()
    }

    /// True if the bar has no mode (never, for a bar made here).
    pub fn is_empty(&self) -> bool {
        self.omega2.is_empty()
    }

    /// Values at the nodes, top to bottom, of two fields given by their modal coordinates.
    ///
    /// A mode's cosines come by rotation from node to node: a sine and a cosine a mode, not
    /// one a mode and node, with an error of a rounding a node.
    pub fn nodal(&self, first: &[f64], second: &[f64]) -> Vec<[f64; 2]> {
        let mut nodes = vec![[0.0; 2]; self.len()];
        for (mode, (top, angle)) in self.top.iter().zip(&self.angle).enumerate() {
            let (a, b) = (top * first[mode], top * second[mode]);
            let (sin, cos) = math::sin_cos(*angle);
            let (mut c, mut s) = (1.0, 0.0);
            for node in &mut nodes {
                node[0] += a * c;
                node[1] += b * c;
                (c, s) = (c * cos - s * sin, s * cos + c * sin);
            }
        }
        nodes
    }

    /// Amplitude of mode `mode` at node `node` (0 is the upper end), kg^-1/2.
    pub fn shape(&self, mode: usize, node: usize) -> f64 {
        self.top[mode] * math::cos(self.angle[mode] * node as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Section =
        Section { youngs_modulus: 210e9, density: 7850.0, area: 2.6e-3, length: 0.168 };

    /// `(K - omega^2 M) phi` row by row, over `omega^2 M phi`'s size: rounding of a
    /// few operations on numbers of the size of K, i.e. a few 1e-16 of `K phi`.
    #[test]
    fn closed_form_modes_satisfy_the_finite_element_equations() {
        for (bar, last) in [(Bar::free(STEEL, 7), 7), (Bar::clamped(STEEL, 7), 6)] {
            let h = STEEL.length / 7.0;
            let (k, m) =
                (STEEL.youngs_modulus * STEEL.area / h, STEEL.density * STEEL.area * h / 6.0);
            for mode in 0..bar.len() {
                let u = |j: usize| bar.shape(mode, j);
                for j in 0..=last {
                    let (mut ku, mut mu) = (0.0, 0.0);
                    if j > 0 {
                        ku += k * (u(j) - u(j - 1));
                        mu += m * (2.0 * u(j) + u(j - 1));
                    }
                    if j < 7 {
                        ku += k * (u(j) - u(j + 1));
                        mu += m * (2.0 * u(j) + u(j + 1));
                    }
                    let residual = ku - bar.omega2[mode] * mu;
                    assert!(residual.abs() < 1e-14 * k * bar.top[mode], "{mode} {j} {residual}");
                }
            }
        }
    }

    #[test]
    fn nodal_values_are_sums_of_shapes() {
        let bar = Bar::free(STEEL, 400);
        let first: Vec<f64> = (0..bar.len()).map(|i| f64::from(i as u32).sin()).collect();
        let second: Vec<f64> = (0..bar.len()).map(|i| 1.0 / (1.0 + i as f64)).collect();
        for (node, found) in bar.nodal(&first, &second).iter().enumerate() {
            for (found, q) in found.iter().zip([&first, &second]) {
                let sum: f64 = q.iter().enumerate().map(|(i, q)| q * bar.shape(i, node)).sum();
                let size: f64 = q.iter().enumerate().map(|(i, q)| (q * bar.top[i]).abs()).sum();
                // Rounding of a rotation a node; in `shape`, of an angle of up to node pi.
                let bound = (2.0 + 4.0) * (node + 1) as f64 * f64::EPSILON * size;
                assert!((found - sum).abs() <= bound, "{node}: {found} {sum}");
            }
        }
    }

    #[test]
    fn modes_are_mass_normalised() {
        let bar = Bar::free(STEEL, 4);
        let m = STEEL.density * STEEL.area * STEEL.length / 4.0 / 6.0;
        for mode in 0..bar.len() {
            let u = |j: usize| bar.shape(mode, j);
            let sum: f64 =
                (0..4).map(|j| 2.0 * m * (u(j).powi(2) + u(j) * u(j + 1) + u(j + 1).powi(2))).sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }
}
