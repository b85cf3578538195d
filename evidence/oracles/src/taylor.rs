//! Taylor series of the linear system of a mode.
//!
//! With `u = sum U_k x^k`, `v = sum V_k x^k` and `x = t / UNIT`,
//!
//! ```text
//! U_{k+1} = UNIT V_k / (k + 1)
//! V_{k+1} = UNIT M^-1 (load [k = 0] - K U_k - C V_k) / (k + 1)
//! psi_{k+1} = UNIT CR sum_{i+j=k} p'_i p'_j / (k + 1)
//! ```
//!
//! `UNIT` is about the reciprocal of the fastest frequency, which keeps the
//! coefficients far from overflow; a power of two, so that scaling is exact.

use crate::dd::Dd;
use crate::model::{Mode, Model, Quantity, Real, Rock, State};

/// Unit of time of the series, 2^-21 s.
pub const UNIT: f64 = 1.0 / 2_097_152.0;

/// What decides the length of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Order of the series.
    pub order: usize,
    /// Size of the last term kept, with 1 mm and 1 m/s as units.
    pub tolerance: f64,
}

/// The series of a whole state about one instant.
#[derive(Clone, Debug)]
pub struct Series {
    u: Vec<Vec<Dd>>,
    v: Vec<Vec<Dd>>,
    psi: Vec<Dd>,
}

/// `sum c_k x^k`.
pub fn horner<T: Real>(c: &[T], x: T) -> T {
    c.iter().rev().fold(T::default(), |sum, &c| sum * x + c)
}

/// Largest magnitude in units of `scale`.
fn size(row: &[Dd], scale: f64) -> f64 {
    row.iter().fold(0.0f64, |max, x| max.max(x.hi.abs())) / scale
}

impl Series {
    /// Expands about `state`.
    pub fn new(
        model: &Model<Dd>,
        mode: Mode,
        load: &[Dd],
        state: &State<Dd>,
        order: usize,
    ) -> Self {
        let mut series =
            Self { u: vec![state.u.clone()], v: vec![state.v.clone()], psi: vec![state.psi] };
        let nothing = vec![Dd::default(); load.len()];
        let mut rate = nothing.clone();
        for k in 0..order {
            let step = Dd::from(UNIT) / Dd::from((k + 1) as f64);
            let forces = if k == 0 { load } else { &nothing };
            model.acceleration(mode, forces, &series.u[k], &series.v[k], &mut rate);
            series.u.push(series.v[k].iter().map(|&v| v * step).collect());
            series.v.push(rate.iter().map(|&a| a * step).collect());
            series.psi.push(series.power(model, mode, k) * step);
        }
        series
    }

    fn power(&self, model: &Model<Dd>, mode: Mode, k: usize) -> Dd {
        if mode.rock != Rock::DFC {
            return Dd::default();
        }
        let tip = model.nodes() - 1;
        let sum = (0..=k).fold(Dd::default(), |sum, i| sum + self.v[i][tip] * self.v[k - i][tip]);
        sum * Dd::from(model.parameters().rock.viscosity)
    }

    /// Length of the step, in units of [`UNIT`], after which the last two terms
    /// are below the tolerance.
    pub fn reach(&self, accuracy: Accuracy) -> f64 {
        let last = self.u.len() - 1;
        [last - 1, last]
            .map(|k| {
                let size = size(&self.u[k], 1e-3).max(size(&self.v[k], 1.0));
                (accuracy.tolerance / size.max(f64::MIN_POSITIVE)).powf(1.0 / k as f64)
            })
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    /// The state after `x` units of time.
    pub fn at(&self, x: Dd) -> State<Dd> {
        let row = |rows: &[Vec<Dd>]| {
            let mut sum = vec![Dd::default(); rows[0].len()];
            for coefficients in rows.iter().rev() {
                for (s, &c) in sum.iter_mut().zip(coefficients) {
                    *s = *s * x + c;
                }
            }
            sum
        };
        State { u: row(&self.u), v: row(&self.v), psi: horner(&self.psi, x) }
    }

    /// The polynomial of a watched quantity.
    pub fn quantity(&self, model: &Model<Dd>, quantity: Quantity) -> Vec<Dd> {
        let tip = model.nodes() - 1;
        let mut c: Vec<Dd> = match quantity {
            Quantity::Gap => self.u.iter().map(|u| model.gap(u)).collect(),
            Quantity::Tip => self.u.iter().map(|u| u[tip]).collect(),
            Quantity::TipSpeed => self.v.iter().map(|v| v[tip]).collect(),
            Quantity::Relative => self.u.iter().map(|u| model.mean_difference(u)).collect(),
            Quantity::Work => self.psi.clone(),
        };
        let gap = Dd::from(model.parameters().contact.initial_gap);
        match quantity {
            Quantity::Gap => c[0] = c[0] + gap,
            Quantity::Relative => c[0] = c[0] - gap,
            _ => {}
        }
        c
    }
}
