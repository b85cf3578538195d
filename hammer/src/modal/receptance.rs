//! Receptances of the two attachments and the secular function made of them.
//!
//! `f(s) = 1 + kappa_1 R_11 + kappa_2 R_22 + kappa_1 kappa_2 (R_11 R_22 - R_12^2)`,
//! `R_ab = sum_i phi_{a,i} phi_{b,i} / d_i(s)`.

use crate::modal::spectrum::{Merged, Root, Solver};
use crate::numerics::math::norm;
use num_complex::Complex64 as C;

/// A function of `s` and its derivative.
#[derive(Clone, Copy, Default)]
pub(crate) struct Jet {
    pub(crate) at: C,
    pub(crate) slope: C,
}

impl Jet {
    fn add(&mut self, factor: f64, other: Self) {
        self.at += factor * other.at;
        self.slope += factor * other.slope;
    }

    fn times(self, other: Self) -> Self {
        Self { at: self.at * other.at, slope: self.slope * other.at + self.at * other.slope }
    }
}

/// Receptances: those of the vibrating modes, `1 / s^2` of the bodies' translation, and
/// the sum of `twist_i / d_i` that joins the two in the determinant.
#[derive(Clone, Copy, Default)]
pub(crate) struct Receptance {
    pub(crate) r11: Jet,
    pub(crate) r12: Jet,
    pub(crate) r22: Jet,
    pub(crate) free: Jet,
    joined: Jet,
}

/// What the translations add: `sum phi_a phi_b`, and what is left of the determinant
/// `R11 R22 - R12^2` when their common `1 / s^2` has cancelled (Cauchy and Binet):
/// squares of `phi_{1,i} phi_{2,j} - phi_{2,i} phi_{1,j}`. A stiff contact between heavy
/// bodies on soft rock would lose ten digits there.
#[derive(Default)]
pub(crate) struct Translations {
    pub(crate) modes: Vec<usize>,
    /// Of each mode with all translations.
    twist: Vec<f64>,
    /// Of the translations with each other.
    own: f64,
}

impl Translations {
    pub(crate) fn new(system: &Merged) -> Self {
        let n = system.omega2.len();
        let modes: Vec<usize> = (0..n).filter(|&i| system.omega2[i] == 0.0).collect();
        let [x, y] = &system.shapes[..] else {
            return Self { modes, ..Self::default() };
        };
        let cross = |i: usize, j: usize| {
            let twist = x[i] * y[j] - y[i] * x[j];
            twist * twist
        };
        let sum = |i: usize| modes.iter().map(|&a| cross(a, i)).sum::<f64>();
        let twist: Vec<f64> = (0..n).map(sum).collect();
        let own = 0.5 * modes.iter().map(|&a| twist[a]).sum::<f64>();
        Self { modes, twist, own }
    }
}

impl Solver {
    pub(crate) fn receptance(&self, root: Root) -> Receptance {
        let mut r = Receptance::default();
        let two = self.system.shapes.len() == 2;
        for i in 0..self.system.omega2.len() {
            let (a, b) = (self.off_pole(root, 2 * i), self.off_pole(root, 2 * i + 1));
            let inverse = 1.0 / (a * b);
            let jet = Jet { at: inverse, slope: -(a + b) * inverse * inverse };
            if two && self.system.omega2[i] == 0.0 {
                r.free = jet;
                continue;
            }
            let x = self.system.shapes[0][i];
            r.r11.add(x * x, jet);
            if two {
                let y = self.system.shapes[1][i];
                r.r12.add(x * y, jet);
                r.r22.add(y * y, jet);
                r.joined.add(self.translations.twist[i], jet);
            }
        }
        r
    }

    /// `R_ab` with the translations.
    pub(crate) fn whole(&self, r: &Receptance, a: usize, b: usize) -> Jet {
        let mut sum = [r.r11, r.r12, r.r22][a + b];
        sum.add(self.moved(a, b), r.free);
        sum
    }

    /// `R11 R22 - R12^2`, by the one of two sums that loses less to cancellation: between
    /// the bars' resonances each receptance is small, below the first the translations
    /// outweigh the rest.
    fn determinant(&self, r: &Receptance, own: [Jet; 2]) -> Jet {
        let cross = self.whole(r, 0, 1);
        let size = |a: usize, b: usize| {
            let vibration = norm([r.r11, r.r12, r.r22][a + b].at);
            vibration + self.moved(a, b).abs() * norm(r.free.at)
        };
        let plain = norm(own[0].at) * size(1, 1)
            + norm(own[1].at) * size(0, 0)
            + 2.0 * norm(cross.at) * size(0, 1);
        let free = norm(r.free.at);
        let split = norm(r.r11.at * r.r22.at)
            + r.r12.at.norm_sqr()
            + free * (norm(r.joined.at) + self.translations.own * free);
        if plain <= split {
            let mut det = own[0].times(own[1]);
            det.add(-1.0, cross.times(cross));
            return det;
        }
        let mut det = r.r11.times(r.r22);
        det.add(-1.0, r.r12.times(r.r12));
        det.add(1.0, r.free.times(r.joined));
        det.add(self.translations.own, r.free.times(r.free));
        det
    }

    /// `phi_a phi_b` summed over the translations.
    pub(crate) fn moved(&self, a: usize, b: usize) -> f64 {
        let shapes = &self.system.shapes;
        self.translations.modes.iter().map(|&i| shapes[a][i] * shapes[b][i]).sum()
    }

    /// The secular function and its derivative.
    pub(crate) fn secular(&self, root: Root) -> (C, C) {
        let s = self.value(root);
        let r = self.receptance(root);
        let stiff = |a: usize| {
            let (k, c) = self.system.kappa[a];
            Jet { at: k + c * s, slope: C::new(c, 0.0) }
        };
        let first = stiff(0).times(r.r11);
        if self.system.shapes.len() == 1 {
            return (1.0 + first.at, first.slope);
        }
        let own = [self.whole(&r, 0, 0), self.whole(&r, 1, 1)];
        let det = self.determinant(&r, own);
        let mut f = stiff(0).times(own[0]);
        f.add(1.0, stiff(1).times(own[1]));
        f.add(1.0, stiff(0).times(stiff(1)).times(det));
        (1.0 + f.at, f.slope)
    }
}
