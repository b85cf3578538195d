//! One linear system of the hammer, decomposed: the exact flow between events.
//!
//! In modal coordinates a system is `y' = B y + b f(t)` with 2 by 2 blocks on the diagonal
//! of `B` (see [`crate::modal::spectrum`]). With polynomial loads the solution is
//!
//! ```text
//! y(t) = exp(B t) z + sum_j S_j f^(j)(t),     S_j = -B^-(j+1) b,
//! ```
//!
//! exact for any `t`: nothing is stepped. The uniform translation, where a system has one,
//! is a polynomial and kept apart. The blocks are chosen so that `|exp(B t) z|` never
//! grows: amplitudes bound the motion for all later times.

use crate::error::Error;
use crate::modal::basis::{bases, block_exponential, columns, sylvester};
use crate::modal::spectrum::{self, Attachment, Block, Secular};
use crate::numerics::kernel::{self, Form};
use crate::numerics::math;
use crate::numerics::poly::{Poly, TERMS};
use crate::physics::mode::Mode;
use std::sync::OnceLock;

/// Orders of input derivatives, from the value on.
pub const ORDERS: usize = crate::MAX_INPUT_ORDER + 1;
/// Load channels: drive, feed, gravity.
pub const CHANNELS: usize = 3;
/// Order of the remainder of a Taylor window.
pub const TAYLOR: usize = 24;
/// Shortest tabulated rotation is 2^-SHORTEST s.
const SHORTEST: i32 = 44;
/// Number of tabulated rotations: up to 2^(LEVELS - 1 - SHORTEST) s, 16 s.
const LEVELS: usize = 49;

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
    /// `c S_j` a channel and order.
    pub statics: [[f64; ORDERS]; CHANNELS],
}

impl Functional {
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

/// What a system is made of.
pub struct Recipe<'a> {
    /// Squared frequencies of the free bars' modes.
    pub omega2: &'a [f64],
    /// Kelvin-Voigt damping time, s.
    pub beta: f64,
    /// Springs and dashpots.
    pub attachments: Vec<Attachment<'a>>,
    /// Modal loads of unit channel values.
    pub loads: [Vec<f64>; CHANNELS],
    /// Shapes of the functionals wanted.
    pub functionals: Vec<Vec<f64>>,
}

/// A vector that is missing or doubled shows as a mismatch near one, rounding under the
/// stiffest dashpots as 1e-4: beyond this, [`System::new`] refuses.
const BASIS_TOLERANCE: f64 = 1e-2;
/// Beyond this mismatch, a state that enters the basis is corrected once.
const ROUGH: f64 = 1e-11;

/// A decomposed system.
#[derive(Debug)]
pub struct System {
    /// Blocks, padded with empty ones to whole lanes.
    n: usize,
    /// Modes of the bars.
    modes: usize,
    /// Length of `[q | q']`, padded to whole lanes.
    hub: usize,
    generators: Vec<f64>,
    /// True if block 0 is a uniform translation.
    pub rigid: bool,
    /// True if the basis and its inverse fit less well than rounding alone would have it.
    rough: bool,
    blocks: Vec<[f64; 4]>,
    /// Largest `|B|`, 1/s.
    pub rate_max: f64,
    from_modal: Vec<f64>,
    to_modal: Vec<f64>,
    /// `S_j`, a channel and order.
    pub statics: [Vec<Vec<f64>>; CHANNELS],
    /// Acceleration of the translation a channel.
    pub gains: [f64; CHANNELS],
    /// As the recipe orders them.
    pub functionals: Vec<Functional>,
    damping: Vec<f64>,
    tip_dashpot: Option<usize>,
    rotations: Vec<OnceLock<Vec<f64>>>,
    damping_form: OnceLock<Form>,
    viscous_form: OnceLock<Form>,
}

