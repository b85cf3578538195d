//! Spectrum of two bars held by point attachments.
//!
//! In the free bars' own modes the system is a diagonal one with one or two rank-one
//! attachments,
//!
//! ```text
//! (s^2 + beta w_i^2 s + w_i^2) q_i = - sum_a phi_{a,i} kappa_a(s) (phi_a . q),
//! ```
//!
//! `kappa = k + c s` at the bit's tip and `KC` across the gap. Its eigenvalues are the
//! zeros of the secular function `f(s) = det(1 + kappa R(s))`, with the receptances
//! `R_ab = sum_i phi_{a,i} phi_{b,i} / d_i(s)`. All of them are found at once by the
//! Ehrlich-Aberth iteration: O(N^2) a sweep, where a dense eigensolver takes O(N^3).
//! A root is kept as an offset from its nearest pole, so that `d_i` suffers no
//! cancellation there (the device of LAPACK's `dlaed4`).
//!
//! Two roots that nearly coincide (a nearly critically damped mode) have nearly parallel
//! eigenvectors. They are kept as one quadratic factor `(s - sigma)^2 + delta` with the
//! mean and the divided difference of the eigenvector: both are smooth through the
//! coincidence, and are taken from Cauchy integrals around the pair.

use crate::modal::receptance::Translations;
use crate::numerics::math::{self, norm};
use num_complex::Complex64 as C;

/// Two real coordinates of a system, `y' = b y`, and their shapes in the bars' modes.
#[derive(Clone, Debug)]
pub struct Block {
    /// The 2 by 2 matrix, row by row, 1/s.
    pub b: [f64; 4],
    /// Bound on the norm of `exp(b t)` is 1 for each; this is each coordinate's `|b|`, 1/s.
    pub rate: [f64; 2],
    /// Displacement shape of the first coordinate.
    pub first: Vec<f64>,
    /// Displacement shape of the second coordinate.
    pub second: Vec<f64>,
    /// True for `s^2`: uniform translation, whose motion is a polynomial.
    pub rigid: bool,
}

/// A diagonal system and its attachments.
#[derive(Clone, Debug)]
pub struct Secular<'a> {
    /// Squared frequencies of the bars' modes.
    pub omega2: &'a [f64],
    /// Kelvin-Voigt damping time, s.
    pub beta: f64,
    /// Attachments: shape, stiffness (N/m), viscosity (N s/m); at most two.
    pub attachments: Vec<Attachment<'a>>,
}

/// A spring and dashpot acting on the displacement `shape . q`.
#[derive(Clone, Copy, Debug)]
pub struct Attachment<'a> {
    /// Modal amplitudes of the point (or of the difference of two points).
    pub shape: &'a [f64],
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Viscosity, N s/m.
    pub viscosity: f64,
}

/// A root as an offset from a pole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub(crate) pole: usize,
    pub(crate) offset: C,
}

/// Real parts of a pair closer than this, relative to its size, are taken together.
pub(crate) const CONFLUENT: f64 = 0.15;
/// Sweeps of the Ehrlich-Aberth iteration; tens are needed at most.
const MAX_SWEEPS: usize = 400;
/// Both roots of `s^2 + beta w2 s + w2`.
fn free_poles(omega2: f64, beta: f64) -> [C; 2] {
    let half = -0.5 * beta * omega2;
    let disc = omega2 - half * half;
    if disc >= 0.0 {
        let w = disc.sqrt();
        [C::new(half, w), C::new(half, -w)]
    } else {
        let fast = half - (-disc).sqrt();
        [C::new(omega2 / fast, 0.0), C::new(fast, 0.0)]
    }
}

/// The block of `(s - sigma)^2 + delta` on shapes `mean` and `s * difference`.
pub(crate) fn quadratic_block(
    sigma: f64,
    delta: f64,
    scale: f64,
    mean: Vec<f64>,
    second: Vec<f64>,
) -> Block {
    let rate = sigma.abs() + scale.max(delta.abs() / scale);
    let exact = (delta - scale * scale).abs() <= 1e-12 * delta;
    let rate = if exact { math::hypot(sigma, scale) } else { rate };
    Block {
        b: [sigma, scale, -delta / scale, sigma],
        rate: [rate; 2],
        first: mean,
        second,
        rigid: false,
    }
}

/// The block of two distinct real roots.
pub(crate) fn real_block(roots: [f64; 2], first: Vec<f64>, second: Vec<f64>) -> Block {
    Block {
        b: [roots[0], 0.0, 0.0, roots[1]],
        rate: [-roots[0], -roots[1]],
        first,
        second,
        rigid: false,
    }
}

