//! How a linear system answers to a change of itself: the forced response in closed form.
//!
//! Where `y' = B y + b f` has the oscillation `z(t) = exp(B t) z0` and the change `W` of its
//! matrix (in the same modal coordinates), the tangent obeys `dy' = B dy + W y + d(b f)`. With
//! `X` the solution of `B X - X B = W` block by block,
//!
//! ```text
//! dy(t) = exp(B t) (dy0 + X z0) - X z(t),
//! ```
//!
//! since `exp(B s) X - X exp(B s)` grows at `B (.) + W exp(B s)`. `X` is a Cauchy-like matrix
//! (numerators of `W` over differences of eigenvalues) that is made once; it does not need the
//! derivative of an eigenvector. Blocks whose eigenvalues nearly coincide (each with itself
//! above all) are kept out of `X` and integrated by themselves, where the divided difference
//! of two exponentials has its limit `t exp(lambda t)`.

use crate::modal::system::{CHANNELS, Functional, System};
use crate::numerics::form::Form;
use crate::numerics::kernel;
use crate::numerics::math::norm;
use crate::numerics::matrix2::{Matrix2, product};
use crate::numerics::poly::Poly;
use crate::tangent::statics::{ORDERS, Statics, generators, solve};
use crate::tangent::variation::Variation;
use crate::tangent::weave::{Weave, corners, weave};
use num_complex::Complex64 as C;
use std::cell::OnceCell;
use std::sync::{Arc, OnceLock};

/// Eigenvalues closer than this, relative to the larger, are taken together: beyond, the
/// quotient loses three digits at most.
const CLOSE: f64 = 1e-3;

/// Blocks that must be integrated by themselves.
#[derive(Debug)]
struct Near {
    row: usize,
    column: usize,
    w: Matrix2,
}

/// The answer of one system to one change.
#[derive(Debug)]
pub(crate) struct Response {
    weave: Weave,
    /// `X` row by row; empty if it is zero.
    swept: Vec<f64>,
    near: Vec<Near>,
    generators: Vec<Matrix2>,
    statics: Arc<Statics>,
    /// Part of the polynomial solution that goes with derivative `j` of a channel.
    answers: [Vec<Vec<f64>>; CHANNELS],
    /// Change of the translation's rate and acceleration by derivative 0 of a channel.
    pushes: [[f64; 2]; CHANNELS],
    /// Change of the form of the dashpot's work, if it has one to working accuracy.
    viscous: OnceLock<Option<Form>>,
}

/// A mode of which damping takes less than this part of its amplitude in a radian: what the
/// dashpot takes of it all in all is a quotient of small numbers.
const LIGHT: f64 = 1e-5;

/// The state of a track over a stretch.
pub(crate) struct Path<'a> {
    pub system: &'a System,
    /// Oscillation at the start and at the end.
    pub start: &'a [f64],
    pub end: &'a [f64],
    pub span: f64,
    /// Loads from the start on, and their change.
    pub loads: &'a [Poly; CHANNELS],
    pub changes: &'a [Poly; CHANNELS],
    /// `exp(lambda span)` of the blocks that turn, once somebody needs them.
    pub turns: &'a OnceCell<Vec<C>>,
}

impl Path<'_> {
    /// True if no load varies, or varies in its change.
    fn is_steady(&self) -> bool {
        self.loads.iter().chain(self.changes).all(Poly::is_constant)
    }

    /// `exp(B span)` of all blocks: of one that turns, `z' = (sigma - i omega) z`, a complex number.
    fn turns(&self) -> &[C] {
        self.turns.get_or_init(|| {
            let n = self.system.blocks();
            let mut y = vec![0.0; 2 * n];
            y[..n].fill(1.0);
            self.system.rotate(self.span, &mut y);
            y[..n].iter().zip(&y[n..]).map(|(re, im)| C::new(*re, *im)).collect()
        })
    }
}

