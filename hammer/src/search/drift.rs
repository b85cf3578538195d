//! The drift of a guard: its polynomial part, which consists of the static deflection under the loads and of the
//! translation.

use crate::modal::system::TAYLOR;
use crate::numerics::poly::{Poly, TERMS};
use crate::search::window::step_below;

/// Longest step for a drift of high degree, s.
pub(crate) const LONG: f64 = 1e-3;

const _: () = assert!(TERMS <= TAYLOR);

/// A polynomial of time, stored according to its degree.
#[derive(Clone, Debug)]
pub(crate) enum Drift {
    Still(f64),
    Parabola([f64; 3]),
    /// A polynomial of higher degree, which occurs if an input has derivatives.
    High(Box<High>),
}

#[derive(Clone, Debug)]
pub(crate) struct High {
    pub poly: Poly,
    /// Bound on `|p''|` for as long as the polynomial is valid; `None` if it is valid for longer than the longest step.
    bend: Option<f64>,
}

impl Drift {
    /// The drift that is a parabola with these coefficients.
    #[inline]
    pub fn parabola(c: [f64; 3]) -> Self {
        if c[1] == 0.0 && c[2] == 0.0 { Self::Still(c[0]) } else { Self::Parabola(c) }
    }

    /// The drift that is this polynomial.
    #[inline]
    pub fn new(poly: Poly) -> Self {
        let [c0, c1, c2, rest @ ..] = &poly.0;
        if rest.iter().all(|&c| c == 0.0) {
            Self::parabola([*c0, *c1, *c2])
        } else {
            Self::High(Box::new(High { poly, bend: None }))
        }
    }

    /// The same drift, if it is only valid up to `reach`.
    #[inline]
    pub fn within(mut self, reach: f64) -> Self {
        if let Self::High(high) = &mut self
            && reach <= LONG
        {
            high.bend = Some(curvature(&high.poly.0, high.poly.degree(), reach));
        }
        self
    }

    #[inline]
    pub fn constant(&self) -> Option<f64> {
        if let Self::Still(c) = self { Some(*c) } else { None }
    }

    /// True if the degree is higher than 2, which occurs if an input has derivatives.
    #[inline]
    pub fn is_high(&self) -> bool {
        matches!(self, Self::High(_))
    }

    /// True if the bounds of [`Self::bends`] hold for as long as the drift is valid, not only for the given span.
    #[inline]
    pub fn is_bounded(&self) -> bool {
        !matches!(self, Self::High(high) if high.bend.is_none())
    }

    /// The first three coefficients.
    #[inline]
    pub fn start(&self) -> [f64; 3] {
        match self {
            Self::Still(c) => [*c, 0.0, 0.0],
            Self::Parabola(c) => *c,
            Self::High(high) => [high.poly.0[0], high.poly.0[1], high.poly.0[2]],
        }
    }

    /// Value and rate at `t`.
    #[inline(always)]
    pub fn at(&self, t: f64) -> [f64; 2] {
        match self {
            Self::Still(c) => [*c, 0.0],
            Self::Parabola(c) => parabola_at(c, t),
            Self::High(high) => high_at(&high.poly, t),
        }
    }

    /// Subtracts a constant.
    pub fn lower(&mut self, constant: f64) {
        match self {
            Self::Still(c) | Self::Parabola([c, ..]) => *c -= constant,
            Self::High(high) => high.poly.0[0] -= constant,
        }
    }

    /// Bound on the rounding of a value up to `t`, and on that of the coefficients shifted to `t`.
    pub fn rounding(&self, t: f64) -> f64 {
        f64::EPSILON
            * match self {
                Self::Still(c) => c.abs(),
                Self::Parabola(c) => 3.0 * (c[0].abs() + t * (c[1].abs() + t * c[2].abs())),
                Self::High(high) => {
                    let poly = &high.poly;
                    // This bounds the number of terms and operations.
                    let count = (poly.degree() + 1) as f64;
                    count * poly.0.iter().rev().fold(0.0, |sum, c| sum * t + c.abs())
                }
            }
    }

    /// Coefficients of the polynomial in `(time - t) / h`.
    pub fn expand(&self, t: f64, h: f64) -> [f64; TAYLOR] {
        let mut q = [0.0; TAYLOR];
        match self {
            Self::Still(c) => q[0] = *c,
            Self::Parabola(c) => {
                let [value, rate] = parabola_at(c, t);
                (q[0], q[1], q[2]) = (value, h * rate, h * h * c[2]);
            }
            Self::High(high) => q[..TERMS].copy_from_slice(&high.poly.shifted(t).scaled(h).0),
        }
        q
    }

    /// How long the drift stays below `-margin` after `t`, at which it has this value and rate. For a drift of high
    /// degree the result is at most `long`.
    pub fn step_below(&self, margin: f64, (t, [value, rate]): (f64, [f64; 2]), long: f64) -> f64 {
        let room = -margin - value;
        if room.is_nan() || room <= 0.0 {
            return 0.0;
        }
        match self {
            Self::Still(_) => f64::INFINITY,
            Self::Parabola(c) => step_below(room, rate, 2.0 * c[2]),
            Self::High(high) => step_below(room, rate, high.bend(t, long)).min(long),
        }
    }

