//! Stepped bars by characteristics on a lattice: every section is a whole number of cells, and
//! a wave passes one cell a tick. Where impedance changes from `Z1` to `Z2` a velocity wave goes
//! on as `2 Z1 / (Z1 + Z2)` of itself and comes back as `(Z1 - Z2) / (Z1 + Z2)`.
//!
//! What goes down a bit so long that nothing returns from its lower end then meets a line of loading,
//! `F' = (2 F_i - F) / tau`, `tau = Z / KR`.

/// A piston of speed 1 that has met a bit at rest, both with free ends, and stays glued to it: what is said
/// is true until the contact first pulls.
pub struct Bars {
    areas: Vec<f64>,
    contact: usize,
    /// Velocity waves downward in every cell: particle velocity is `down + up`, force `A (down - up)`.
    pub down: Vec<f64>,
    /// The same upward.
    pub up: Vec<f64>,
    /// Contact force over `rho c v0`, positive where it presses.
    pub force: f64,
}

impl Bars {
    /// One area a cell, top to bottom, a tick after the strike.
    pub fn new(piston: &[f64], bit: &[f64]) -> Self {
        let areas = [piston, bit].concat();
        let half = |cell| if cell < piston.len() { 0.5 } else { 0.0 };
        let down: Vec<f64> = (0..areas.len()).map(half).collect();
        let mut bars = Self { contact: piston.len(), up: down.clone(), down, areas, force: 0.0 };
        bars.tick();
        bars
    }

    /// One transit of a cell.
    pub fn tick(&mut self) {
        let last = self.areas.len() - 1;
        let (mut down, mut up) = (vec![self.up[0]; last + 1], vec![self.down[last]; last + 1]);
        for i in 0..last {
            let (a, b) = (self.areas[i], self.areas[i + 1]);
            let (x, y) = (self.down[i], self.up[i + 1]);
            down[i + 1] = (2.0 * a * x + (b - a) * y) / (a + b);
            up[i] = ((a - b) * x + 2.0 * b * y) / (a + b);
            if i + 1 == self.contact {
                self.force = 2.0 * a * b / (a + b) * (x - y);
            }
        }
        (self.down, self.up) = (down, up);
    }
}

/// Forces over `rho c v0` that a piston sends into a long bit of area 1, a tick each, until it leaves.
pub fn incident(piston: &[f64], ticks: usize) -> Vec<f64> {
    let mut bars = Bars::new(piston, &vec![1.0; ticks]);
    let mut forces = vec![0.0; ticks];
    for force in &mut forces {
        if bars.force < 0.0 {
            break;
        }
        *force = bars.force;
        bars.tick();
    }
    forces
}

/// Lundberg's efficiency of a wave of constant forces, a tick each, in a bar of impedance 1 on
/// a line of loading with `tau` in ticks: the largest `F^2 tau / 2` over `energy`.
pub fn efficiency(forces: &[f64], tau: f64, energy: f64) -> f64 {
    let decay = (-1.0 / tau).exp();
    let mut force: f64 = 0.0;
    let mut most = 0.0f64;
    for incident in forces {
        force = 2.0 * incident + (force - 2.0 * incident) * decay;
        most = most.max(force);
    }
    0.5 * most * most * tau / energy
}

/// The same of a piston of areas over the bit's and unit speed, `b = 2 KR Lp / (E A)` with the
/// bit's `A`: over its kinetic energy.
pub fn of_piston(piston: &[f64], b: f64) -> f64 {
    let n = piston.len() as f64;
    // Lp / c is n ticks, and tau = Z / KR is 2 / b of them.
    let (tau, energy) = (2.0 * n / b, 0.5 * piston.iter().sum::<f64>());
    efficiency(&incident(piston, 8 * piston.len()), tau, energy)
}

/// What `F_i = exp(t / tau)` of a duration reaches: `1 - exp(-2 T / tau)`, which tends to 1
/// (Lundberg and Collet 2010, Int. J. Impact Eng. 37:901).
pub fn of_exponential(duration: f64, tau: f64) -> f64 {
    1.0 - (-2.0 * duration / tau).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed::{BEST_PULSE, pulse};

    /// A uniform piston sends a rectangle, and its efficiency is the closed form's.
    #[test]
    fn a_uniform_piston_is_the_closed_form() {
        for b in [0.3, BEST_PULSE[0], 4.0] {
            let share = of_piston(&[1.0; 5], b);
            assert!((share - pulse(b, f64::INFINITY)).abs() < 1e-14, "{b}: {share}");
        }
    }

    /// Energy of what is sent, and of the piston's mean motion after, are within what it had.
    #[test]
    fn a_stepped_piston_gives_no_more_than_it_has() {
        let piston = [2.0, 1.5, 1.1, 0.9, 0.8, 0.6];
        let forces = incident(&piston, 600);
        // A force lasts a tick; energy is half the mass times 1, momentum the mass.
        let mass: f64 = piston.iter().sum();
        let energy: f64 = forces.iter().map(|f| f * f).sum();
        let momentum: f64 = forces.iter().sum();
        // What is left moves the piston, and rings in it.
        let (remaining, back) = (0.5 * mass - energy, 0.5 * (momentum - mass).powi(2) / mass);
        assert!(remaining >= back && remaining < 0.05 * mass, "{remaining} {back}");
    }

    /// Steps as fine as they like to be: an exponential wave has the closed form's efficiency.
    #[test]
    fn a_growing_exponential_tends_to_one() {
        let mut before = 0.0;
        for duration in [1.0, 2.0, 4.0] {
            let ticks = 40_000;
            let tau = f64::from(ticks) / duration;
            let forces: Vec<f64> = (0..ticks).map(|i| ((f64::from(i) + 0.5) / tau).exp()).collect();
            let energy: f64 = forces.iter().map(|f| f * f).sum();
            let share = efficiency(&forces, tau, energy);
            assert!((share - of_exponential(duration, 1.0)).abs() < 1e-8, "{duration}: {share}");
            assert!(share > before);
            before = share;
        }
        assert!(before > 0.999);
    }
}