impl Response {
    pub(crate) fn new(system: &System, statics: Arc<Statics>, variation: &Variation) -> Self {
        let generators = generators(system);
        let weave = weave(system, variation);
        let (n, modes, len) = (system.blocks(), system.modes(), 2 * system.blocks());
        let (mut swept, mut near) = (Vec::new(), Vec::new());
        if !matches!(weave, Weave::Nothing) {
            swept = vec![0.0; len * len];
            let roots: Vec<[C; 2]> = generators.iter().map(eigenvalues).collect();
            for i in 0..modes {
                for k in usize::from(system.rigid)..modes {
                    let w = weave.block(n, i, k);
                    if w == [0.0; 4] {
                        continue;
                    }
                    if are_close(&roots[i], &roots[k]) {
                        near.push(Near { row: i, column: k, w });
                        continue;
                    }
                    let x = commutator(&generators[i], &generators[k], &w);
                    for (at, x) in corners(n, len, i, k).into_iter().zip(x) {
                        swept[at] = x;
                    }
                }
            }
            if swept.iter().all(|x| *x == 0.0) {
                swept.clear();
            }
        }
        let mut response = Self {
            weave,
            swept,
            near,
            generators,
            statics,
            answers: Default::default(),
            pushes: [[0.0; 2]; CHANNELS],
            viscous: OnceLock::new(),
        };
        for (channel, load) in variation.loads.iter().enumerate() {
            response.answer(system, channel, load);
        }
        response
    }

    /// The polynomial solution under the load of a channel: with `G_j` the push by its
    /// derivative `j`, `Y_j = B^-1 (Y_(j-1) - G_j)`.
    fn answer(&mut self, system: &System, channel: usize, load: &[f64]) {
        let (n, len) = (system.blocks(), 2 * system.blocks());
        let mut direct = vec![0.0; len];
        if matches!(self.weave, Weave::Nothing) && load.iter().all(|x| *x == 0.0) {
            return;
        }
        if load.iter().any(|x| *x != 0.0) {
            let body_state = [vec![0.0; load.len()], load.to_vec()].concat();
            system.to_modal(&body_state, &mut direct);
        }
        let mut last = vec![0.0; len];
        for j in 0..ORDERS {
            let mut push = self.weave.times(&self.statics.shapes[channel][j]);
            if j == 0 {
                push.iter_mut().zip(&direct).for_each(|(p, d)| *p += d);
                if system.rigid {
                    self.pushes[channel] = [push[0], push[n]];
                }
            }
            last.iter_mut().zip(&push).for_each(|(l, p)| *l -= p);
            last = solve(system, &self.generators, &last);
            self.answers[channel].push(last.clone());
        }
    }

    /// `y += sign` times the polynomial solution at `t`.
    fn add_answer(&self, path: &Path, t: f64, sign: f64, y: &mut [f64]) {
        for (answers, load) in self.answers.iter().zip(path.loads) {
            let mut derivative = *load;
            for answer in answers {
                let factor = sign * derivative.at(t);
                if factor != 0.0 {
                    kernel::add(y, factor, answer);
                }
                if derivative.is_constant() {
                    break;
                }
                derivative = derivative.derivative();
            }
        }
        self.statics.add(path.changes, t, sign, y);
    }

    /// The polynomial solution where no load varies; none if it is zero.
    fn steady_answer(&self, path: &Path) -> Option<Vec<f64>> {
        let mut sum = None;
        let mut add = |factor: f64, term: &Vec<f64>| {
            if factor != 0.0 {
                kernel::add(sum.get_or_insert_with(|| vec![0.0; term.len()]), factor, term);
            }
        };
        for channel in 0..CHANNELS {
            let orders = self.answers[channel].iter().take(1);
            orders.for_each(|answer| add(path.loads[channel].0[0], answer));
            add(path.changes[channel].0[0], &self.statics.shapes[channel][0]);
        }
        sum
    }

