//! Stepped bars by characteristics on a lattice: every section is a whole number of cells, and
//! a wave passes one cell a tick. Where impedance changes from `Z1` to `Z2` a velocity wave goes
//! on as `2 Z1 / (Z1 + Z2)` of itself and comes back as `(Z1 - Z2) / (Z1 + Z2)`.
//!
//! A piston strikes a bit so long that nothing returns from its lower end; what goes down it
//! then meets a line of loading, `F' = (2 F_i - F) / tau`, `tau = Z / KR`.

/// Forces over `rho c v0` that a piston sends into a long bit of area 1, a tick each.
///
/// Sections are areas of one cell each, top to bottom. The faces stay together while they are
/// pressed: a negative force would end it.
pub fn incident(piston: &[f64], ticks: usize) -> Vec<f64> {
    let n = piston.len();
    // Particle velocity is `down + up`, force `A (down - up)`; half each of the piston's 1.
    let (mut down, mut up) = (vec![0.5; n], vec![0.5; n]);
    let mut forces = Vec::with_capacity(ticks);
    let mut together = true;
    for _ in 0..ticks {
        // The upper end is free: what comes up goes down.
        let (mut below, mut above) = (vec![up[0]; n], vec![0.0; n]);
        for i in 0..n - 1 {
            let (a, b) = (piston[i], piston[i + 1]);
            below[i + 1] = (2.0 * a * down[i] + (b - a) * up[i + 1]) / (a + b);
            above[i] = ((a - b) * down[i] + 2.0 * b * up[i + 1]) / (a + b);
        }
        // Into the bit, which sends nothing back; or off a free end.
        let (a, arriving) = (piston[n - 1], down[n - 1]);
        let force = 2.0 * a / (a + 1.0) * arriving;
        together &= force >= 0.0;
        above[n - 1] = if together { (a - 1.0) / (a + 1.0) * arriving } else { arriving };
        forces.push(if together { force } else { 0.0 });
        (down, up) = (below, above);
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
            let found = of_piston(&[1.0; 5], b);
            assert!((found - pulse(b, f64::INFINITY)).abs() < 1e-14, "{b}: {found}");
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
        let (left, back) = (0.5 * mass - energy, 0.5 * (momentum - mass).powi(2) / mass);
        assert!(left >= back && left < 0.05 * mass, "{left} {back}");
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
            let found = efficiency(&forces, tau, energy);
            assert!((found - of_exponential(duration, 1.0)).abs() < 1e-8, "{duration}: {found}");
            assert!(found > before);
            before = found;
        }
        assert!(before > 0.999);
    }
}
