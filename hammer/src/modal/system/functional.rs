//! A linear functional of the displacements, with its derivatives and bounds.

use crate::modal::system::driven::Driven;
use crate::modal::system::generator::Generator;
use crate::modal::system::response::{ORDERS, Response};
use crate::numerics::kernel::EvaluationRows;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::scene::graph::CHANNELS;
use std::sync::OnceLock;

/// Order of the remainder of a Taylor window.
pub const TAYLOR: usize = 24;

/// Number of repeated integrals of a rate that are stored: as many as a load, or a rate under this load, has
/// coefficients.
pub const INTEGRALS: usize = ORDERS + 1;

/// A linear functional of the displacements, in modal coordinates.
#[derive(Clone, Debug)]
pub struct Functional {
    /// `c B^k`, which gives the k-th derivative, for k = 0 (the displacement) to 3.
    pub rows: [Vec<f64>; 4],
    /// Weights for k = 0 to 3: their product with `|y|` bounds the k-th derivative for all later times.
    pub weights: [Vec<f64>; 4],
    /// Weights for the derivative `k + TAYLOR`, divided by `rate_max^TAYLOR`, of the displacement (k = 0) and the
    /// velocity (k = 1).
    pub taylor: [Vec<f64>; 2],
    /// `c B^-1`, which gives the integral.
    pub integral: Vec<f64>,
    /// `c B^(1 - k)` for k = 1, 2, ..., which give the repeated integrals of the rate. They are computed when a load
    /// first varies.
    integrals: OnceLock<Vec<Vec<f64>>>,
    evaluation_rows: [OnceLock<EvaluationRows>; 2],
    /// Weight of the uniform translation.
    pub rigid: f64,
    /// True if all other weights are zero, so that nothing in the displacement oscillates.
    pub still: bool,
    /// Index of an earlier functional of the system that is this one times minus one.
    pub mirrored: Option<usize>,
    /// `c S_j` for each channel and each order `j` (see `response.rs`).
    pub statics: [[f64; ORDERS]; CHANNELS],
}

impl Functional {
    /// The functional with the modal coefficients `c`.
    pub(crate) fn new(mut c: Vec<f64>, generator: &Generator, response: &Response) -> Self {
        let n = generator.n;
        let rigid = if generator.rigid { c[0] } else { 0.0 };
        [0, n].iter().take(generator.polynomial()).for_each(|&index| c[index] = 0.0);
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
        let (mut weights, mut taylor) = (Self::zeros(n), Self::zeros(n));
        for (i, rates) in rates.iter().enumerate() {
            for (coordinate, &rate) in rates.iter().enumerate() {
                let (index, mut weight) = (coordinate * n + i, size(i, coordinate));
                let high = weight * math::powi(rate / generator.rate_max, TAYLOR);
                (taylor[0][index], taylor[1][index]) = (high, high * rate);
                for weights in &mut weights {
                    weights[index] = weight;
                    weight *= rate;
                }
            }
        }
        Self {
            weights,
            taylor,
            integral: generator.integrate(&c),
            statics: response.statics_of(&c),
            still: c.iter().all(|c| *c == 0.0),
            mirrored: None,
            rows: [c, r1, r2, r3],
            integrals: OnceLock::new(),
            evaluation_rows: Default::default(),
            rigid,
        }
    }

    fn zeros<const COUNT: usize>(n: usize) -> [Vec<f64>; COUNT] {
        std::array::from_fn(|_| vec![0.0; 2 * n])
    }

    /// True if the other one is this one times minus one.
    pub(crate) fn mirrors(&self, other: &Self) -> bool {
        self.rigid == -other.rigid && self.rows[0].iter().zip(&other.rows[0]).all(|(a, b)| *a == -b)
    }

    /// Rows for derivative `order` (0 or 1) and for its rate, and weights that bound this derivative and its second
    /// derivative for all later times.
    #[inline]
    pub(crate) fn evaluation_rows(&self, order: usize) -> &EvaluationRows {
        let (rows, weights) = (&self.rows, &self.weights);
        self.evaluation_rows[order].get_or_init(|| {
            EvaluationRows::new([
                &rows[order],
                &rows[order + 1],
                &weights[order],
                &weights[order + 2],
            ])
        })
    }

    /// Coefficients of the rate integrated once, twice and so on, up to [`INTEGRALS`] times.
    pub(crate) fn rate_integrals(&self, generator: &Generator) -> &[Vec<f64>] {
        self.integrals.get_or_init(|| {
            let next = |row: &Vec<f64>| Some(generator.integrate(row));
            std::iter::successors(next(&self.rows[1]), next).take(INTEGRALS).collect()
        })
    }

    /// The polynomial part of the displacement, which loads and translation cause.
    pub(crate) fn poly(
        &self,
        response: &Response,
        loads: &[Poly; CHANNELS],
        driven: &Driven,
    ) -> Poly {
        if !response.varies(loads) && driven.is_parabola() {
            return self.parabola(loads, &driven.translation);
        }
        let mut sum = Poly::default();
        if !self.still {
            response.add_poly(&self.rows[0], &self.statics, loads, driven, &mut sum);
        }
        if self.rigid != 0.0 {
            sum.add(self.rigid, &driven.translation);
        }
        sum
    }

    /// [`Self::poly`] under constant loads.
    pub(crate) fn parabola(&self, loads: &[Poly; CHANNELS], translation: &Poly) -> Poly {
        let mut parabola = [0.0; 3];
        self.add_parabola(loads, translation, 1.0, &mut parabola);
        Poly::parabola(parabola)
    }

    /// The displacement at rest under constant loads, without the translation, m.
    #[inline]
    pub(crate) fn strain(&self, loads: &[Poly; CHANNELS]) -> f64 {
        self.statics.iter().zip(loads).map(|(statics, load)| statics[0] * load.0[0]).sum()
    }

    /// Adds a multiple of [`Self::poly`], which under constant loads is a parabola, to another parabola. To construct
    /// the polynomial would take most of the time of setting up a new mode's guards.
    #[inline]
    pub(crate) fn add_parabola(
        &self,
        loads: &[Poly; CHANNELS],
        translation: &Poly,
        factor: f64,
        sum: &mut [f64; 3],
    ) {
        debug_assert!(translation.degree() <= 2, "a load varies");
        sum[0] += factor * self.strain(loads);
        if self.rigid != 0.0 {
            let factor = factor * self.rigid;
            sum.iter_mut().zip(&translation.0).for_each(|(c, term)| *c += factor * term);
        }
    }
}