/// Blocks of a system without attachments: every mode by itself.
pub fn free_blocks(omega2: &[f64], beta: f64) -> Vec<Block> {
    (0..omega2.len())
        .map(|i| {
            let mut shape = vec![0.0; omega2.len()];
            shape[i] = 1.0;
            shape_block(omega2[i], beta, shape)
        })
        .collect()
}

/// The block of one free mode (or of a deflated pair) with the given shape.
fn shape_block(omega2: f64, beta: f64, shape: Vec<f64>) -> Block {
    let zero = vec![0.0; shape.len()];
    if omega2 == 0.0 {
        return Block {
            b: [0.0, 1.0, 0.0, 0.0],
            rate: [0.0; 2],
            first: shape,
            second: zero,
            rigid: true,
        };
    }
    let sigma = -0.5 * beta * omega2;
    let delta = omega2 - sigma * sigma;
    let size = delta.abs().sqrt();
    if size <= CONFLUENT * sigma.abs() {
        // The eigenvector does not depend on s: its divided difference is zero in
        // displacement, and the second coordinate is a pure velocity.
        return quadratic_block(sigma, delta, 0.5 * sigma.abs(), shape, zero);
    }
    if delta > 0.0 {
        return quadratic_block(sigma, delta, size, shape, zero);
    }
    let poles = free_poles(omega2, beta);
    real_block([poles[0].re, poles[1].re], shape.clone(), shape)
}

/// Blocks of a system with attachments.
///
/// # Errors
/// A reason, where the roots cannot be found to working accuracy.
pub fn blocks(system: &Secular) -> Result<Vec<Block>, &'static str> {
    let (merged, mut blocks) = deflate(system);
    let solver = Solver::new(merged);
    let roots = solver.solve()?;
    blocks.extend(solver.pair_up(&roots)?);
    // The rigid block first, then by rising rate: the slow ones outlive the fast.
    blocks.sort_by(|a, b| (!a.rigid).cmp(&!b.rigid).then(a.rate[0].total_cmp(&b.rate[0])));
    Ok(blocks)
}

/// Modes of the diagonal part after deflation.
pub(crate) struct Merged {
    pub(crate) omega2: Vec<f64>,
    pub(crate) beta: f64,
    /// Amplitudes of each attachment at the merged modes.
    pub(crate) shapes: Vec<Vec<f64>>,
    pub(crate) kappa: Vec<(f64, f64)>,
    /// Which hub modes stand behind a merged one, with their weights.
    pub(crate) members: Vec<Vec<(usize, f64)>>,
    pub(crate) hub: usize,
}

/// With a single attachment, two modes of equal frequency combine into one that feels it
/// and one that does not; the latter is an eigenvector already.
fn deflate(system: &Secular) -> (Merged, Vec<Block>) {
    let n = system.omega2.len();
    let mut merged = Merged {
        omega2: Vec::new(),
        beta: system.beta,
        shapes: vec![Vec::new(); system.attachments.len()],
        kappa: system.attachments.iter().map(|a| (a.stiffness, a.viscosity)).collect(),
        members: Vec::new(),
        hub: n,
    };
    let mut blocks = Vec::new();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| system.omega2[i].total_cmp(&system.omega2[j]));
    let single = system.attachments.len() == 1;
    let mut at = 0;
    while at < n {
        let i = order[at];
        let twin = order.get(at + 1).copied().filter(|&j| {
            let (a, b) = (system.omega2[i], system.omega2[j]);
            single && b - a <= 4.0 * f64::EPSILON * b
        });
        merged.omega2.push(system.omega2[i]);
        if let Some(j) = twin {
            let phi = system.attachments[0].shape;
            let norm = math::hypot(phi[i], phi[j]);
            let (ci, cj) = (phi[i] / norm, phi[j] / norm);
            merged.shapes[0].push(norm);
            merged.members.push(vec![(i, ci), (j, cj)]);
            let mut shape = vec![0.0; n];
            (shape[i], shape[j]) = (cj, -ci);
            blocks.push(shape_block(system.omega2[i], system.beta, shape));
            at += 2;
        } else {
            for (shape, attachment) in merged.shapes.iter_mut().zip(&system.attachments) {
                shape.push(attachment.shape[i]);
            }
            merged.members.push(vec![(i, 1.0)]);
            at += 1;
        }
    }
    (merged, blocks)
}

/// What the iteration says of one root.
enum Step {
    /// Move by this.
    By(C),
    /// The secular function is zero here.
    Exact,
    /// On a pole or on another root.
    Blocked,
}

pub(crate) struct Solver {
    pub(crate) system: Merged,
    /// Two poles a merged mode: `poles[2 i]`, `poles[2 i + 1]`.
    pub(crate) poles: Vec<C>,
    pub(crate) translations: Translations,
}

impl Solver {
    fn new(system: Merged) -> Self {
        let poles = system.omega2.iter().flat_map(|&w2| free_poles(w2, system.beta)).collect();
        let translations = Translations::new(&system);
        Self { system, poles, translations }
    }