    /// Carries the tangent `[dq | dq']` of a track along a stretch.
    ///
    /// `ends`, if wanted, become the tangents of the oscillation at the start and at the end, for
    /// integrals along the stretch.
    pub(crate) fn carry(
        &self,
        path: &Path,
        body_state: &mut [f64],
        ends: Option<&mut [Vec<f64>; 2]>,
    ) {
        let system = path.system;
        let n = system.blocks();
        let mut y = vec![0.0; 2 * n];
        system.to_modal(body_state, &mut y);
        let steady = path.is_steady().then(|| self.steady_answer(path));
        match &steady {
            Some(answer) => answer.iter().for_each(|answer| kernel::add(&mut y, -1.0, answer)),
            None => self.add_answer(path, 0.0, -1.0, &mut y),
        }
        let start = ends.is_some().then(|| y.clone());
        self.add_swept(path.start, 1.0, &mut y);
        system.rotate(path.span, &mut y);
        if system.rigid {
            y[0] += path.span * y[n];
        }
        self.add_swept(path.end, -1.0, &mut y);
        self.add_near(path, &mut y);
        if let (Some(ends), Some(start)) = (ends, start) {
            *ends = [start, y.clone()];
        }
        match &steady {
            Some(answer) => answer.iter().for_each(|answer| kernel::add(&mut y, 1.0, answer)),
            None => self.add_answer(path, path.span, 1.0, &mut y),
        }
        if system.rigid {
            let [moved, rate] = self.translation(path);
            y[0] += moved;
            y[n] += rate;
        }
        system.to_bodies(&y, body_state);
    }

    /// True if a tangent that is nothing stays so.
    pub(crate) fn rests(&self, path: &Path, body_state: &[f64]) -> bool {
        self.is_still()
            && body_state.iter().all(|x| *x == 0.0)
            && path.changes.iter().all(|change| *change == Poly::default())
    }

    /// The tangent of the static equilibrium under the loads, `[dq | dq']`.
    pub(crate) fn standing(&self, path: &Path) -> Vec<f64> {
        let mut y = vec![0.0; 2 * path.system.blocks()];
        self.add_answer(path, 0.0, 1.0, &mut y);
        let mut body_state = vec![0.0; 2 * path.system.modes()];
        path.system.to_bodies(&y, &mut body_state);
        body_state
    }

    /// What the loads add to the tangent of the translation: its displacement and rate.
    fn translation(&self, path: &Path) -> [f64; 2] {
        let [speed, kick] = self.translating(path);
        let moved = antiderivative(&speed.plus(1.0, &kick));
        [moved.at(path.span), speed.at(path.span)]
    }

    /// The same over time: what adds to its rate, and what moves it besides.
    pub(super) fn translating(&self, path: &Path) -> [Poly; 2] {
        let (mut rate, mut kick) = (Poly::default(), Poly::default());
        for channel in 0..CHANNELS {
            let (push, gain) = (self.pushes[channel], self.statics.gains[channel]);
            kick = kick.plus(push[0], &path.loads[channel]);
            rate = rate.plus(push[1], &path.loads[channel]).plus(gain, &path.changes[channel]);
        }
        [antiderivative(&rate), kick]
    }

    /// A row of `X`, if that is not zero.
    pub(super) fn swept_row(&self, k: usize) -> Option<&[f64]> {
        let len = 2 * self.generators.len().next_multiple_of(kernel::LANES);
        self.swept.get(k * len..(k + 1) * len)
    }

    /// `row W`.
    pub(super) fn pulled(&self, row: &[f64]) -> Vec<f64> {
        self.weave.pulled(row)
    }

    fn add_swept(&self, z: &[f64], sign: f64, y: &mut [f64]) {
        if self.swept.is_empty() {
            return;
        }
        let mut x = vec![0.0; y.len()];
        kernel::multiply(&self.swept, z, &mut x);
        kernel::add(y, sign, &x);
    }

