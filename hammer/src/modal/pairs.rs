//! From roots to blocks: eigenvectors, conjugate pairs, and pairs that nearly coincide.

use crate::modal::basis::inner_product as dot;
use crate::modal::receptance::Receptance;
use crate::modal::spectrum::{Block, CONFLUENT, Root, Solver, quadratic_block, real_block};
use crate::numerics::math::{norm, sin_cos};
use num_complex::Complex64 as C;

/// Nodes of a Cauchy integral: 0.3^64 and 0.5^64 are below rounding.
const CAUCHY_NODES: usize = 64;

/// Nodes of a Cauchy integral, each also relative to the centre.
struct Circle {
    centre: f64,
    nodes: Vec<(C, Root)>,
}

impl Solver {
    /// Amplitudes of the attachments' forces in the eigenvector at `s`, from one row of the
    /// singular 2 by 2 matrix `1 + kappa R`: analytic in `s`.
    fn forces(&self, r: &Receptance, s: C, second: bool) -> [C; 2] {
        let kappa = |a: usize| self.system.kappa[a].0 + self.system.kappa[a].1 * s;
        let cross = self.whole(r, 0, 1).at;
        if second {
            [-kappa(0) * cross, 1.0 + kappa(0) * self.whole(r, 0, 0).at]
        } else {
            [1.0 + kappa(1) * self.whole(r, 1, 1).at, -kappa(1) * cross]
        }
    }

    fn prefers_second(&self, root: Root) -> bool {
        if self.system.shapes.len() == 1 {
            return false;
        }
        let (s, r) = (self.value(root), self.receptance(root));
        let size = |f: [C; 2]| f[0].norm_sqr() + f[1].norm_sqr();
        // The larger row gives the vector better.
        let square = |x: f64| x * x;
        let scale = |i: usize| (self.system.kappa[i].0).max(self.system.kappa[i].1).max(1.0);
        size(self.forces(&r, s, true)) / square(scale(0))
            > size(self.forces(&r, s, false)) / square(scale(1))
    }

    /// `sum_a phi_{a,i} F_a` of the attachments' forces at each mode.
    fn pushes(&self, root: Root, second: bool) -> Vec<C> {
        let shapes = &self.system.shapes;
        if shapes.len() == 1 {
            return shapes[0].iter().map(|&x| C::new(x, 0.0)).collect();
        }
        let (s, r) = (self.value(root), self.receptance(root));
        let forces = self.forces(&r, s, second);
        let (mine, other) = if second { (1, 0) } else { (0, 1) };
        let (x, y) = (&shapes[mine], &shapes[other]);
        let own = [r.r11, r.r22][other].at;
        let kappa = self.system.kappa[other].0 + self.system.kappa[other].1 * s;
        // Below the bars' resonances the translations cancel in the sum but for this.
        let slow = self.moved(other, other) * norm(r.free.at) > norm(own);
        let push = |i: usize| {
            if !slow {
                return shapes[0][i] * forces[0] + shapes[1][i] * forces[1];
            }
            let turn = |&a: &usize| (x[i] * y[a] - y[i] * x[a]) * y[a];
            let moved: f64 = self.translations.modes.iter().map(turn).sum();
            x[i] + kappa * (x[i] * own - y[i] * r.r12.at + moved * r.free.at)
        };
        (0..self.system.omega2.len()).map(push).collect()
    }

    /// The eigenvector in the bars' modes, not normalised.
    fn vector(&self, root: Root, second: bool) -> Vec<C> {
        let mut v = vec![C::default(); self.system.hub];
        for (i, push) in self.pushes(root, second).into_iter().enumerate() {
            let d = self.off_pole(root, 2 * i) * self.off_pole(root, 2 * i + 1);
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
            blocks.push(self.distinct(roots, reals[i].1, reals[reals.len() - 1 - i].1));
        }
        Ok(blocks)
    }

    /// The block of two real roots, each with a vector of its own.
    fn distinct(&self, roots: &[Root], i: usize, j: usize) -> Block {
        let shape = |root: Root| {
            let v = self.vector(root, self.prefers_second(root));
            unit(v.iter().map(|z| z.re).collect())
        };
        let values = [self.value(roots[i]).re, self.value(roots[j]).re];
        real_block(values, shape(roots[i]), shape(roots[j]))
    }

    /// Takes out of `reals` the pairs that nearly coincide.
    fn close_pairs(&self, roots: &[Root], reals: &mut Vec<(C, usize)>, blocks: &mut Vec<Block>) {
        let mut i = 0;
        while i + 1 < reals.len() {
            let (a, b) = (reals[i], reals[i + 1]);
            let close = norm(a.0 - b.0) <= 2.0 * CONFLUENT * norm(a.0);
            let conjugate = norm(a.0 - b.0.conj()) < 1e-3 * norm(a.0 - b.0);
            let mut candidates = Vec::new();
            if let Some(circle) = close.then(|| self.circle(roots, a.1, b.1)).flatten() {
                candidates.push(self.confluent(&circle, false));
                if self.system.shapes.len() == 2 {
                    candidates.push(self.confluent(&circle, true));
                }
            }
            if conjugate {
                candidates.push(self.oscillation(roots[if a.0.im > 0.0 { a.1 } else { b.1 }]));
            } else if !candidates.is_empty() {
                candidates.push(self.distinct(roots, a.1, b.1));
            }
            let best = candidates
                .into_iter()
                .map(|block| (self.defect(&block), block))
                .min_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((_, block)) = best {
                blocks.push(block);
                reals.drain(i..i + 2);
            } else {
                i += 1;
            }
        }
    }

