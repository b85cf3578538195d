//! An exponential integrator that never forms a matrix, with dense output for the events.
//!
//! In a mode `x' = A x + b` with constant `A` and `b`, hence
//!
//! ```text
//! x(h) = x + h phi1(h A) w,   w = A x + b,   h phi1(h A) w = sum h^(k+1) A^k w / (k+1)!
//! ```
//!
//! The action of `phi1` is taken by its series (Al-Mohy and Higham 2011, with a shorter step in
//! place of their scaling). It gives the state at any instant of the step for the cost of a
//! polynomial, so that looking for events inside a step, and locating one, costs no further
//! product with `A`. An orthonormal basis of the same space (Krylov, Arnoldi) was tried: with a
//! tridiagonal `A` its `2 m^2 n` operations are eight times those of the `m` products.

use crate::hybrid::OneStep;
use oracles::law::{Memory, Mode, State};
use oracles::model::Model;

/// Order of the series.
const ORDER: usize = 30;
/// Largest `h |A|`: the series then loses five digits of sixteen.
const REACH: f64 = 10.0;
/// Longest step, s.
const LONGEST: f64 = 1e-4;
/// A step is looked at this often, s: what rises and falls again in between is missed.
const SCAN: f64 = 2.5e-7;
/// Gauss-Legendre of order 8 on `[0, 1]`: abscissae and weights, for the viscous work.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The method, for one model.
pub struct Exponential<'a> {
    model: &'a Model<f64>,
    /// Local error over 1 mm and 1 m/s.
    tolerance: f64,
    mode: Mode,
    load: Vec<f64>,
    /// The state from which `terms` expand, `(u, v)`.
    origin: Vec<f64>,
    psi: f64,
    /// `x(h) - x` is the sum of `h^(k+1)` times these.
    terms: Vec<Vec<f64>>,
    /// Largest step within the tolerance, s.
    length: f64,
    /// How far into it the run is, and where the look under way ends, s.
    reached: f64,
    ahead: f64,
    next_psi: f64,
}

impl<'a> Exponential<'a> {
    /// At rest.
    pub fn new(model: &'a Model<f64>, tolerance: f64) -> Self {
        let (state, mode, memory) = model.start();
        let mut made = Self {
            model,
            tolerance,
            mode,
            load: Vec::new(),
            origin: Vec::new(),
            psi: 0.0,
            terms: Vec::new(),
            length: 0.0,
            reached: 0.0,
            ahead: 0.0,
            next_psi: 0.0,
        };
        made.enter(model, mode, &memory, &state);
        made
    }

    /// `(v, M^-1 (load - K u - C v))` of `x = (u, v)`.
    fn rate(&self, x: &[f64], load: &[f64]) -> Vec<f64> {
        let (u, v) = x.split_at(x.len() / 2);
        let mut rate = v.to_vec();
        rate.resize(x.len(), 0.0);
        self.model.acceleration(self.mode, load, u, v, &mut rate[v.len()..]);
        rate
    }

    /// `x` over 1 mm and 1 m/s.
    fn size(x: &[f64]) -> f64 {
        let (u, v) = x.split_at(x.len() / 2);
        let largest = |part: &[f64]| part.iter().fold(0.0f64, |max, x| max.max(x.abs()));
        (largest(u) / 1e-3).max(largest(v))
    }

    /// Expands from the origin, and finds how far that is good.
    fn expand(&mut self) {
        let free = vec![0.0; self.load.len()];
        self.terms = vec![self.rate(&self.origin, &self.load)];
        for k in 1..ORDER {
            let mut next = self.rate(&self.terms[k - 1], &free);
            next.iter_mut().for_each(|x| *x /= (k + 1) as f64);
            self.terms.push(next);
        }
        let [before, last] =
            [ORDER - 2, ORDER - 1].map(|k| Self::size(&self.terms[k]).max(f64::MIN_POSITIVE));
        // The last two terms, for one of them may vanish; and what their growth says of |A|.
        let within = |size: f64, order: usize| (self.tolerance / size).powf(1.0 / order as f64);
        let reach = REACH * before / (last * ORDER as f64);
        self.length = within(before, ORDER - 1).min(within(last, ORDER)).min(reach).min(LONGEST);
    }

    /// The state `h` after the origin.
    fn at(&self, h: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.origin.len()];
        for term in self.terms.iter().rev() {
            x.iter_mut().zip(term).for_each(|(x, t)| *x = (*x + t) * h);
        }
        x.iter_mut().zip(&self.origin).for_each(|(x, o)| *x += o);
        x
    }

    /// The viscous work `h` after what has been reached.
    fn psi_after(&self, h: f64) -> f64 {
        let tip = self.origin.len() - 1;
        let power = |h: f64| {
            let gained = self.terms.iter().rev().fold(0.0, |sum, term| (sum + term[tip]) * h);
            self.model.power(self.mode, &[self.origin[tip] + gained])
        };
        let parts = GAUSS.iter().map(|&(a, weight)| weight * power(self.reached + a * h));
        self.psi + h * parts.sum::<f64>()
    }
}

impl OneStep for Exponential<'_> {
    fn enter(&mut self, model: &Model<f64>, mode: Mode, memory: &Memory<f64>, state: &State<f64>) {
        self.mode = mode;
        self.load = model.load(mode, memory);
        self.origin = [&state.u[..], &state.v].concat();
        self.psi = state.psi;
        self.reached = 0.0;
        self.expand();
    }

    fn length(&self) -> f64 {
        (self.length - self.reached).min(SCAN)
    }

    fn step(&mut self, from: &State<f64>, h: f64, to: &mut State<f64>) -> bool {
        self.partial(from, h, to);
        self.ahead = self.reached + h;
        self.next_psi = to.psi;
        true
    }

    fn partial(&mut self, _: &State<f64>, h: f64, to: &mut State<f64>) {
        let x = self.at(self.reached + h);
        let (u, v) = x.split_at(x.len() / 2);
        to.u.copy_from_slice(u);
        to.v.copy_from_slice(v);
        to.psi = self.psi_after(h);
    }

    fn commit(&mut self) {
        (self.reached, self.psi) = (self.ahead, self.next_psi);
        if self.reached > 0.999 * self.length {
            self.origin = self.at(self.reached);
            self.reached = 0.0;
            self.expand();
        }
    }
}