    fn add_near(&self, path: &Path, y: &mut [f64]) {
        let n = path.system.blocks();
        for near in &self.near {
            let (a, b) = (&self.generators[near.row], &self.generators[near.column]);
            let z = [path.start[near.column], path.start[n + near.column]];
            let turn = |b: &Matrix2| b[0] == b[3] && b[1] == -b[2] && b[1] != 0.0;
            let [p, q] = if turn(a) && turn(b) {
                let (la, lb) = (C::new(a[0], -a[1]), C::new(b[0], -b[1]));
                let turns = path.turns();
                let (ea, eb) = (turns[near.row], turns[near.column]);
                let w = &near.w;
                let like = 0.5 * C::new(w[0] + w[3], w[2] - w[1]);
                let cross = 0.5 * C::new(w[0] - w[3], w[2] + w[1]);
                let z = C::new(z[0], z[1]);
                let t = path.span;
                let sum = like * z * difference([la, lb], [ea, eb], t)
                    + cross * z.conj() * difference([la, lb.conj()], [ea, eb.conj()], t);
                [sum.re, sum.im]
            } else {
                let d = duhamel(a, b, &near.w, path.span);
                [d[0] * z[0] + d[1] * z[1], d[2] * z[0] + d[3] * z[1]]
            };
            y[near.row] += p;
            y[n + near.row] += q;
        }
    }

    /// True if the system stays as it is.
    pub(crate) fn is_still(&self) -> bool {
        matches!(self.weave, Weave::Nothing)
    }

    /// Change of [`System::viscous_form`], once the system stays or is damped well enough.
    pub(crate) fn viscous(&self, system: &System) -> Option<&Form> {
        let make = || {
            let damped = |b: &Matrix2| eigenvalues(b).iter().all(|l| -l.re >= LIGHT * norm(*l));
            let form = || system.viscous_form_by(&self.weave.full(2 * system.blocks()));
            let sound = self.generators.iter().all(damped) && !system.rigid;
            sound.then(form).filter(Form::is_finite)
        };
        self.viscous.get_or_init(make).as_ref()
    }

    /// `y += W z`.
    pub(crate) fn push(&self, z: &[f64], y: &mut [f64]) {
        self.weave.add(z, y);
    }

    /// The tangent of the static part of a displacement, as a polynomial.
    pub(crate) fn drift(&self, path: &Path, f: &Functional) -> Poly {
        let row = &f.rows[0];
        let mut sum = still(f, path.changes);
        for (answers, load) in self.answers.iter().zip(path.loads) {
            let mut derivative = *load;
            for answer in answers {
                if derivative == Poly::default() {
                    break;
                }
                sum = sum.plus(kernel::dot(row, answer), &derivative);
                derivative = derivative.derivative();
            }
        }
        sum
    }
}

/// The static part of a displacement under polynomial loads.
pub(crate) fn still(f: &Functional, loads: &[Poly; CHANNELS]) -> Poly {
    let mut sum = Poly::default();
    for (statics, load) in f.statics.iter().zip(loads) {
        let mut derivative = *load;
        for s in statics {
            sum = sum.plus(*s, &derivative);
            derivative = derivative.derivative();
        }
    }
    sum
}

fn eigenvalues(b: &Matrix2) -> [C; 2] {
    let half = 0.5 * (b[0] + b[3]);
    let apart = 0.5 * (b[0] - b[3]);
    let disc = apart * apart + b[1] * b[2];
    let root = if disc >= 0.0 { C::new(disc.sqrt(), 0.0) } else { C::new(0.0, (-disc).sqrt()) };
    [half + root, half - root]
}

fn are_close(a: &[C; 2], b: &[C; 2]) -> bool {
    a.iter().any(|x| b.iter().any(|y| norm(x - y) <= CLOSE * norm(*x).max(norm(*y))))
}