impl System {
    /// Decomposes.
    ///
    /// `tip` is the functional whose dashpot work is wanted.
    ///
    /// # Errors
    /// [`Error::Spectrum`] if the eigenvalues cannot be found to working accuracy.
    pub fn new(recipe: Recipe, tip: Option<usize>, mode: Mode) -> Result<Self, Error> {
        let modes = recipe.omega2.len();
        let n = modes.next_multiple_of(kernel::LANES);
        let blocks = if recipe.attachments.is_empty() {
            spectrum::free_blocks(recipe.omega2, recipe.beta)
        } else {
            let secular = Secular {
                omega2: recipe.omega2,
                beta: recipe.beta,
                attachments: recipe.attachments.clone(),
            };
            spectrum::blocks(&secular).map_err(|reason| Error::Spectrum { mode, reason })?
        };
        let (from_modal, to_modal) = bases(&recipe, &blocks, n);
        if from_modal.iter().chain(&to_modal).any(|x| !x.is_finite()) {
            return Err(Error::Spectrum { mode, reason: "an eigenvector is not finite" });
        }
        let mut system = Self {
            n,
            modes,
            hub: (2 * modes).next_multiple_of(kernel::LANES),
            generators: columns(&blocks, n),
            rigid: blocks[0].rigid,
            rough: false,
            rate_max: blocks.iter().flat_map(|b| b.rate).fold(0.0, f64::max),
            blocks: blocks.iter().map(|b| b.b).collect(),
            from_modal,
            to_modal,
            statics: Default::default(),
            gains: [0.0; CHANNELS],
            functionals: Vec::new(),
            damping: recipe.omega2.iter().map(|w2| recipe.beta * w2).collect(),
            tip_dashpot: tip,
            rotations: (0..LEVELS).map(|_| OnceLock::new()).collect(),
            damping_form: OnceLock::new(),
            viscous_form: OnceLock::new(),
        };
        let mismatch = system.mismatch(recipe.omega2);
        system.rough = mismatch > ROUGH;
        if mismatch > BASIS_TOLERANCE {
            return Err(Error::Spectrum { mode, reason: "a basis and its inverse do not fit" });
        }
        for (channel, load) in recipe.loads.iter().enumerate() {
            system.add_load(channel, load);
        }
        system.functionals =
            recipe.functionals.iter().map(|shape| system.functional(shape, &blocks)).collect();
        Ok(system)
    }

    /// How far a state that goes into the basis and back comes from where it was, over its
    /// size, a displacement times its frequency: a wrong eigenvector must not go unseen.
    fn mismatch(&self, omega2: &[f64]) -> f64 {
        let slowest = self.blocks.iter().flatten().map(|b| b.abs()).filter(|&b| b > 0.0);
        let slowest = slowest.fold(self.rate_max, f64::min).max(1e-6 * self.rate_max);
        let slowest = if slowest > 0.0 { slowest } else { 1.0 };
        let rate = |i: usize| omega2[i].sqrt().max(slowest);
        let mut worst = 0.0f64;
        for step in [5, 7] {
            // Any state will do that has a share of every mode.
            let share = |i: usize| 1.0 - ((i * step) % 11) as f64 / 8.0;
            let displacements = (0..self.modes).map(|i| share(i) / rate(i));
            let hub: Vec<f64> =
                displacements.chain((0..self.modes).map(|i| share(i + 3))).collect();
            let (mut y, mut back) = (vec![0.0; 2 * self.n], vec![0.0; 2 * self.modes]);
            self.to_modal(&hub, &mut y);
            self.from_modal(&y, &mut back);
            for (i, (x, b)) in hub.iter().zip(&back).enumerate() {
                let weight = if i < self.modes { rate(i) } else { 1.0 };
                let apart = weight * (x - b).abs();
                worst = if apart.is_nan() { f64::INFINITY } else { worst.max(apart) };
            }
        }
        worst
    }

    /// Number of blocks, padded to whole lanes; a modal vector is twice as long.
    pub fn blocks(&self) -> usize {
        self.n
    }

    /// Number of modes of the bars; `[q | q']` is twice as long.
    pub fn modes(&self) -> usize {
        self.modes
    }

    fn add_load(&mut self, channel: usize, load: &[f64]) {
        let n = self.n;
        let mut hub = vec![0.0; 2 * self.modes];
        hub[self.modes..].copy_from_slice(load);
        let mut b = vec![0.0; 2 * n];
        self.to_modal(&hub, &mut b);
        if self.rigid {
            self.gains[channel] = b[n];
        }
        for _ in 0..ORDERS {
            b = self.solve(&b, false);
            b.iter_mut().for_each(|x| *x = -*x);
            self.statics[channel].push(b.clone());
            b.iter_mut().for_each(|x| *x = -*x);
        }
    }

    /// `B^-1 y`, or `y B^-1` if `left`; zero for the translation.
    fn solve(&self, y: &[f64], left: bool) -> Vec<f64> {
        let n = self.n;
        let mut x = vec![0.0; 2 * n];
        for (i, b) in self.blocks.iter().enumerate().skip(usize::from(self.rigid)) {
            let (b12, b21) = if left { (b[2], b[1]) } else { (b[1], b[2]) };
            let det = b[0] * b[3] - b[1] * b[2];
            x[i] = (b[3] * y[i] - b12 * y[n + i]) / det;
            x[n + i] = (b[0] * y[n + i] - b21 * y[i]) / det;
        }
        x
    }

    /// `y B^-1`, the coefficients of an integral.
    pub fn integral_of(&self, row: &[f64]) -> Vec<f64> {
        self.solve(row, true)
    }

