//! Loose joints of a drill string in closed form: a wave, and a pulse.
//!
//! While the faces of two rods of impedance `Z` do not touch, each is a free end: a wave of force `F` moves them
//! apart, or together, at `2 F/Z`, and is fully reflected. After the time `tc` with `2/Z int F dt = d` the travel `d`
//! is used up. Then the joint yields by `y` and transmits `f`:
//!
//! ```text
//! y' = 2 (F - f)/Z,  f = k y,  y(tc) = 0;   tau = Z/(2 k)
//! ```
//!
//! The momentum that a pulse leaves in the first rod is therefore the impulse `int F dt` up to `tc`. That is `d Z/2`
//! whatever the pulse's shape, if it is long enough to use up `d`. The rest is transmitted, whatever the stiffness,
//! since `y` is 0 again at the end.

/// A joint between equal rods.
#[derive(Clone, Copy, Debug)]
pub struct Loose {
    /// Impedance `Z` of either rod, N s/m.
    pub impedance: f64,
    /// Stiffness `k`, N/m.
    pub stiffness: f64,
}

impl Loose {
    /// Time at which a wave of force `rate t^2` has used up a travel, s after its arrival.
    pub fn closing(&self, rate: f64, way: f64) -> f64 {
        (1.5 * way * self.impedance / rate).cbrt()
    }

    /// Time constant `tau`, s.
    pub fn delay(&self) -> f64 {
        0.5 * self.impedance / self.stiffness
    }

    /// Force that is transmitted of that wave, N, some time after its arrival, if the joint closed at `closed`.
    pub fn passed(&self, rate: f64, time: f64, closed: f64) -> f64 {
        if time < closed {
            return 0.0;
        }
        let tau = self.delay();
        // The force of a joint that was always closed; the difference at `closed` decays.
        let following = |t: f64| t * t - 2.0 * tau * t + 2.0 * tau * tau;
        rate * (following(time) - following(closed) * (-(time - closed) / tau).exp())
    }
}

/// Momentum that a pulse leaves in its rod, N s; `way` is the travel that faces or thread have left.
pub fn trapped(momentum: f64, impedance: f64, way: f64) -> f64 {
    momentum.min(0.5 * way * impedance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transmitted force satisfies the joint's equation by finite differences. It is zero before the joint
    /// closes, and the wave itself for a stiff joint.
    #[test]
    fn what_passes_solves_the_joints_equation() {
        let (rate, way) = (3e12, 1e-4);
        let joint = Loose { impedance: 5e4, stiffness: 2e9 };
        let closed = joint.closing(rate, way);
        // 2/Z times the integral of F.
        let gone = 2.0 / joint.impedance * rate * closed.powi(3) / 3.0;
        assert!((gone - way).abs() < 1e-15 * way, "{gone}");
        assert_eq!(joint.passed(rate, 0.999 * closed, closed), 0.0);
        // y from f, integrated by Simpson's rule with 2000 steps.
        let (steps, end) = (2000, closed + 5.0 * joint.delay());
        let step = (end - closed) / f64::from(steps);
        let rise = |i: i32| {
            let t = closed + step * f64::from(i);
            2.0 * (rate * t * t - joint.passed(rate, t, closed)) / joint.impedance
        };
        let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { 2.0 + f64::from(2 * (i % 2)) };
        let y = (0..=steps).map(|i| weight(i) * rise(i)).sum::<f64>() * step / 3.0;
        let (force, exact) = (joint.stiffness * y, joint.passed(rate, end, closed));
        assert!((force - exact).abs() < 1e-9 * exact, "{force} {exact}");
        let stiff = Loose { stiffness: 1e20, ..joint };
        let all = stiff.passed(rate, end, closed);
        assert!((all - rate * end * end).abs() < 1e-9 * all, "{all}");
    }

    #[test]
    fn no_more_is_trapped_than_there_is() {
        assert_eq!(trapped(2.0, 4.0, 0.5), 1.0);
        assert_eq!(trapped(2.0, 4.0, 5.0), 2.0);
    }
}