    /// Two bounds that are valid from `t` on, or for a drift of high degree from `t` to `t + long`. The first bounds
    /// the second derivative from above and is not negative. The sum of both bounds its magnitude.
    #[inline]
    pub fn bends(&self, t: f64, long: f64) -> [f64; 2] {
        match self {
            Self::Still(_) => [0.0; 2],
            Self::Parabola(c) => [(2.0 * c[2]).max(0.0), (-2.0 * c[2]).max(0.0)],
            Self::High(high) => [high.bend(t, long), 0.0],
        }
    }
}

/// Value and rate of a polynomial of high degree. This is not inlined, so that its callers are short enough to be
/// inlined.
#[inline(never)]
fn high_at(poly: &Poly, t: f64) -> [f64; 2] {
    let coefficients = poly.0[..=poly.degree()].iter().rev();
    coefficients.fold([0.0; 2], |[value, rate], c| [value * t + c, rate * t + value])
}

fn parabola_at(c: &[f64; 3], t: f64) -> [f64; 2] {
    [c[0] + t * (c[1] + t * c[2]), c[1] + 2.0 * t * c[2]]
}

impl High {
    /// Bound on `|p''|` from `t` to `t + span`, as far as the polynomial is valid.
    fn bend(&self, t: f64, span: f64) -> f64 {
        let whole = || curvature(&self.poly.shifted(t).0, self.poly.degree(), span);
        self.bend.unwrap_or_else(whole)
    }
}

/// Bound on `|p''|` from 0 to `span`.
fn curvature(p: &[f64; TERMS], degree: usize, span: f64) -> f64 {
    let terms = (2..=degree).rev().map(|k| (k * (k - 1)) as f64 * p[k].abs());
    terms.fold(0.0, |sum, term| sum * span + term)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drifts of every kind, whose terms cancel near 0.4.
    fn drifts() -> [Drift; 4] {
        let mut high = Poly::default();
        high.0[..5].copy_from_slice(&[0.3, -1.0, 0.4, 0.7, -0.5]);
        let parabolas = [[-0.7, 0.0, 0.0], [0.2, -1.1, 1.5], [-0.2, 1.1, -1.5]];
        let [still, up, down] = parabolas.map(Drift::parabola);
        [still, up, down, Drift::new(high)]
    }

    /// The error of a value is below its bound, and the bound is not larger than needed by orders of magnitude.
    #[test]
    fn a_value_is_known_to_its_bound_on_rounding() {
        for drift in drifts() {
            for t in [0.0, 0.1, 0.4, 3.0_f64] {
                let c = match &drift {
                    Drift::High(high) => high.poly.0,
                    other => std::array::from_fn(|k| *other.start().get(k).unwrap_or(&0.0)),
                };
                let terms: Vec<f64> = (0..TERMS).map(|k| c[k] * t.powi(k as i32)).collect();
                let sum = terms.iter().map(|term| term.abs()).sum::<f64>() * f64::EPSILON;
                let bound = drift.rounding(t);
                assert!((drift.at(t)[0] - terms.iter().sum::<f64>()).abs() <= bound);
                assert!(sum <= bound && bound <= 5.1 * sum, "{drift:?} {t}: {bound} {sum}");
            }
        }
    }

    /// During a step the drift stays below the margin, and its second derivative stays within the bounds.
    #[test]
    fn a_drift_is_below_its_margin_for_the_step_and_bends_no_more_than_it_says() {
        let mut parabolas = 0;
        for mut drift in drifts() {
            drift.lower(1.0);
            for (t, margin) in [0.0, 0.3, 0.9].into_iter().flat_map(|t| [0.1, 0.7].map(|m| (t, m)))
            {
                let (step, long) = (drift.step_below(margin, (t, drift.at(t)), 0.4), 0.4);
                let is_below = drift.at(t)[0] < -margin;
                assert_eq!(step > 0.0, is_below, "{drift:?} {t} {margin}");
                let [rise, fall] = drift.bends(t, long);
                for i in 0..=100 {
                    let part = f64::from(i) / 100.0;
                    let x = t + part * step.min(long);
                    assert!(!is_below || drift.at(x)[0] <= -margin + 1e-12, "{drift:?} {t} {x}");
                    let h = 1e-4;
                    let [before, now, after] =
                        [-h, 0.0, h].map(|d| drift.at(t + part * long + d)[0]);
                    // The difference quotient has errors of some 1e-16 / h^2 and h^2.
                    let bend = (before - 2.0 * now + after) / (h * h);
                    assert!(
                        (-rise - fall - 1e-6..=rise + 1e-6).contains(&bend),
                        "{drift:?} {bend}"
                    );
                }
                // A parabola reaches its margin at the end of the step.
                if let (Drift::Parabola(_), true) = (&drift, 0.0 < step && step < f64::INFINITY) {
                    assert!((drift.at(t + step)[0] + margin).abs() < 1e-12, "{drift:?} {t}");
                    parabolas += 1;
                }
            }
        }
        assert!(parabolas >= 2, "{parabolas}");
    }

    /// The coefficients of a window reproduce the drift, in time over the window's length.
    #[test]
    fn a_drift_is_expanded_about_the_start_of_a_window() {
        for drift in drifts() {
            let (t, h) = (0.3, 0.2);
            let q = drift.expand(t, h);
            for x in [0.0, 0.5, 1.0] {
                let value = q.iter().rev().fold(0.0, |sum, c| sum * x + c);
                let bound = 4.0 * drift.rounding(t + h);
                assert!((value - drift.at(t + x * h)[0]).abs() <= bound, "{drift:?} {x}");
            }
        }
    }
}