    /// `c B`.
    fn differentiate(&self, c: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut d = vec![0.0; 2 * n];
        for (i, b) in self.blocks.iter().enumerate() {
            d[i] = c[i] * b[0] + c[n + i] * b[2];
            d[n + i] = c[i] * b[1] + c[n + i] * b[3];
        }
        d
    }

    fn functional(&self, shape: &[f64], blocks: &[Block]) -> Functional {
        let n = self.n;
        let mut c = vec![0.0; 2 * n];
        for (i, s) in shape.iter().enumerate() {
            for (cj, m) in c.iter_mut().zip(&self.from_modal[i * 2 * n..(i + 1) * 2 * n]) {
                *cj += s * m;
            }
        }
        let rigid = if self.rigid { c[0] } else { 0.0 };
        if self.rigid {
            (c[0], c[n]) = (0.0, 0.0);
        }
        let statics = std::array::from_fn(|ch| {
            std::array::from_fn(|j| kernel::dot(&c, &self.statics[ch][j]))
        });
        let r1 = self.differentiate(&c);
        let r2 = self.differentiate(&r1);
        let r3 = self.differentiate(&r2);
        let size = |i: usize, coordinate: usize| {
            let scalar = blocks[i].b[1] == 0.0 && blocks[i].b[2] == 0.0;
            if scalar { c[coordinate * n + i].abs() } else { math::hypot(c[i], c[n + i]) }
        };
        let weight = |scale: f64, power: usize| -> Vec<f64> {
            (0..2 * n)
                .map(|k| {
                    let (i, coordinate) = (k % n, k / n);
                    if i >= blocks.len() {
                        return 0.0;
                    }
                    size(i, coordinate) * math::powi(blocks[i].rate[coordinate] / scale, power)
                })
                .collect()
        };
        Functional {
            weights: std::array::from_fn(|k| weight(1.0, k)),
            taylor: std::array::from_fn(|k| {
                let remainder = weight(self.rate_max, TAYLOR);
                let rate = |j: usize| blocks.get(j % n).map_or(0.0, |b| b.rate[j / n]);
                remainder.iter().enumerate().map(|(j, w)| w * math::powi(rate(j), k)).collect()
            }),
            integral: self.integral_of(&c),
            rows: [c.clone(), r1, r2, r3],
            rigid,
            statics,
        }
    }

    /// Modal coordinates of displacements and velocities `[q | q']` of the bars' modes.
    pub fn to_modal(&self, hub: &[f64], y: &mut [f64]) {
        let mut padded = vec![0.0; self.hub];
        padded[..hub.len()].copy_from_slice(hub);
        kernel::multiply(&self.to_modal, &padded, y);
        if self.rough {
            let mut back = vec![0.0; 2 * self.modes];
            self.from_modal(y, &mut back);
            padded.iter_mut().zip(&back).for_each(|(x, b)| *x -= b);
            let mut more = vec![0.0; y.len()];
            kernel::multiply(&self.to_modal, &padded, &mut more);
            y.iter_mut().zip(&more).for_each(|(y, m)| *y += m);
        }
    }

    /// The reverse of [`Self::to_modal`].
    pub fn from_modal(&self, y: &[f64], hub: &mut [f64]) {
        kernel::multiply(&self.from_modal, y, hub);
    }

    /// `y += sign sum_j S_j f^(j)(t)`: the static part under the loads.
    pub fn add_static(&self, loads: &[Poly; CHANNELS], t: f64, sign: f64, y: &mut [f64]) {
        for (statics, load) in self.statics.iter().zip(loads) {
            let mut derivative = *load;
            for s in statics {
                let factor = sign * derivative.at(t);
                if factor != 0.0 {
                    kernel::add(y, factor, s);
                }
                if derivative.is_constant() {
                    break;
                }
                derivative = derivative.derivative();
            }
        }
    }

    /// The blocks as [`kernel::rotate`] takes them.
    pub fn generators(&self) -> &[f64] {
        &self.generators
    }

    /// Longest tabulated rotation not above `span`: its level and length, s.
    pub fn level_below(span: f64) -> Option<(usize, f64)> {
        if span < Self::length(0) {
            return None;
        }
        // The exponent bits: floor(log2 span) of a normal number.
        let exponent = ((span.to_bits() >> 52) & 0x7ff) as i32 - 1023;
        let level = ((exponent + SHORTEST) as usize).min(LEVELS - 1);
        Some((level, Self::length(level)))
    }

    /// Shortest tabulated rotation, s.
    pub fn shortest() -> f64 {
        Self::length(0)
    }

    fn length(level: usize) -> f64 {
        f64::from_bits(((1023 + level as i32 - SHORTEST) as u64) << 52)
    }

    /// `z := exp(B 2^level) z` for a tabulated level.
    pub fn rotate_level(&self, level: usize, z: &mut [f64]) {
        let e = self.rotations[level].get_or_init(|| self.exponential(Self::length(level)));
        kernel::rotate(e, z);
    }

