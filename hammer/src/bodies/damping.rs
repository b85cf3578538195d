//! Material damping as a share of critical damping.
//!
//! If damping is proportional to stiffness, `C = beta K`, a body's mode of circular frequency `omega` has the damping
//! ratio `zeta = beta omega / 2`. The piston's first elastic mode rings longest, so its ratio describes the damping of
//! a hammer.

use crate::bodies::bar::Bar;
use crate::quantities::parameters::{Fidelity, Parameters};
use crate::quantities::sections::Body;

impl Parameters {
    /// Circular frequency of the free piston's first elastic mode on the scene's mesh, rad/s; `None` if its modes
    /// cannot be computed.
    pub fn first_elastic_frequency(&self) -> Option<f64> {
        let elastic = Self { fidelity: Fidelity::Elastic, ..*self };
        // The first mode is the rigid one.
        Bar::of(&elastic, Body::Piston)?.omega2.get(1).map(|omega2| omega2.sqrt())
    }

    /// The `material.damping_time` with which the piston's first elastic mode has the damping ratio `zeta`: `beta = 2
    /// zeta / omega`, s. `None` if the piston's modes cannot be computed.
    ///
    /// ```
    /// let mut p = hammer::Parameters::default();
    /// p.material.damping_time = p.damping_time_of(0.005).expect("modes");
    /// assert!((p.damping_ratio().expect("modes") - 0.005).abs() < 1e-15);
    /// ```
    pub fn damping_time_of(&self, ratio: f64) -> Option<f64> {
        self.first_elastic_frequency().map(|omega| 2.0 * ratio / omega)
    }

    /// Damping ratio `zeta = beta omega / 2` of the piston's first elastic mode; `None` if the piston's modes cannot be
    /// computed.
    pub fn damping_ratio(&self) -> Option<f64> {
        self.first_elastic_frequency().map(|omega| 0.5 * self.material.damping_time * omega)
    }
}
