//! A linear functional of the displacements, ready to be evaluated and bounded.

use crate::modal::generator::Generator;
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;

/// Orders of input derivatives, from the value on.
pub const ORDERS: usize = crate::MAX_INPUT_ORDER + 1;
/// Load channels: drive, feed, gravity.
pub const CHANNELS: usize = 3;
/// Order of the remainder of a Taylor window.
pub const TAYLOR: usize = 24;

/// A linear functional of the displacements, in modal coordinates.
#[derive(Clone, Debug)]
pub struct Functional {
    /// `c B^k` for k = 0 (displacement) to 3.
    pub rows: [Vec<f64>; 4],
    /// Coefficients whose product with `|y|` bounds the k-th derivative for all later times.
    pub weights: [Vec<f64>; 4],
    /// The same for derivative `k + TAYLOR`, over `rate_max^TAYLOR`, of a displacement (k = 0)
    /// and a velocity (k = 1).
    pub taylor: [Vec<f64>; 2],
    /// `c B^-1`: the integral.
    pub integral: Vec<f64>,
    /// Weight of the uniform translation.
    pub rigid: f64,
    /// `c S_j`, per channel and order.
    pub statics: [[f64; ORDERS]; CHANNELS],
}

impl Functional {
    /// From its modal coefficients `c` and the static shapes `S_j`.
    pub(crate) fn new(
        mut c: Vec<f64>,
        generator: &Generator,
        statics: &[Vec<Vec<f64>>; CHANNELS],
    ) -> Self {
        let n = generator.n;
        let rigid = if generator.rigid { c[0] } else { 0.0 };
        if generator.rigid {
            (c[0], c[n]) = (0.0, 0.0);
        }
        let r1 = generator.differentiate(&c);
        let r2 = generator.differentiate(&r1);
        let r3 = generator.differentiate(&r2);
        let rates = &generator.rates;
        let size = |i: usize, coordinate: usize| {
            if generator.is_diagonal(i) {
                c[coordinate * n + i].abs()
            } else {
                math::hypot(c[i], c[n + i])
            }
        };
        let weight = |scale: f64, power: usize| -> Vec<f64> {
            (0..2 * n)
                .map(|k| {
                    let (i, coordinate) = (k % n, k / n);
                    if i >= rates.len() {
                        return 0.0;
                    }
                    size(i, coordinate) * math::powi(rates[i][coordinate] / scale, power)
                })
                .collect()
        };
        Self {
            weights: std::array::from_fn(|k| weight(1.0, k)),
            taylor: std::array::from_fn(|k| {
                let remainder = weight(generator.rate_max, TAYLOR);
                let rate = |j: usize| rates.get(j % n).map_or(0.0, |rate| rate[j / n]);
                remainder.iter().enumerate().map(|(j, w)| w * math::powi(rate(j), k)).collect()
            }),
            integral: generator.integrate(&c),
            statics: std::array::from_fn(|ch| {
                std::array::from_fn(|j| kernel::dot(&c, &statics[ch][j]))
            }),
            rows: [c, r1, r2, r3],
            rigid,
        }
    }

    /// What is not decaying: the static part under loads, and the translation.
    pub fn poly(&self, loads: &[Poly; CHANNELS], translation: &Poly) -> Poly {
        let mut sum = Poly::default();
        for (load, statics) in loads.iter().zip(&self.statics) {
            if load.is_constant() {
                sum.0[0] += statics[0] * load.0[0];
                continue;
            }
            let mut derivative = *load;
            for s in statics {
                sum = sum.plus(*s, &derivative);
                derivative = derivative.derivative();
            }
        }
        if self.rigid != 0.0 { sum.plus(self.rigid, translation) } else { sum }
    }
}
