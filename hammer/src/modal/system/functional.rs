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

/// Repeated integrals of a rate that are kept: as many as a load, or a rate under it, has coefficients.
pub const INTEGRALS: usize = ORDERS + 1;

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
    /// `c B^(1 - k)` for k = 1, 2, ...: the rate's repeated integrals, made when a load varies.
    integrals: OnceLock<Vec<Vec<f64>>>,
    evaluation_rows: [OnceLock<EvaluationRows>; 2],
    /// Weight of the uniform translation.
    pub rigid: f64,
    /// True if it has no other: nothing in it oscillates.
    pub still: bool,
    /// `c S_j`, per channel and order.
    pub statics: [[f64; ORDERS]; CHANNELS],
}

impl Functional {
    /// From its modal coefficients `c`.
    pub(crate) fn new(mut c: Vec<f64>, generator: &Generator, response: &Response) -> Self {
        let n = generator.n;
        let rigid = if generator.rigid { c[0] } else { 0.0 };
        [0, n].iter().take(generator.polynomial()).for_each(|&at| c[at] = 0.0);
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
        let (mut weights, mut taylor) = (Self::nothing(n), Self::nothing(n));
        for (i, rates) in rates.iter().enumerate() {
            for (coordinate, &rate) in rates.iter().enumerate() {
                let (at, mut weight) = (coordinate * n + i, size(i, coordinate));
                let high = weight * math::powi(rate / generator.rate_max, TAYLOR);
                (taylor[0][at], taylor[1][at]) = (high, high * rate);
                for weights in &mut weights {
                    weights[at] = weight;
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
            rows: [c, r1, r2, r3],
            integrals: OnceLock::new(),
            evaluation_rows: Default::default(),
            rigid,
        }
    }

    /// Vectors of zeros, as many as are asked for.
    fn nothing<const COUNT: usize>(n: usize) -> [Vec<f64>; COUNT] {
        std::array::from_fn(|_| vec![0.0; 2 * n])
    }

    /// Rows for value and rate of derivative `order` (0 or 1), and weights that bound it and
    /// its second derivative for all later times.
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

    /// Coefficients of the rate's first [`INTEGRALS`] repeated integrals.
    pub(crate) fn rate_integrals(&self, generator: &Generator) -> &[Vec<f64>] {
        self.integrals.get_or_init(|| {
            let next = |row: &Vec<f64>| Some(generator.integrate(row));
            std::iter::successors(next(&self.rows[1]), next).take(INTEGRALS).collect()
        })
    }

    /// The polynomial part of its value, from loads and translation.
    pub(crate) fn poly(
        &self,
        response: &Response,
        loads: &[Poly; CHANNELS],
        driven: &Driven,
    ) -> Poly {
        if driven.is_parabola() && !response.varies(loads) {
            return self.parabola(loads, &driven.translation);
        }
        let sum = if self.still {
            Poly::default()
        } else {
            response.poly(&self.rows[0], &self.statics, loads, driven)
        };
        if self.rigid != 0.0 { sum.plus(self.rigid, &driven.translation) } else { sum }
    }

    /// [`Self::poly`] under constant loads.
    pub(crate) fn parabola(&self, loads: &[Poly; CHANNELS], translation: &Poly) -> Poly {
        let mut parabola = [0.0; 3];
        self.add_parabola(loads, translation, 1.0, &mut parabola);
        Poly::parabola(parabola)
    }

    /// Its value under constant loads, without the translation, m.
    #[inline]
    pub(crate) fn strain(&self, loads: &[Poly; CHANNELS]) -> f64 {
        self.statics.iter().zip(loads).map(|(statics, load)| statics[0] * load.0[0]).sum()
    }

    /// Adds a multiple of [`Self::poly`] to a parabola, which it is under constant loads. To
    /// construct it would take most of the time of a new mode's guards.
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
            let by = factor * self.rigid;
            sum.iter_mut().zip(&translation.0).for_each(|(c, moved)| *c += by * moved);
        }
    }
}
