//! Loose joints of a drill string in closed form: two rods that fly, a wave, and a pulse.
//!
//! Rods of impedance `Z` with nothing between their faces each see a free end: a wave of force `F` moves
//! them apart, or together, at `2 F/Z`, and comes back whole. Once a way `d` is used up, after the time
//! `tc` with `2/Z int F dt = d`, the joint yields by `y` and passes `f`:
//!
//! ```text
//! y' = 2 (F - f)/Z,  f = k y,  y(tc) = 0;   tau = Z/(2 k)
//! ```
//!
//! What a pulse leaves in the first rod is therefore the impulse `int F dt` up to `tc`, which is `d Z/2`
//! whatever its shape, if the pulse is long enough to use up `d`; the rest passes, however the joint
//! yields, for `y` is 0 again at the end.

/// A joint between equal rods.
#[derive(Clone, Copy, Debug)]
pub struct Loose {
    /// Impedance `Z` of either rod, N s/m.
    pub impedance: f64,
    /// Stiffness `k`, N/m.
    pub stiffness: f64,
}

impl Loose {
    /// When a wave of force `rate t^2` has used up a way, s from its arrival.
    pub fn closing(&self, rate: f64, way: f64) -> f64 {
        (1.5 * way * self.impedance / rate).cbrt()
    }

    /// Time `tau` in which it yields, s.
    pub fn delay(&self) -> f64 {
        0.5 * self.impedance / self.stiffness
    }

    /// What it passes of that wave a time after its arrival, if it closed then, N.
    pub fn passed(&self, rate: f64, time: f64, closed: f64) -> f64 {
        if time < closed {
            return 0.0;
        }
        let tau = self.delay();
        // This would pass if it had been closed for ever; what was not there at `closed` decays.
        let following = |t: f64| t * t - 2.0 * tau * t + 2.0 * tau * tau;
        rate * (following(time) - following(closed) * (-(time - closed) / tau).exp())
    }
}

/// Momentum that a pulse leaves in the rod that it comes from, N s, of all that it has; `way` is what
/// faces or thread have left to go.
pub fn trapped(momentum: f64, impedance: f64, way: f64) -> f64 {
    momentum.min(0.5 * way * impedance)
}

/// Two rigid rods that fly apart, and are thrown together by the thread and apart by the faces for ever.
#[derive(Clone, Copy, Debug)]
pub struct Flying {
    /// Reduced mass, kg.
    pub mass: f64,
    /// Stiffness of the joint, N/m.
    pub stiffness: f64,
    /// Its damping time, s.
    pub damping: f64,
    /// Its slack, m.
    pub slack: f64,
}

impl Flying {
    /// How long faces or thread hold once they are met: half a period; and the relative speed after, over
    /// that before.
    pub fn contact(&self) -> [f64; 2] {
        let free = (self.stiffness / self.mass).sqrt();
        let ratio = 0.5 * self.damping * free;
        let rate = free * (1.0 - ratio * ratio).sqrt();
        let time = std::f64::consts::PI / rate;
        [time, (-ratio * free * time).exp()]
    }

    /// The instants at which they part and meet, s, and their relative speed from then on, m/s, from
    /// where they part with a speed, at time 0.
    pub fn instants(&self, speed: f64, count: usize) -> Vec<[f64; 2]> {
        let [span, kept] = self.contact();
        let mut list = vec![[0.0, speed]];
        while list.len() < count {
            let [time, speed] = list[list.len() - 1];
            let next = match list.len() % 2 {
                1 => [time + self.slack / speed.abs(), speed],
                _ => [time + span, -kept * speed],
            };
            list.push(next);
        }
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation of the joint, by differences; nothing passes before it closes, and what passes of a
    /// stiff joint is the wave.
    #[test]
    fn what_passes_solves_the_joints_equation() {
        let (rate, way) = (3e12, 1e-4);
        let joint = Loose { impedance: 5e4, stiffness: 2e9 };
        let closed = joint.closing(rate, way);
        // 2/Z times the integral of F.
        let gone = 2.0 / joint.impedance * rate * closed.powi(3) / 3.0;
        assert!((gone - way).abs() < 1e-15 * way, "{gone}");
        assert_eq!(joint.passed(rate, 0.999 * closed, closed), 0.0);
        // y from f, and back: Simpson's rule of 2000 steps.
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
