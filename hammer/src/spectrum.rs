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
struct Root {
    pole: usize,
    offset: C,
}

/// Real parts of a pair closer than this, relative to its size, are taken together.
const CONFLUENT: f64 = 0.03;
/// Sweeps of the Ehrlich-Aberth iteration; tens are needed at most.
const MAX_SWEEPS: usize = 400;
/// Nodes of a Cauchy integral: 0.3^48 is far below rounding.
const CAUCHY_NODES: usize = 48;

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
fn quadratic_block(sigma: f64, delta: f64, scale: f64, mean: Vec<f64>, second: Vec<f64>) -> Block {
    let rate = sigma.abs() + scale.max(delta.abs() / scale);
    let exact = (delta - scale * scale).abs() <= 1e-12 * delta;
    let rate = if exact { sigma.hypot(scale) } else { rate };
    Block {
        b: [sigma, scale, -delta / scale, sigma],
        rate: [rate; 2],
        first: mean,
        second,
        rigid: false,
    }
}

/// The block of two distinct real roots.
fn real_block(roots: [f64; 2], first: Vec<f64>, second: Vec<f64>) -> Block {
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
struct Merged {
    omega2: Vec<f64>,
    beta: f64,
    /// Amplitudes of each attachment at the merged modes.
    shapes: Vec<Vec<f64>>,
    kappa: Vec<(f64, f64)>,
    /// Which hub modes stand behind a merged one, with their weights.
    members: Vec<Vec<(usize, f64)>>,
    hub: usize,
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
            let norm = phi[i].hypot(phi[j]);
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

/// Receptances and their derivatives.
#[derive(Clone, Copy, Default)]
struct Receptance {
    r11: C,
    r12: C,
    r22: C,
    d11: C,
    d12: C,
    d22: C,
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

/// Nodes of a Cauchy integral, each also relative to the centre.
struct Circle {
    centre: f64,
    pole: usize,
    nodes: Vec<(C, Root)>,
}

struct Solver {
    system: Merged,
    /// Two poles a merged mode: `poles[2 i]`, `poles[2 i + 1]`.
    poles: Vec<C>,
}

impl Solver {
    fn new(system: Merged) -> Self {
        let poles = system.omega2.iter().flat_map(|&w2| free_poles(w2, system.beta)).collect();
        Self { system, poles }
    }

    fn value(&self, root: Root) -> C {
        self.poles[root.pole] + root.offset
    }

    /// `root - poles[j]`, without cancellation.
    fn off_pole(&self, root: Root, j: usize) -> C {
        (self.poles[root.pole] - self.poles[j]) + root.offset
    }

    fn receptance(&self, root: Root) -> Receptance {
        let mut r = Receptance::default();
        let two = self.system.shapes.len() == 2;
        for i in 0..self.system.omega2.len() {
            let (a, b) = (self.off_pole(root, 2 * i), self.off_pole(root, 2 * i + 1));
            let inverse = 1.0 / (a * b);
            let slope = -(a + b) * inverse * inverse;
            let x = self.system.shapes[0][i];
            r.r11 += x * x * inverse;
            r.d11 += x * x * slope;
            if two {
                let y = self.system.shapes[1][i];
                r.r12 += x * y * inverse;
                r.d12 += x * y * slope;
                r.r22 += y * y * inverse;
                r.d22 += y * y * slope;
            }
        }
        r
    }

    /// The secular function and its derivative.
    fn secular(&self, root: Root) -> (C, C) {
        let s = self.value(root);
        let r = self.receptance(root);
        let (k1, c1) = self.system.kappa[0];
        let kappa = k1 + c1 * s;
        let (f1, g1) = (1.0 + kappa * r.r11, c1 * r.r11 + kappa * r.d11);
        if self.system.shapes.len() == 1 {
            return (f1, g1);
        }
        let (k2, c2) = self.system.kappa[1];
        let kappa2 = k2 + c2 * s;
        let (f2, g2) = (1.0 + kappa2 * r.r22, c2 * r.r22 + kappa2 * r.d22);
        let cross = kappa * kappa2 * r.r12 * r.r12;
        let cross_slope =
            (c1 * kappa2 + kappa * c2) * r.r12 * r.r12 + 2.0 * kappa * kappa2 * r.r12 * r.d12;
        (f1 * f2 - cross, g1 * f2 + f1 * g2 - cross_slope)
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
            let here = self.poles[2 * i].norm();
            let next = if i + 1 < n {
                self.system.omega2[i + 1].sqrt()
            } else {
                (self.system.omega2[i] + lift).sqrt()
            };
            let gap = (next - here).abs().max(1e-3 * next);
            for side in 0..2 {
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
                let (size, near) = (step.norm(), roots[k].offset.norm().min(value.norm()));
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
        let size: f64 = roots.iter().map(|&r| self.value(r).norm()).sum();
        let mut trace: f64 = self.system.omega2.iter().map(|w2| self.system.beta * w2).sum();
        for (shape, (_, c)) in self.system.shapes.iter().zip(&self.system.kappa) {
            trace += c * shape.iter().map(|x| x * x).sum::<f64>();
        }
        if !sum.is_finite() || (sum + trace).norm() > 1e-7 * size {
            return Err("the sum of the eigenvalues is not the trace of the damping");
        }
        Ok(())
    }

    /// Amplitudes of the attachments' forces in the eigenvector at `s`: analytic in `s`.
    fn forces(&self, root: Root, second: bool) -> [C; 2] {
        if self.system.shapes.len() == 1 {
            return [C::new(1.0, 0.0), C::default()];
        }
        let (s, r) = (self.value(root), self.receptance(root));
        let kappa = self.system.kappa.iter().map(|(k, c)| k + c * s).collect::<Vec<_>>();
        if second {
            [-kappa[0] * r.r12, 1.0 + kappa[0] * r.r11]
        } else {
            [1.0 + kappa[1] * r.r22, -kappa[1] * r.r12]
        }
    }

    fn prefers_second(&self, root: Root) -> bool {
        let (first, second) = (self.forces(root, false), self.forces(root, true));
        let size = |f: [C; 2]| f[0].norm_sqr() + f[1].norm_sqr();
        // Each row of the singular 2 by 2 matrix gives the vector; the larger gives it better.
        let scale = |i: usize| (self.system.kappa[i].0).max(self.system.kappa[i].1).max(1.0);
        self.system.shapes.len() == 2
            && size(second) / scale(0).powi(2) > size(first) / scale(1).powi(2)
    }

    /// The eigenvector in the bars' modes, not normalised.
    fn vector(&self, root: Root, second: bool) -> Vec<C> {
        let forces = self.forces(root, second);
        let mut v = vec![C::default(); self.system.hub];
        for i in 0..self.system.omega2.len() {
            let d = self.off_pole(root, 2 * i) * self.off_pole(root, 2 * i + 1);
            let mut push = C::default();
            for (shape, force) in self.system.shapes.iter().zip(forces) {
                push += shape[i] * force;
            }
            for &(hub, weight) in &self.system.members[i] {
                v[hub] = weight * push / d;
            }
        }
        v
    }

    fn pair_up(&self, roots: &[Root]) -> Result<Vec<Block>, &'static str> {
        let (mut reals, mut blocks) = (Vec::new(), Vec::new());
        let (mut upper, mut lower) = (0usize, 0usize);
        for (k, &root) in roots.iter().enumerate() {
            let s = self.value(root);
            if s.im.abs() <= CONFLUENT * s.re.abs() {
                reals.push((s, k));
            } else if s.im > 0.0 {
                upper += 1;
                blocks.push(self.oscillation(root));
            } else {
                lower += 1;
            }
        }
        if upper != lower || reals.len() % 2 != 0 {
            return Err("the eigenvalues are not in conjugate pairs");
        }
        // Slowest with fastest, and so inward: a confluent pair meets in the middle.
        reals.sort_by(|a, b| b.0.re.total_cmp(&a.0.re));
        self.close_pairs(roots, &mut reals, &mut blocks);
        let half = reals.len() / 2;
        for i in 0..half {
            let pair = [reals[i], reals[reals.len() - 1 - i]];
            let shapes = pair.map(|(_, k)| {
                let v = self.vector(roots[k], self.prefers_second(roots[k]));
                unit(v.iter().map(|z| z.re).collect())
            });
            let [first, second] = shapes;
            blocks.push(real_block([pair[0].0.re, pair[1].0.re], first, second));
        }
        Ok(blocks)
    }

    /// Takes out of `reals` the pairs that nearly coincide.
    fn close_pairs(&self, roots: &[Root], reals: &mut Vec<(C, usize)>, blocks: &mut Vec<Block>) {
        let mut i = 0;
        while i + 1 < reals.len() {
            let (a, b) = (reals[i], reals[i + 1]);
            let close = (a.0 - b.0).norm() <= 2.0 * CONFLUENT * a.0.norm();
            match close.then(|| self.circle(roots, a.1, b.1)).flatten() {
                Some(circle) => {
                    blocks.push(self.confluent(circle));
                    reals.drain(i..i + 2);
                }
                None if (a.0 - b.0.conj()).norm() < 1e-3 * (a.0 - b.0).norm() => {
                    let upper = if a.0.im > 0.0 { a.1 } else { b.1 };
                    blocks.push(self.oscillation(roots[upper]));
                    reals.drain(i..i + 2);
                }
                None => i += 1,
            }
        }
    }

    fn oscillation(&self, root: Root) -> Block {
        let s = self.value(root);
        let v = self.vector(root, self.prefers_second(root));
        // The phase is free: the largest component made real keeps the shapes tame.
        let big =
            v.iter().fold(C::default(), |m, z| if z.norm_sqr() > m.norm_sqr() { *z } else { m });
        let norm = v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        let turn = big.conj() / big.norm() / norm;
        let v: Vec<C> = v.iter().map(|z| z * turn).collect();
        let mean = v.iter().map(|z| z.re).collect();
        let second = v.iter().map(|z| z.im).collect();
        quadratic_block(s.re, s.im * s.im, s.im, mean, second)
    }

    /// Points around two roots that keep every pole and every other root well outside;
    /// none if something stands between them (then they are not confluent).
    fn circle(&self, roots: &[Root], i: usize, j: usize) -> Option<Circle> {
        let (a, b) = (self.value(roots[i]), self.value(roots[j]));
        let centre = 0.5 * (a + b).re;
        let mut reach = centre.abs();
        for (k, &root) in roots.iter().enumerate() {
            if k != i && k != j {
                reach = reach.min((self.value(root) - centre).norm());
            }
        }
        for pole in &self.poles {
            reach = reach.min((pole - centre).norm());
        }
        let radius = 0.3 * reach;
        if (a - b).norm() > radius {
            return None;
        }
        let pole = roots[i].pole;
        let nodes = (0..CAUCHY_NODES).map(|m| {
            let angle = 2.0 * std::f64::consts::PI * (m as f64 + 0.5) / CAUCHY_NODES as f64;
            let z = radius * C::from_polar(1.0, angle);
            (z, Root { pole, offset: (centre - self.poles[pole]) + z })
        });
        Some(Circle { centre, pole, nodes: nodes.collect() })
    }

    /// The block of two nearly coincident roots, by Cauchy integrals around them.
    fn confluent(&self, circle: Circle) -> Block {
        let Circle { centre, pole, nodes } = circle;
        // Argument principle: sums of the first and second powers of the two roots.
        let count = CAUCHY_NODES as f64;
        let (mut first, mut second) = (0.0, 0.0);
        for &(z, root) in &nodes {
            let (f, slope) = self.secular(root);
            let slope = slope / f;
            first += (z * z * slope).re / count;
            second += (z * z * z * slope).re / count;
        }
        let shift = 0.5 * first;
        let (sigma, delta) = (centre + shift, shift * shift - 0.5 * second);
        let middle = Root { pole, offset: C::new(sigma, 0.0) - self.poles[pole] };
        let choice = self.prefers_second(middle);
        let mut mean = vec![0.0; self.system.hub];
        let mut difference = mean.clone();
        for &(z, root) in &nodes {
            let y = z - shift;
            let weight = z / (y * y + delta) / count;
            for (h, v) in self.vector(root, choice).iter().enumerate() {
                mean[h] += (v * y * weight).re;
                difference[h] += (v * weight).re;
            }
        }
        let scale = 0.5 * sigma.abs();
        let norm = mean.iter().chain(&difference).map(|x| x * x).sum::<f64>().sqrt();
        let mean = mean.iter().map(|x| x / norm).collect();
        let second = difference.iter().map(|x| x * scale / norm).collect();
        quadratic_block(sigma, delta, scale, mean, second)
    }
}

fn unit(v: Vec<f64>) -> Vec<f64> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.iter().map(|x| x / norm).collect()
}
