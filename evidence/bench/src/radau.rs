//! Radau IIA of order 5 with adaptive steps, on the second-order system.
//!
//! The mode is linear, so the three stages need no iteration: with Hairer and
//! Wanner's transformation (Solving ODEs II, section IV.8) they are one real and
//! one complex system `(s - A) x = c f`, and eliminating the velocities leaves
//!
//! ```text
//! (s^2 M + s C + K) xu = c (load - K u - C v) + (s M + C) c v,   xv = s xu - c v
//! ```
//!
//! tridiagonal again, factorised once a mode and step length. The error estimate
//! is theirs, of order 3. The viscous work is the quadrature at the stages.

use num_complex::Complex64;
use oracles::law::{Memory, Mode, Rock, State};
use oracles::linear::{Factor, Field, Tridiagonal};
use oracles::model::{Model, System};

/// `T` of the transformation, stages from transformed stages.
const T: [[f64; 3]; 3] = [
    [9.123_239_487_089_294e-2, -1.412_552_950_209_542e-1, -3.002_919_410_514_742_4e-2],
    [2.417_179_327_071_07e-1, 2.041_293_522_937_999_4e-1, 3.829_421_127_572_619e-1],
    [9.660_481_826_150_93e-1, 1.0, 0.0],
];

/// Row sums of its inverse: the stages see the same right-hand side.
const ROW_SUMS: [f64; 3] = [
    4.325_579_890_063_155 + 3.391_992_518_158_098_6e-1 + 5.417_705_399_358_749e-1,
    -4.178_718_591_551_905 - 3.276_828_207_610_624e-1 + 4.766_235_545_005_504_4e-1,
    -5.028_726_349_457_868e-1 + 2.571_926_949_855_605 - 5.960_392_048_282_249e-1,
];

/// First step of an adaptive run, s.
const RESTART: f64 = 1e-8;

/// Longest step, s. A rigid body gives `s^2 M` nothing but the inertia to solve with
/// beside `K`: at `1e-3` s rounding alone costs eight digits of the flight.
const LONGEST: f64 = 2e-5;

/// Factors for one system and one step length.
struct Factors {
    h: f64,
    real: f64,
    complex: Complex64,
    real_factor: Factor<f64>,
    complex_factor: Factor<Complex64>,
}

/// The method, for one model.
pub struct Radau {
    length: f64,
    tolerance: f64,
    viscosity: f64,
    mass: Tridiagonal<f64>,
    systems: Vec<System<f64>>,
    factors: Vec<Option<Factors>>,
    index: usize,
    dissipates: bool,
    load: Vec<f64>,
    force: Vec<f64>,
    stages: [Vec<f64>; 6],
}

/// Reciprocal eigenvalues of Butcher's matrix.
fn eigenvalues() -> (f64, Complex64) {
    let (c9, c3) = (81f64.cbrt(), 9f64.cbrt());
    let real = 30.0 / (6.0 + c9 - c3);
    let (a, b) = ((12.0 - c9 + c3) / 60.0, (c9 + c3) * 3f64.sqrt() / 60.0);
    (real, Complex64::new(a, b) / (a * a + b * b))
}

fn dynamic<T: Field>(mass: &Tridiagonal<f64>, system: &System<f64>, s: T) -> Factor<T> {
    let lift = |a: f64, b: f64, c: f64| (s * T::from(a) + T::from(b)) * s + T::from(c);
    let rows = |m: &[f64], c: &[f64], k: &[f64]| {
        m.iter().zip(c).zip(k).map(|((&m, &c), &k)| lift(m, c, k)).collect()
    };
    let (c, k) = (&system.damping, &system.stiffness);
    Tridiagonal {
        diagonal: rows(&mass.diagonal, &c.diagonal, &k.diagonal),
        off: rows(&mass.off, &c.off, &k.off),
    }
    .factor()
}

impl Factors {
    fn new(mass: &Tridiagonal<f64>, system: &System<f64>, h: f64) -> Self {
        let (real, complex) = eigenvalues();
        let (real, complex) = (real / h, complex / h);
        Self {
            h,
            real,
            complex,
            real_factor: dynamic(mass, system, real),
            complex_factor: dynamic(mass, system, complex),
        }
    }
}

impl Radau {
    /// Local errors over 1 mm and 1 m/s below `tolerance`.
    pub fn new(model: &Model<f64>, tolerance: f64) -> Self {
        let zero = || vec![0.0; model.nodes()];
        Self {
            length: RESTART,
            tolerance,
            viscosity: model.scene.rock.viscosity,
            mass: model.mass.clone(),
            systems: model.systems.clone(),
            factors: (0..8).map(|_| None).collect(),
            index: 0,
            dissipates: false,
            load: zero(),
            force: zero(),
            stages: std::array::from_fn(|_| zero()),
        }
    }

