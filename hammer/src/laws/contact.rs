//! Piston on bit: a unilateral penalty.
//!
//! | mode | force `F_C`, N | stored energy, J | guard | direction | next |
//! |---|---|---|---|---|---|
//! | open | 0 | 0 | Q11: `g` through 0 | falling | closed |
//! | closed | `-KC g` | `KC g^2 / 2` | Q11: `g` through 0 | rising | open |
//!
//! `g = w2.u + g0` is the gap, m; `F_C` pushes the piston up and the bit down. For rigid
//! bodies `KC` is in series with the bodies' own compliance
//! ([`Parameters::meeting_stiffness`](crate::Parameters::meeting_stiffness)).

use crate::laws::event::{Direction, Displacement, Event, Guard, Quantity};
use crate::laws::rock::Coefficients;

/// The contact law at present.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// `KC` in series with the compliance that a rigid model lacks, N/m.
    pub stiffness: f64,
    /// True while the bodies touch.
    pub closed: bool,
}

impl Contact {
    /// What acts at present, on the piston.
    pub fn line(self) -> Coefficients {
        let stiffness = if self.closed { self.stiffness } else { 0.0 };
        Coefficients { stiffness, viscosity: 0.0 }
    }

    /// `F_C = -KC g`, N; for the rate of a gap, the rate of the force.
    pub fn force(self, gap: f64) -> f64 {
        -self.line().stiffness * gap
    }

    /// Q11.
    pub fn guard(self) -> Guard {
        Guard {
            quantity: Quantity::Displacement(Displacement::Gap),
            direction: if self.closed { Direction::Rising } else { Direction::Falling },
            level: 0.0,
            event: Event::Contact,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force is minus the slope of the stored energy, and never pulls. Central differences of a
    /// parabola are exact except for rounding of the two energies.
    #[test]
    fn the_force_is_the_slope_of_the_stored_energy() {
        let contact = Contact { stiffness: 1e11, closed: true };
        let (gap, step) = (-3e-6, 1e-7);
        let rise =
            contact.line().stored_energy(gap + step) - contact.line().stored_energy(gap - step);
        let rounding = 2.0 * f64::EPSILON * contact.line().stored_energy(gap - step) / step;
        assert!((rise / (2.0 * step) + contact.force(gap)).abs() <= rounding);
        assert!(contact.force(gap) > 0.0);
        assert_eq!(Contact { closed: false, ..contact }.force(gap), 0.0);
    }
}