/// Solves `A X - X B = W`: `(A^2 - tr B A + det B) X = A W + W B - tr B W`.
fn commutator(a: &Matrix2, b: &Matrix2, w: &Matrix2) -> Matrix2 {
    let turns = |m: &Matrix2| m[0] == m[3] && m[1] == -m[2] && m[1] != 0.0;
    if turns(a) && turns(b) {
        // As complex numbers z' = (sigma - i omega) z: differences do not cancel twice.
        let (la, lb) = (C::new(a[0], -a[1]), C::new(b[0], -b[1]));
        let like = 0.5 * C::new(w[0] + w[3], w[2] - w[1]) / (la - lb);
        let cross = 0.5 * C::new(w[0] - w[3], w[2] + w[1]) / (la - lb.conj());
        return [like.re + cross.re, cross.im - like.im, like.im + cross.im, like.re - cross.re];
    }
    let (trace, det) = (b[0] + b[3], b[0] * b[3] - b[1] * b[2]);
    let mut m = product(a, a);
    for (m, a) in m.iter_mut().zip(a) {
        *m -= trace * a;
    }
    m[0] += det;
    m[3] += det;
    let (aw, wb) = (product(a, w), product(w, b));
    let rhs: Matrix2 = std::array::from_fn(|k| aw[k] + wb[k] - trace * w[k]);
    let d = m[0] * m[3] - m[1] * m[2];
    product(&[m[3] / d, -m[1] / d, -m[2] / d, m[0] / d], &rhs)
}

/// `(exp(a t) - exp(b t)) / (a - b)`, with both exponentials given.
fn difference(l: [C; 2], e: [C; 2], t: f64) -> C {
    if l[0] == l[1] {
        return e[0] * t;
    }
    let half = 0.5 * (l[0] - l[1]) * t;
    if half.norm_sqr() > 0.01 {
        return (e[0] - e[1]) / (l[0] - l[1]);
    }
    // (exp(x) - 1) / x to rounding: 0.2^11 / 12! is below 1e-16.
    let x = 2.0 * half;
    let series = (2..12).rev().fold(C::new(1.0, 0.0), |sum, k| 1.0 + x * sum / f64::from(k));
    e[1] * t * series
}

/// `int_0^t exp(A (t - s)) W exp(B s) ds`: a short step by its series, then doubled.
fn duhamel(a: &Matrix2, b: &Matrix2, w: &Matrix2, t: f64) -> Matrix2 {
    let size = a.iter().chain(b).fold(0.0f64, |m, x| m.max(x.abs())) * t;
    let mut doublings = 0;
    while size > 0.25 * (1u64 << doublings) as f64 && doublings < 60 {
        doublings += 1;
    }
    let h = t / (1u64 << doublings) as f64;
    let one = [1.0, 0.0, 0.0, 1.0];
    let (mut ea, mut eb, mut d) = (one, one, [0.0; 4]);
    let (mut pa, mut pb, mut pd) = (one, one, [0.0; 4]);
    // 0.5^14 / 14! is below rounding.
    for k in 1..=14 {
        let f = h / f64::from(k);
        let (x, y) = (product(a, &pd), product(w, &pb));
        pd = std::array::from_fn(|i| f * (x[i] + y[i]));
        pa = product(a, &pa).map(|x| f * x);
        pb = product(b, &pb).map(|x| f * x);
        for i in 0..4 {
            ea[i] += pa[i];
            eb[i] += pb[i];
            d[i] += pd[i];
        }
    }
    for _ in 0..doublings {
        let (x, y) = (product(&ea, &d), product(&d, &eb));
        d = std::array::from_fn(|i| x[i] + y[i]);
        ea = product(&ea, &ea);
        eb = product(&eb, &eb);
    }
    d
}

/// The integral from 0 on.
pub(super) fn antiderivative(p: &Poly) -> Poly {
    let mut out = Poly::default();
    for k in 1..p.0.len() {
        out.0[k] = p.0[k - 1] / k as f64;
    }
    out
}
