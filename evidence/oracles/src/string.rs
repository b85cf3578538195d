//! A blow's wave down a drill string, in closed form, until something comes back from its ends.
//!
//! A sleeve of impedance `r Z` and transit `T` between rods of `Z` lets the part `tau = 4 r/(1 + r)^2`
//! of a wave through at once, and what runs to and fro in it once more after each `2 T`, times
//! `q = ((r - 1)/(r + 1))^2` (the transfer matrix of a layer, as a series). Of `n` alike the parts that
//! are late by `2 k T` add up to
//!
//! ```text
//! tau^n (n + k - 1 over k) q^k
//! ```
//!
//! A short heavy one is a mass `m`, and a step becomes `1 - exp(-2 Z t/m)`. Lundberg 1987 (Int. J. Rock
//! Mech. Min. Sci. 24:213) has the same model of extension rods: rods of the piston's impedance, and
//! joints by their length and impedance.

/// Joints between equal rods.
#[derive(Clone, Copy, Debug)]
pub struct Joints {
    /// How many.
    pub count: usize,
    /// A joint's impedance over the rods'.
    pub ratio: f64,
    /// Transit of a joint over the piston's.
    pub transit: f64,
}

/// Parts that are left out add up to less than this.
const LEAST: f64 = 1e-15;

impl Joints {
    /// Delays after the straight way, in transits of the piston, and parts of the force.
    fn parts(&self) -> Vec<[f64; 2]> {
        let (r, n) = (self.ratio, self.count as f64);
        let again = ((r - 1.0) / (r + 1.0)).powi(2);
        let (mut part, mut left) = ((1.0 - again).powi(self.count as i32), 1.0);
        let mut list = Vec::new();
        let mut k = 0.0;
        while left > LEAST && part > 0.0 {
            list.push([2.0 * k * self.transit, part]);
            left -= part;
            k += 1.0;
            part *= again * (n + k - 1.0) / k;
        }
        list
    }

    /// Force below all joints at a time after the wave's arrival, over `Z v0`; times in transits of the
    /// piston. See [`sent`] for `front`.
    pub fn force(&self, time: f64, front: f64) -> f64 {
        self.parts().iter().map(|[late, part]| part * sent(time - late, front)).sum()
    }

    /// Energy of that wave over the piston's, of a sharp front: a product of pulses lasts as long as they
    /// overlap.
    pub fn energy(&self) -> f64 {
        let parts = self.parts();
        let overlap =
            |a: &[f64; 2], b: &[f64; 2]| a[1] * b[1] * (2.0 - (a[0] - b[0]).abs()).max(0.0);
        // Whole, it is 2 transits times (Z v0 / 2)^2 / Z, which is all that the piston had.
        0.5 * parts.iter().map(|a| parts.iter().map(|b| overlap(a, b)).sum::<f64>()).sum::<f64>()
    }
}

/// Force that a uniform piston sends into a rod of its impedance through a contact of stiffness `KC`,
/// over `Z v0`: `1/2` for two transits, if the front `Z/(2 KC)` is sharp. A wave that comes up to the
/// contact goes through as `h = 1 - exp(-t/front)` of a step; that from the piston's free end has gone
/// through a like one before, which makes it `h * h' = 1 - (1 + t/front) exp(-t/front)`. The sum never
/// pulls; it holds for four transits. Times in transits of the piston, from the strike or the wave's
/// arrival.
pub fn sent(time: f64, front: f64) -> f64 {
    let age =
        |since: f64| if front > 0.0 { (time - since).max(0.0) / front } else { f64::INFINITY };
    let step =
        |x: f64, once: f64| if x.is_finite() { 1.0 - (1.0 + once * x) * (-x).exp() } else { 1.0 };
    let after = |since: f64, once: f64| if time < since { 0.0 } else { step(age(since), once) };
    0.5 * (after(0.0, 0.0) - after(2.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_joints_or_with_joints_like_rods_the_wave_stays() {
        for joints in [
            Joints { count: 0, ratio: 3.0, transit: 0.4 },
            Joints { count: 5, ratio: 1.0, transit: 0.4 },
        ] {
            assert!((joints.energy() - 1.0).abs() < 1e-14);
            assert_eq!([-0.1, 0.1, 1.9, 2.1].map(|t| joints.force(t, 0.0)), [0.0, 0.5, 0.5, 0.0]);
        }
    }

    /// A joint of vanishing length and given mass: `1 - exp(-2 Z t/m)`, here with `m/Z` of a transit.
    #[test]
    fn a_short_heavy_joint_is_a_mass() {
        for ratio in [1e2, 1e3] {
            // Mass over Z is the transit times the ratio.
            let joints = Joints { count: 1, ratio, transit: 1.0 / ratio };
            for time in [0.3_f64, 1.0, 1.7] {
                let mass = 0.5 * (1.0 - (-2.0 * time).exp());
                // Steps a transit to and fro apart, and terms of the order of 1 over the ratio.
                assert!((joints.force(time, 0.0) - mass).abs() < 2.0 / ratio, "{ratio} {time}");
            }
        }
    }

    /// The impulse is the piston's momentum, and what a soft contact takes back when the wave comes up
    /// again; joints only delay it. The energy of a sharp front is the sum over the force.
    #[test]
    fn the_impulse_is_the_pistons_momentum() {
        let joints = Joints { count: 3, ratio: 2.1, transit: 0.3 };
        let sum = |f: &dyn Fn(f64) -> f64| {
            (0..40_000).map(|i| 1e-3 * f(1e-3 * (f64::from(i) + 0.5))).sum::<f64>()
        };
        for front in [0.0, 0.2] {
            let impulse = sum(&|t| joints.force(t, front));
            // The midpoint rule on steps that are whole numbers of intervals, or on smooth pieces.
            assert!((impulse - 1.0 - 0.5 * front).abs() < 1e-6, "{front}: {impulse}");
        }
        let energy = 2.0 * sum(&|t| joints.force(t, 0.0).powi(2));
        assert!((energy - joints.energy()).abs() < 1e-9, "{energy}");
    }

    /// Two joints are one after the other: the force below is the sum over what one lets through.
    #[test]
    fn two_joints_are_one_twice() {
        let (one, two) = (
            Joints { count: 1, ratio: 2.3, transit: 0.35 },
            Joints { count: 2, ratio: 2.3, transit: 0.35 },
        );
        for time in [0.1, 0.9, 1.5, 2.2, 3.3] {
            let twice: f64 =
                one.parts().iter().map(|[late, part]| part * one.force(time - late, 0.0)).sum();
            assert!((two.force(time, 0.0) - twice).abs() < 1e-14, "{time}");
        }
    }
}