    pub(crate) fn value(&self, root: Root) -> C {
        self.poles[root.pole] + root.offset
    }

    /// `root - poles[j]`, without cancellation.
    pub(crate) fn off_pole(&self, root: Root, j: usize) -> C {
        (self.poles[root.pole] - self.poles[j]) + root.offset
    }

    fn start(&self) -> Vec<Root> {
        let n = self.system.omega2.len();
        let lift: f64 = self
            .system
            .shapes
            .iter()
            .zip(&self.system.kappa)
            .map(|(shape, (k, _))| k * shape.iter().map(|x| x * x).sum::<f64>())
            .fold(0.0, f64::max);
        let mut roots = Vec::with_capacity(2 * n);
        for i in 0..n {
            for side in 0..2 {
                let here = self.poles[2 * i + side];
                let gap = if i + 1 < n {
                    norm(self.poles[2 * (i + 1) + side] - here)
                } else {
                    (self.system.omega2[i] + lift).sqrt() - self.system.omega2[i].sqrt()
                };
                // Overdamped modes crowd at -1 / beta: each root starts near its own pole.
                let gap = gap.max(1e-3 * norm(here)).max(1e-6 * lift.sqrt());
                // Not a conjugate pair: two roots must be free to part on the real axis.
                let step = if side == 0 { C::new(-0.11, 0.43) } else { C::new(-0.17, -0.37) };
                roots.push(Root { pole: 2 * i + side, offset: gap * step });
            }
        }
        roots
    }

    fn solve(&self) -> Result<Vec<Root>, &'static str> {
        let mut roots = self.start();
        let mut settled = vec![0u8; roots.len()];
        for sweep in 0..MAX_SWEEPS {
            let mut moving = false;
            for k in 0..roots.len() {
                if settled[k] >= 2 {
                    continue;
                }
                let step = match self.correction(&roots, k) {
                    Step::By(step) => step,
                    Step::Exact => {
                        settled[k] = 2;
                        continue;
                    }
                    Step::Blocked => {
                        roots[k].offset = 1.01 * roots[k].offset + C::new(1e-3, 2e-3);
                        moving = true;
                        continue;
                    }
                };
                let value = self.value(roots[k]);
                roots[k].offset -= step;
                let (size, near) = (norm(step), norm(roots[k].offset).min(norm(value)));
                // Two nearly coincident roots are known to the root of rounding only.
                if size <= 1e-14 * near || (sweep > 60 && size <= 1e-6 * near) {
                    settled[k] += 1;
                } else {
                    settled[k] = 0;
                }
                moving = true;
                self.rebase(&mut roots[k]);
            }
            if !moving {
                break;
            }
        }
        self.check(&roots)?;
        Ok(roots)
    }

    /// The Ehrlich-Aberth step `1 / (P'/P - sum_k 1/(x - x_k))`, `P = f prod d_i`.
    fn correction(&self, roots: &[Root], k: usize) -> Step {
        let (f, slope) = self.secular(roots[k]);
        if f == C::default() {
            return Step::Exact;
        }
        let mut sum = slope / f;
        for j in 0..self.poles.len() {
            sum += 1.0 / self.off_pole(roots[k], j);
            if j != k {
                let apart = (self.poles[roots[k].pole] - self.poles[roots[j].pole])
                    + (roots[k].offset - roots[j].offset);
                sum -= 1.0 / apart;
            }
        }
        let step = 1.0 / sum;
        if step.is_finite() { Step::By(step) } else { Step::Blocked }
    }

    /// Moves the origin of a root to its nearest pole.
    fn rebase(&self, root: &mut Root) {
        let mut best = root.pole;
        let mut distance = root.offset.norm_sqr();
        for j in 0..self.poles.len() {
            let d = self.off_pole(*root, j).norm_sqr();
            if d < 0.5 * distance {
                (best, distance) = (j, d);
            }
        }
        root.offset = self.off_pole(*root, best);
        root.pole = best;
    }

    /// The sum of the roots is minus the trace of the damping.
    fn check(&self, roots: &[Root]) -> Result<(), &'static str> {
        let sum: C = roots.iter().map(|&r| self.value(r)).sum();
        let size: f64 = roots.iter().map(|&r| norm(self.value(r))).sum();
        let mut trace: f64 = self.system.omega2.iter().map(|w2| self.system.beta * w2).sum();
        for (shape, (_, c)) in self.system.shapes.iter().zip(&self.system.kappa) {
            trace += c * shape.iter().map(|x| x * x).sum::<f64>();
        }
        if !sum.is_finite() || norm(sum + trace) > 1e-7 * size {
            return Err("the sum of the eigenvalues is not the trace of the damping");
        }
        Ok(())
    }
}
