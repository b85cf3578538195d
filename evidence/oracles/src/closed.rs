//! Closed forms and published numbers of one blow. Lengths in `Lp`, times in `T1 = Lp / c0`,
//! forces in `Z v0`, `kappa = KR Lp / (E A)`.

/// Collision of two free bars of equal section, `bit = Lb / Lp` (St-Venant).
#[derive(Clone, Copy, Debug)]
pub struct TwoBars {
    /// Time under force.
    pub push: f64,
    /// Impulse over `Mp v0`.
    pub impulse: f64,
    /// Mean velocities after, over `v0`.
    pub after: [f64; 2],
}

/// See [`TwoBars`].
pub fn two_bars(bit: f64) -> TwoBars {
    let short = bit.min(1.0);
    TwoBars { push: 2.0 * short, impulse: short, after: [1.0 - short, short / bit] }
}

/// A free bar on a linear spring `k = K L / (E A)`: `k`, largest force, contact time
/// (d'Alembert; to the digits printed).
pub const BAR_ON_SPRING: [[f64; 3]; 6] = [
    [0.05, 0.22171, 14.170],
    [0.2, 0.43045, 7.248],
    [0.5, 0.66397, 4.804],
    [1.0, 0.86914, 3.637],
    [2.0, 0.98177, 2.836],
    [5.0, 0.99995, 2.336],
];

/// Energy that rock keeps of a rectangular pulse in a long bit, over the piston's:
/// `2 (1 - e^-b)^2 / b (1 - 1 / gamma)` with `b = 2 kappa`.
pub fn pulse(b: f64, gamma: f64) -> f64 {
    2.0 * (1.0 - (-b).exp()).powi(2) / b * (1.0 - 1.0 / gamma)
}

/// `b` at which this share is largest, and the share without the factor of `gamma`, to the digits printed.
pub const BEST_PULSE: [f64; 2] = [1.25643, 0.814529];

/// Equal bars, one blow on virgin rock (exact waves, good to five digits): `kappa`, `gamma`,
/// `eta`, largest rock force, piston's mean velocity after the second collision over `v0`,
/// start of that collision.
pub const BLOWS: [[f64; 6]; 5] = [
    [0.03, 5.0, 0.79186, 0.17232, -0.45615, 22.16],
    [0.1, 5.0, 0.77306, 0.31086, -0.47517, 11.59],
    [0.1, 10.0, 0.86969, 0.31086, -0.35953, 12.89],
    [0.3, 5.0, 0.72120, 0.52005, -0.52414, 6.317],
    [1.0, 5.0, 0.60433, 0.86914, -0.58976, 3.594],
];