    /// `z := exp(B span) z`; returns the number of rotations.
    pub fn rotate(&self, span: f64, z: &mut [f64]) -> u64 {
        let (mut left, mut count) = (span, 0);
        while left * self.rate_max > 0.03 {
            let Some((level, length)) = Self::level_below(left) else { break };
            self.rotate_level(level, z);
            left -= length;
            count += 1;
        }
        if left > 0.0 {
            self.rotate_short(left, z);
            count += 1;
        }
        count
    }

    /// Series of the exponential: `0.03^10 / 10!` is below rounding.
    fn rotate_short(&self, span: f64, z: &mut [f64]) {
        let mut room = vec![0.0; z.len()];
        kernel::series(&self.generators, span, 9, z, &mut room);
    }

    fn exponential(&self, span: f64) -> Vec<f64> {
        let n = self.n;
        let mut e = vec![0.0; 4 * n];
        for i in 0..n {
            let still = i >= self.blocks.len() || (self.rigid && i == 0);
            let x =
                if still { [1.0, 0.0, 0.0, 1.0] } else { block_exponential(&self.blocks[i], span) };
            for k in 0..4 {
                e[k * n + i] = x[k];
            }
        }
        e
    }

    /// `Q` with `d/dt z.Q z = - beta v.K v` along the flow: the damping work to come.
    pub fn damping_form(&self) -> &Form {
        self.damping_form.get_or_init(|| {
            let n = self.n;
            // Rows of the velocities, weighted: W = V^T diag(beta w^2) V.
            let mut w = vec![0.0; 4 * n * n];
            for i in 0..self.modes {
                let row = self.velocity_row(i);
                if self.damping[i] > 0.0 {
                    for (a, line) in w.chunks_exact_mut(2 * n).enumerate() {
                        let factor = self.damping[i] * row[a];
                        line.iter_mut().zip(row).for_each(|(x, r)| *x += factor * r);
                    }
                }
            }
            Form::new(&self.lyapunov(&w), 2 * n)
        })
    }

    /// `Q` with `d/dt z.Q z = - p'^2` along the flow, `p` the tip's displacement.
    pub fn viscous_form(&self) -> &Form {
        self.viscous_form.get_or_init(|| {
            let n = self.n;
            let mut w = vec![0.0; 4 * n * n];
            if let Some(tip) = self.tip_dashpot {
                let c = &self.functionals[tip].rows[1];
                for (a, line) in w.chunks_exact_mut(2 * n).enumerate() {
                    line.iter_mut().zip(c).for_each(|(x, r)| *x = c[a] * r);
                }
            }
            Form::new(&self.lyapunov(&w), 2 * n)
        })
    }

    /// Coefficients `u` with `u . z` the cross power `v_s . C v` of the velocities of a
    /// constant modal vector `s` with those of `z`.
    pub fn damping_cross(&self, s: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut u = vec![0.0; 2 * n];
        for i in 0..self.modes {
            let row = self.velocity_row(i);
            let factor = self.damping[i] * kernel::dot(row, s);
            u.iter_mut().zip(row).for_each(|(x, r)| *x += factor * r);
        }
        u
    }

    fn velocity_row(&self, mode: usize) -> &[f64] {
        let len = 2 * self.n;
        &self.from_modal[(self.modes + mode) * len..(self.modes + mode + 1) * len]
    }

    /// Solves `B^T Q + Q B = -W` block by block.
    fn lyapunov(&self, w: &[f64]) -> Vec<f64> {
        let (n, len) = (self.n, 2 * self.n);
        let mut q = vec![0.0; len * len];
        for i in usize::from(self.rigid)..self.blocks.len() {
            for k in usize::from(self.rigid)..self.blocks.len() {
                let at = [i * len + k, i * len + n + k, (n + i) * len + k, (n + i) * len + n + k];
                let source = at.map(|j| -w[j]);
                // Undamped blocks have no equation to solve; rigid bodies lose nothing.
                if source == [0.0; 4] {
                    continue;
                }
                let x = sylvester(&self.blocks[i], &self.blocks[k], source);
                for (j, v) in at.into_iter().zip(x) {
                    q[j] = v;
                }
            }
        }
        q
    }
}

/// Position of a uniform translation from its start and the loads.
pub fn translation(start: [f64; 2], gains: &[f64; CHANNELS], loads: &[Poly; CHANNELS]) -> Poly {
    let mut p = Poly::default();
    (p.0[0], p.0[1]) = (start[0], start[1]);
    for (gain, load) in gains.iter().zip(loads) {
        for k in 0..TERMS - 2 {
            p.0[k + 2] += gain * load.0[k] / ((k + 1) * (k + 2)) as f64;
        }
    }
    p
}
