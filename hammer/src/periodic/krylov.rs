//! Linear equations and eigenvalues of a matrix that is known by what it does to a vector.

use crate::numerics::kernel::{inner_product, norm};
use crate::numerics::math;
use crate::periodic::eigen;
use num_complex::Complex64 as C;

/// Most vectors that one equation may add.
const MOST: usize = 80;
/// A right side is solved when this part of it is left: a tenth of what differences leave.
const DONE: f64 = 1e-9;
/// Eigenvalues that suffice.
const ENOUGH: usize = 4;
/// Least part that a new direction must keep of itself.
const NEW: f64 = 1e-13;

fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

/// Solves `(I - J) x = b` for one right side after another (generalised conjugate residuals);
/// the directions of earlier ones serve the later. What else the map gives, `Q u`, comes with it.
#[derive(Debug, Default)]
pub(crate) struct Solver {
    /// `[u | Q u]`
    directions: Vec<Vec<f64>>,
    /// `(I - J)` times them, orthonormal.
    images: Vec<Vec<f64>>,
}

impl Solver {
    /// `jacobian` gives `[J u | Q u]`. Returns `[x | Q x]` and the part of `b` that is left.
    pub(crate) fn solve(
        &mut self,
        b: &[f64],
        mut jacobian: impl FnMut(&[f64]) -> Vec<f64>,
    ) -> (Vec<f64>, f64) {
        let size = norm(b);
        let mut x = vec![0.0; self.directions.first().map_or(b.len(), Vec::len)];
        let mut rest = b.to_vec();
        if size == 0.0 {
            return (x, 0.0);
        }
        for k in 0..self.images.len() {
            self.use_direction(k, &mut x, &mut rest);
        }
        for _ in 0..MOST {
            if norm(&rest) <= DONE * size {
                break;
            }
            let mut u = rest.clone();
            let mut c = u.clone();
            let image = jacobian(&u);
            add(&mut c, -1.0, &image);
            u.extend(&image[b.len()..]);
            x.resize(u.len(), 0.0);
            let before = norm(&c);
            // Twice: once leaves rounding of the larger parts.
            for _ in 0..2 {
                for (d, image) in self.directions.iter().zip(&self.images) {
                    let part = inner_product(image, &c);
                    add(&mut c, -part, image);
                    add(&mut u, -part, d);
                }
            }
            let size_left = norm(&c);
            if size_left.is_nan() || size_left <= NEW * before {
                break;
            }
            c.iter_mut().chain(&mut u).for_each(|x| *x /= size_left);
            self.images.push(c);
            self.directions.push(u);
            self.use_direction(self.images.len() - 1, &mut x, &mut rest);
        }
        (x, norm(&rest) / size)
    }

    fn use_direction(&self, k: usize, x: &mut [f64], rest: &mut [f64]) {
        let part = inner_product(&self.images[k], rest);
        add(x, part, &self.directions[k]);
        add(rest, -part, &self.images[k]);
    }
}

/// Eigenvalues of largest magnitude with the errors of each, by Arnoldi's method from `start`: as
/// many as are found to `accuracy` (of the largest, or absolute below one), at least one if there
/// is any.
pub(crate) fn leading(
    start: &[f64],
    most: usize,
    accuracy: f64,
    mut jacobian: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<(C, f64)> {
    let size = norm(start);
    if size == 0.0 || size.is_nan() {
        return Vec::new();
    }
    let mut basis: Vec<Vec<f64>> = vec![start.iter().map(|x| x / size).collect()];
    let mut h: Vec<Vec<f64>> = Vec::new();
    for k in 0..most {
        let mut w = jacobian(&basis[k]);
        w.truncate(start.len());
        let mut column = vec![0.0; k + 2];
        for _ in 0..2 {
            for (i, v) in basis.iter().enumerate() {
                let part = inner_product(v, &w);
                column[i] += part;
                add(&mut w, -part, v);
            }
        }
        let residual = norm(&w);
        if residual.is_nan() {
            return if h.is_empty() { Vec::new() } else { eigen::ritz(&h) };
        }
        column[k + 1] = residual;
        h.push(column);
        let pairs = eigen::ritz(&h);
        let top = pairs.first().map_or(0.0, |(l, _)| math::norm(*l));
        let sure = |(_, error): &&(C, f64)| *error <= accuracy * top.max(accuracy);
        let settled = pairs.iter().take_while(sure).count();
        let end = residual <= 1e-14 * top.max(1e-300) || k + 1 == most;
        if settled >= ENOUGH.min(k + 1) && k > 2 || end {
            return pairs.into_iter().take(settled.max(1)).collect();
        }
        basis.push(w.iter().map(|x| x / residual).collect());
    }
    Vec::new()
}