    /// The transformed stages, `u` then `v` of each.
    fn transformed(&mut self, from: &State<f64>, factors: &Factors) {
        let n = from.u.len();
        let system = &self.systems[self.index];
        self.force.copy_from_slice(&self.load);
        system.stiffness.subtract_product(&from.u, &mut self.force);
        system.damping.subtract_product(&from.v, &mut self.force);
        let mut minus_mv = vec![0.0; n];
        let mut minus_cv = vec![0.0; n];
        self.mass.subtract_product(&from.v, &mut minus_mv);
        system.damping.subtract_product(&from.v, &mut minus_cv);
        let c1 = ROW_SUMS[0];
        let c2 = Complex64::new(ROW_SUMS[1], ROW_SUMS[2]);
        let mut real = vec![0.0; n];
        let mut complex = vec![Complex64::default(); n];
        for i in 0..n {
            let (m, c) = (minus_mv[i], minus_cv[i]);
            real[i] = c1 * (self.force[i] - factors.real * m - c);
            complex[i] = c2 * (self.force[i] - c - factors.complex * m);
        }
        factors.real_factor.solve(&mut real);
        factors.complex_factor.solve(&mut complex);
        for i in 0..n {
            let v = from.v[i];
            let speed = factors.complex * complex[i] - c2 * v;
            self.stages[0][i] = real[i];
            self.stages[1][i] = complex[i].re;
            self.stages[2][i] = complex[i].im;
            self.stages[3][i] = factors.real * real[i] - c1 * v;
            self.stages[4][i] = speed.re;
            self.stages[5][i] = speed.im;
        }
    }

    /// Stage increment `i` of displacement (`block` 0) or velocity (3).
    fn stage(&self, i: usize, block: usize, node: usize) -> f64 {
        (0..3).map(|j| T[i][j] * self.stages[block + j][node]).sum()
    }

    fn work(&self, from: &State<f64>, h: f64) -> f64 {
        if !self.dissipates {
            return 0.0;
        }
        let (tip, root) = (from.v.len() - 1, 6f64.sqrt());
        let weights = [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0];
        let sum: f64 =
            (0..3).map(|i| weights[i] * (from.v[tip] + self.stage(i, 3, tip)).powi(2)).sum();
        h * self.viscosity * sum
    }

    fn take(&mut self, from: &State<f64>, to: &mut State<f64>, factors: &Factors) {
        self.transformed(from, factors);
        for i in 0..from.u.len() {
            to.u[i] = from.u[i] + self.stage(2, 0, i);
            to.v[i] = from.v[i] + self.stage(2, 3, i);
        }
        to.psi = from.psi + self.work(from, factors.h);
    }

    /// Hairer and Wanner's estimate, 1 mm and 1 m/s as units.
    fn estimate(&self, from: &State<f64>, factors: &Factors) -> f64 {
        let n = from.u.len();
        let root = 6f64.sqrt();
        let weights = [-(13.0 + 7.0 * root) / 3.0, (-13.0 + 7.0 * root) / 3.0, -1.0 / 3.0];
        let sum = |block: usize, node: usize| -> f64 {
            (0..3).map(|i| weights[i] * self.stage(i, block, node)).sum::<f64>() / factors.h
        };
        // Solve (s - A)(x, y) = (v + e, a + f) with M a = force.
        let e: Vec<f64> = (0..n).map(|i| from.v[i] + sum(0, i)).collect();
        let f: Vec<f64> = (0..n).map(|i| -sum(3, i) - factors.real * e[i]).collect();
        let mut x = self.force.clone();
        self.mass.subtract_product(&f, &mut x);
        let minus: Vec<f64> = e.iter().map(|e| -e).collect();
        self.systems[self.index].damping.subtract_product(&minus, &mut x);
        factors.real_factor.solve(&mut x);
        (0..n).fold(0.0, |max, i| {
            let speed = factors.real * x[i] - e[i];
            max.max(x[i].abs() * 1e3).max(speed.abs())
        })
    }

    /// Factors of the present system for `h`, kept for the next time.
    fn factors(&mut self, h: f64) -> Factors {
        match self.factors[self.index].take() {
            Some(factors) if factors.h == h => factors,
            _ => Factors::new(&self.mass, &self.systems[self.index], h),
        }
    }

    /// A mode begins.
    pub fn enter(&mut self, model: &Model<f64>, mode: Mode, memory: &Memory<f64>) {
        self.index = mode.system_index();
        self.dissipates = mode.rock == Rock::DFC;
        self.load = model.load(mode, memory);
    }

    /// The step it would take next, s.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// A step of `h` from `from` to `to`; false if the error was too large and
    /// [`Radau::length`] has been shortened.
    pub fn step(&mut self, from: &State<f64>, h: f64, to: &mut State<f64>) -> bool {
        let factors = self.factors(h);
        self.take(from, to, &factors);
        let error = self.estimate(from, &factors) / self.tolerance;
        let accepted = error <= 1.0;
        let factor = 0.9 * error.max(1e-12).powf(-0.25);
        // A step cut by an instant says nothing; a small gain is not worth a factorisation.
        if !accepted || factor > 1.2 && h >= self.length && h < LONGEST {
            self.length = (h * factor.clamp(0.2, 5.0)).min(LONGEST);
        }
        self.factors[self.index] = Some(factors);
        accepted
    }

    /// A step of any length from `from`, unconditionally.
    pub fn partial(&mut self, from: &State<f64>, h: f64, to: &mut State<f64>) {
        let factors = Factors::new(&self.mass, &self.systems[self.index], h);
        self.take(from, to, &factors);
    }
}
