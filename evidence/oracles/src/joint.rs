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
