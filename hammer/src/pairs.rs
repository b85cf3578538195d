//! From roots to blocks: eigenvectors, conjugate pairs, and pairs that nearly coincide.

use crate::math::{norm, powi, sin_cos};
use crate::spectrum::{Block, CONFLUENT, Root, Solver, quadratic_block, real_block};
use num_complex::Complex64 as C;

/// Nodes of a Cauchy integral: 0.3^48 is far below rounding.
const CAUCHY_NODES: usize = 48;

/// Nodes of a Cauchy integral, each also relative to the centre.
struct Circle {
    centre: f64,
    pole: usize,
    nodes: Vec<(C, Root)>,
}

impl Solver {
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
            && size(second) / powi(scale(0), 2) > size(first) / powi(scale(1), 2)
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

    pub(crate) fn pair_up(&self, roots: &[Root]) -> Result<Vec<Block>, &'static str> {
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
            let close = norm(a.0 - b.0) <= 2.0 * CONFLUENT * norm(a.0);
            match close.then(|| self.circle(roots, a.1, b.1)).flatten() {
                Some(circle) => {
                    blocks.push(self.confluent(circle));
                    reals.drain(i..i + 2);
                }
                None if norm(a.0 - b.0.conj()) < 1e-3 * norm(a.0 - b.0) => {
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
        let length = v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        let turn = big.conj() / norm(big) / length;
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
                reach = reach.min(norm(self.value(root) - centre));
            }
        }
        for pole in &self.poles {
            reach = reach.min(norm(pole - centre));
        }
        let radius = 0.3 * reach;
        if norm(a - b) > radius {
            return None;
        }
        let pole = roots[i].pole;
        let nodes = (0..CAUCHY_NODES).map(|m| {
            let angle = 2.0 * std::f64::consts::PI * (m as f64 + 0.5) / CAUCHY_NODES as f64;
            let (sin, cos) = sin_cos(angle);
            let z = radius * C::new(cos, sin);
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
