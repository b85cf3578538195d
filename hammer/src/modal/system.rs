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
use crate::modal::basis::Basis;
pub use crate::modal::functional::{CHANNELS, Functional, ORDERS, TAYLOR};
use crate::modal::generator::Generator;
use crate::modal::spectrum;
use crate::modal::structure::Structure;
use crate::numerics::kernel::{self, Form};
use crate::numerics::poly::{Poly, TERMS};
use crate::physics::mode::Mode;
use std::sync::OnceLock;

/// What a system is made of.
pub struct Recipe<'a> {
    /// Bars and what is attached to them.
    pub structure: Structure<'a>,
    /// Modal loads of unit channel values.
    pub loads: [Vec<f64>; CHANNELS],
    /// Shapes of the functionals wanted.
    pub functionals: Vec<Vec<f64>>,
}

/// A vector that is missing or doubled shows as a mismatch near one, rounding under the
/// stiffest dashpots as 1e-4: beyond this, [`System::new`] refuses.
const BASIS_TOLERANCE: f64 = 1e-2;

/// A decomposed system.
#[derive(Debug)]
pub struct System {
    basis: Basis,
    generator: Generator,
    /// True if block 0 is a uniform translation.
    pub rigid: bool,
    /// Largest `|B|`, 1/s.
    pub rate_max: f64,
    /// `S_j`, per channel and order.
    pub statics: [Vec<Vec<f64>>; CHANNELS],
    /// Acceleration of the translation, per channel.
    pub gains: [f64; CHANNELS],
    /// As the recipe orders them.
    pub functionals: Vec<Functional>,
    damping: Vec<f64>,
    tip_dashpot: Option<usize>,
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
        let Recipe { structure, loads, functionals } = recipe;
        let fail = |reason| Error::Spectrum { mode, reason };
        let blocks = spectrum::blocks(&structure).map_err(fail)?;
        let generator = Generator::new(&blocks);
        let slowest = generator.least_entry().max(1e-6 * generator.rate_max);
        let basis = Basis::new(&structure, &blocks, slowest);
        if !basis.is_finite() {
            return Err(fail("an eigenvector is not finite"));
        }
        if basis.mismatch > BASIS_TOLERANCE {
            return Err(fail("a basis and its inverse do not fit"));
        }
        let mut system = Self {
            rigid: generator.rigid,
            rate_max: generator.rate_max,
            basis,
            generator,
            statics: Default::default(),
            gains: [0.0; CHANNELS],
            functionals: Vec::new(),
            damping: structure.omega2.iter().map(|w2| structure.beta * w2).collect(),
            tip_dashpot: tip,
            damping_form: OnceLock::new(),
            viscous_form: OnceLock::new(),
        };
        for (channel, load) in loads.iter().enumerate() {
            system.add_load(channel, load);
        }
        system.functionals = functionals.iter().map(|shape| system.functional(shape)).collect();
        Ok(system)
    }

    /// Number of blocks, padded to whole lanes; a modal vector is twice as long.
    pub fn blocks(&self) -> usize {
        self.generator.n
    }

    /// Number of modes of the bars; `[q | q']` is twice as long.
    pub fn modes(&self) -> usize {
        self.basis.modes
    }

    fn add_load(&mut self, channel: usize, load: &[f64]) {
        let (n, modes) = (self.blocks(), self.modes());
        let mut state = vec![0.0; 2 * modes];
        state[modes..].copy_from_slice(load);
        let mut b = vec![0.0; 2 * n];
        self.to_modal(&state, &mut b);
        if self.rigid {
            self.gains[channel] = b[n];
        }
        for _ in 0..ORDERS {
            b = self.generator.solve(&b);
            self.statics[channel].push(b.iter().map(|x| -x).collect());
        }
    }

    fn functional(&self, shape: &[f64]) -> Functional {
        let mut c = vec![0.0; 2 * self.blocks()];
        for (i, s) in shape.iter().enumerate() {
            for (cj, m) in c.iter_mut().zip(self.basis.displacement_row(i)) {
                *cj += s * m;
            }
        }
        Functional::new(c, &self.generator, &self.statics)
    }

    /// `y B^-1`, the coefficients of an integral.
    pub fn integral_of(&self, row: &[f64]) -> Vec<f64> {
        self.generator.integrate(row)
    }

    /// Modal coordinates of displacements and velocities `[q | q']` of the bars' modes.
    pub fn to_modal(&self, state: &[f64], y: &mut [f64]) {
        self.basis.enter(state, y);
    }

    /// The reverse of [`Self::to_modal`].
    pub fn from_modal(&self, y: &[f64], state: &mut [f64]) {
        self.basis.leave(y, state);
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
        self.generator.columns()
    }

    /// Longest tabulated rotation not above `span`: its level and length, s.
    pub fn level_below(span: f64) -> Option<(usize, f64)> {
        Generator::level_below(span)
    }

    /// Shortest tabulated rotation, s.
    pub fn shortest() -> f64 {
        Generator::length(0)
    }

    /// `z := exp(B span) z`; returns the number of rotations.
    pub fn rotate(&self, span: f64, z: &mut [f64]) -> u64 {
        self.generator.rotate(span, z)
    }

    /// `Q` with `d/dt z.Q z = - beta v.K v` along the flow: the damping work to come.
    pub fn damping_form(&self) -> &Form {
        self.damping_form.get_or_init(|| {
            let n = self.blocks();
            // Rows of the velocities, weighted: W = V^T diag(beta w^2) V.
            let mut w = vec![0.0; 4 * n * n];
            for i in 0..self.modes() {
                let row = self.basis.velocity_row(i);
                if self.damping[i] > 0.0 {
                    for (a, line) in w.chunks_exact_mut(2 * n).enumerate() {
                        let factor = self.damping[i] * row[a];
                        line.iter_mut().zip(row).for_each(|(x, r)| *x += factor * r);
                    }
                }
            }
            Form::new(&self.generator.lyapunov(&w), 2 * n)
        })
    }

    /// `Q` with `d/dt z.Q z = - p'^2` along the flow, `p` the tip's displacement.
    pub fn viscous_form(&self) -> &Form {
        self.viscous_form.get_or_init(|| {
            let n = self.blocks();
            let mut w = vec![0.0; 4 * n * n];
            if let Some(tip) = self.tip_dashpot {
                let c = &self.functionals[tip].rows[1];
                for (a, line) in w.chunks_exact_mut(2 * n).enumerate() {
                    line.iter_mut().zip(c).for_each(|(x, r)| *x = c[a] * r);
                }
            }
            Form::new(&self.generator.lyapunov(&w), 2 * n)
        })
    }

    /// Coefficients `u` with `u . z` the cross power `v_s . C v` of the velocities of a
    /// constant modal vector `s` with those of `z`.
    pub fn damping_cross(&self, s: &[f64]) -> Vec<f64> {
        let mut u = vec![0.0; 2 * self.blocks()];
        for i in 0..self.modes() {
            let row = self.basis.velocity_row(i);
            let factor = self.damping[i] * kernel::dot(row, s);
            u.iter_mut().zip(row).for_each(|(x, r)| *x += factor * r);
        }
        u
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