    /// How far a block is from an invariant pair: the residual `R = K V + C V B + V B^2`,
    /// as the dual basis would see it, over `B`. Two vectors of one row may be nearly
    /// parallel (two modes that do not feel each other need both rows), and a mean and a
    /// difference may be lost to rounding: whichever road it was, this tells.
    fn defect(&self, block: &Block) -> f64 {
        let b = &block.b;
        let merged = |v: &[f64]| -> Vec<f64> {
            let amplitude = |m: &Vec<(usize, f64)>| m.iter().map(|&(h, w)| w * v[h]).sum();
            self.system.members.iter().map(amplitude).collect()
        };
        let times = |v: &[Vec<f64>; 2]| -> [Vec<f64>; 2] {
            let mix = |p: f64, q: f64| v[0].iter().zip(&v[1]).map(|(x, y)| p * x + q * y).collect();
            [mix(b[0], b[2]), mix(b[1], b[3])]
        };
        let v = [merged(&block.first), merged(&block.second)];
        let rate = times(&v);
        let mut residual = times(&rate);
        let mut gram = [[0.0; 2]; 2];
        for c in 0..2 {
            for (i, w2) in self.system.omega2.iter().enumerate() {
                residual[c][i] += w2 * (v[c][i] + self.system.beta * rate[c][i]);
            }
            for (shape, (k, damping)) in self.system.shapes.iter().zip(&self.system.kappa) {
                let force = k * dot(shape, &v[c]) + damping * dot(shape, &rate[c]);
                residual[c].iter_mut().zip(shape).for_each(|(r, x)| *r += force * x);
            }
            for d in 0..2 {
                gram[c][d] = self.form([&v[c], &rate[c]], [&v[d], &rate[d]]);
            }
        }
        let scale = block.rate[0].max(block.rate[1]);
        let [[g11, g12], [g21, g22]] = gram;
        let inverse = [[g22, g12], [g21, g11]].map(|row| row.map(f64::abs));
        let size = [&v[0], &v[1]].map(|x| dot(x, x).sqrt());
        // What rounding leaves of the residual's terms is there even where they cancel.
        let noise =
            |c: usize| f64::EPSILON * scale * (scale * size[c] + dot(&rate[c], &rate[c]).sqrt());
        let seen = [0, 1].map(|c| dot(&residual[c], &residual[c]).sqrt() + noise(c));
        let spread =
            size[0] * (inverse[0][0] + inverse[1][0]) + size[1] * (inverse[0][1] + inverse[1][1]);
        let defect = spread * (seen[0] + seen[1]) / ((g11 * g22 - g12 * g21).abs() * scale);
        if defect.is_nan() { f64::INFINITY } else { defect }
    }

    /// The bilinear form `x . C y + x' . y + x . y'` of two shapes and their rates.
    fn form(&self, x: [&Vec<f64>; 2], y: [&Vec<f64>; 2]) -> f64 {
        let mut sum = dot(x[1], y[0]) + dot(x[0], y[1]);
        for (i, w2) in self.system.omega2.iter().enumerate() {
            sum += self.system.beta * w2 * x[0][i] * y[0][i];
        }
        for (shape, (_, c)) in self.system.shapes.iter().zip(&self.system.kappa) {
            sum += c * dot(shape, x[0]) * dot(shape, y[0]);
        }
        sum
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
        Some(Circle { centre, nodes: nodes.collect() })
    }

    /// The block of two nearly coincident roots, by Cauchy integrals around them.
    fn confluent(&self, circle: &Circle, second: bool) -> Block {
        let Circle { centre, nodes } = circle;
        // Argument principle: sums of the first and second powers of the two roots.
        let count = CAUCHY_NODES as f64;
        let (mut once, mut twice) = (0.0, 0.0);
        for &(z, root) in nodes {
            let (f, slope) = self.secular(root);
            let slope = slope / f;
            once += (z * z * slope).re / count;
            twice += (z * z * z * slope).re / count;
        }
        let shift = 0.5 * once;
        let (sigma, delta) = (centre + shift, shift * shift - 0.5 * twice);
        let mut mean = vec![0.0; self.system.hub];
        let mut difference = mean.clone();
        for &(z, root) in nodes {
            let y = z - shift;
            let weight = z / (y * y + delta) / count;
            for (h, v) in self.vector(root, second).iter().enumerate() {
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
