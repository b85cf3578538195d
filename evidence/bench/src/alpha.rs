//! Generalised-alpha with fixed steps: second order, dissipative, event-driven.
//!
//! Chung and Hulbert (1993), with the spectral radius `r` at infinite frequency:
//!
//! ```text
//! am = (2r - 1)/(r + 1), af = r/(r + 1), g = 1/2 - am + af, b = (1 - am + af)^2/4
//! M a_{n+1-am} + C v_{n+1-af} + K u_{n+1-af} = load
//! u_{n+1} = u_n + h v_n + h^2 ((1/2 - b) a_n + b a_{n+1})
//! v_{n+1} = v_n + h ((1 - g) a_n + g a_{n+1})
//! ```
//!
//! The family holds Newmark and, with `am = 0`, HHT. The matrix of a mode is
//! factorised once for the nominal step; other lengths (to an event, to an
//! instant) cost a factorisation of a tridiagonal matrix.

use crate::hybrid::OneStep;
use oracles::law::{Memory, Mode, Rock, State};
use oracles::linear::{Factor, Tridiagonal};
use oracles::model::{Model, System};

/// The method, for one model.
pub struct Alpha {
    nominal: f64,
    am: f64,
    af: f64,
    beta: f64,
    gamma: f64,
    viscosity: f64,
    mass: Tridiagonal<f64>,
    systems: Vec<System<f64>>,
    factors: Vec<Factor<f64>>,
    index: usize,
    dissipates: bool,
    load: Vec<f64>,
    start: Vec<f64>,
    end: Vec<f64>,
    scratch: [Vec<f64>; 2],
}

impl Alpha {
    /// Steps of `nominal` seconds, spectral radius `radius`.
    pub fn new(model: &Model<f64>, nominal: f64, radius: f64) -> Self {
        let am = (2.0 * radius - 1.0) / (radius + 1.0);
        let af = radius / (radius + 1.0);
        let zero = vec![0.0; model.nodes()];
        let mut alpha = Self {
            nominal,
            am,
            af,
            beta: 0.25 * (1.0 - am + af).powi(2),
            gamma: 0.5 - am + af,
            viscosity: model.scene.rock.viscosity,
            mass: model.mass.clone(),
            systems: model.systems.clone(),
            factors: Vec::new(),
            index: 0,
            dissipates: false,
            load: zero.clone(),
            start: zero.clone(),
            end: zero.clone(),
            scratch: [zero.clone(), zero],
        };
        alpha.factors = (0..8).map(|i| alpha.matrix(i, nominal).factor()).collect();
        alpha
    }

    fn matrix(&self, index: usize, h: f64) -> Tridiagonal<f64> {
        let system = &self.systems[index];
        let (m, c, k) =
            (1.0 - self.am, (1.0 - self.af) * self.gamma * h, (1.0 - self.af) * self.beta * h * h);
        Tridiagonal::combine([(m, &self.mass), (c, &system.damping), (k, &system.stiffness)])
    }
}

impl OneStep for Alpha {
    fn enter(&mut self, model: &Model<f64>, mode: Mode, memory: &Memory<f64>, state: &State<f64>) {
        self.index = mode.system_index();
        self.dissipates = mode.rock == Rock::DFC;
        self.load = model.load(mode, memory);
        model.acceleration(mode, &self.load, &state.u, &state.v, &mut self.start);
    }

    fn length(&self) -> f64 {
        self.nominal
    }

    fn step(&mut self, from: &State<f64>, h: f64, to: &mut State<f64>) -> bool {
        self.partial(from, h, to);
        true
    }

    fn partial(&mut self, from: &State<f64>, h: f64, to: &mut State<f64>) {
        let n = from.u.len();
        let (am, af, beta, gamma) = (self.am, self.af, self.beta, self.gamma);
        let [u, v] = &mut self.scratch;
        let a = &self.start;
        for i in 0..n {
            // What is known of the displacement and velocity at n + 1 - af.
            to.u[i] = from.u[i] + h * from.v[i] + h * h * (0.5 - beta) * a[i];
            to.v[i] = from.v[i] + h * (1.0 - gamma) * a[i];
            u[i] = (1.0 - af) * to.u[i] + af * from.u[i];
            v[i] = (1.0 - af) * to.v[i] + af * from.v[i];
        }
        self.end.copy_from_slice(&self.load);
        self.systems[self.index].stiffness.subtract_product(u, &mut self.end);
        self.systems[self.index].damping.subtract_product(v, &mut self.end);
        if am != 0.0 {
            u.iter_mut().zip(a).for_each(|(u, a)| *u = am * a);
            self.mass.subtract_product(u, &mut self.end);
        }
        if h == self.nominal {
            self.factors[self.index].solve(&mut self.end);
        } else {
            self.matrix(self.index, h).factor().solve(&mut self.end);
        }
        for i in 0..n {
            to.u[i] += h * h * beta * self.end[i];
            to.v[i] += h * gamma * self.end[i];
        }
        let (before, after) = (from.v[n - 1], to.v[n - 1]);
        let work = 0.5 * h * self.viscosity * (before * before + after * after);
        to.psi = from.psi + if self.dissipates { work } else { 0.0 };
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }
}
