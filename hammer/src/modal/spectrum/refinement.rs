//! Refinement of an eigenpair to working accuracy, by Newton's method with residuals in twice the digits.
//!
//! If the forces `F` of the attachments are unknowns too, the amplitudes `x` of an eigenvector satisfy
//!
//! ```text
//! d_i x_i + sum_a phi_{a,i} F_a = 0,     F_a = kappa_a sum_i phi_{a,i} x_i.
//! ```
//!
//! In these equations no term becomes large where another vanishes. A step solves the linearised equations in double
//! precision. Amplitudes far from resonance are eliminated; those near it are unknowns of a small matrix, which is
//! scaled and eliminated with complete pivoting. The accuracy of this solution affects only how fast the iteration
//! converges. The limit is accurate to twice the digits.

use crate::modal::spectrum::pairing::Eigenpair;
use crate::modal::spectrum::secular::Secular;
use crate::numerics::instant::Double;
use crate::numerics::math::norm;
use crate::numerics::wide::Wide;
use num_complex::Complex64 as C;
use std::ops::Add;

/// Limit of the number of steps. Eight are needed if only two digits of the linear equations' solution are correct.
/// Some thirty are needed for one of two close roots, because each step then goes only half the way.
const STEPS: usize = 40;
/// If a step is below this, relative to the vector and the root, the iteration ends.
const LAST: f64 = 1e-18;
/// Share of its size by which a root may move. If it moved further, it might become another root.
pub(crate) const MOVED: f64 = 1e-6;
/// An amplitude is near resonance if its `|d|` is below this share of its terms.
const NEAR: f64 = 1e-2;
/// Largest number of amplitudes that are unknowns of the small matrix.
const MAX_NEAR: usize = 16;

/// An eigenpair that is being refined.
pub(crate) struct Refinement<'a> {
    secular: &'a Secular,
    s: Wide,
    /// Amplitudes of the eigenvector, and forces of the attachments.
    x: Vec<Wide>,
    forces: Vec<Wide>,
    /// How far the root may move.
    room: f64,
}

impl<'a> Refinement<'a> {
    /// A refinement that starts from a root, which may move by `room`, and from the amplitudes of its vector in the
    /// modes of the secular function. If these are not finite, all amplitudes start at 1.
    pub(crate) fn new(secular: &'a Secular, s: C, room: f64, x: &[C]) -> Self {
        let scale = x.iter().map(|x| norm(*x)).fold(0.0, f64::max).recip();
        let scaled: Vec<Wide> = x.iter().map(|x| Wide::new(x * scale)).collect();
        let is_vector = scaled.iter().all(|x| x.value().is_finite());
        let x = if is_vector { scaled } else { vec![Wide::new(C::from(1.0)); x.len()] };
        let mut start = Self { secular, s: Wide::new(s), x, forces: Vec::new(), room };
        start.set_forces();
        start
    }

    /// Computes the attachments' forces from their displacements.
    fn set_forces(&mut self) {
        let displacements = self.displacements();
        let forces = displacements.iter().enumerate().map(|(a, u)| self.stiffness(a) * *u);
        self.forces = forces.collect();
    }

    fn displacements(&self) -> Vec<Wide> {
        let shapes = self.secular.system.shapes.iter();
        let sum = |shape: &Vec<f64>| {
            let terms = shape.iter().zip(&self.x).map(|(phi, x)| *x * *phi);
            terms.fold(Wide::default(), Wide::add)
        };
        shapes.map(sum).collect()
    }

    /// `kappa_a = k_a + c_a s`.
    fn stiffness(&self, a: usize) -> Wide {
        let (k, c) = self.secular.system.springs[a];
        self.s * c + Wide::new(k.into())
    }

    /// `d_i` of a mode with the squared frequency `omega2`; `square` is `s^2`.
    fn impedance(&self, square: Wide, omega2: f64) -> Wide {
        let damping = Double::new(self.secular.system.beta) * Double::new(omega2);
        let damped = Wide { re: self.s.re * damping, im: self.s.im * damping };
        square + damped + Wide::new(omega2.into())
    }

    /// The refined root and amplitudes; `None` if they do not converge, or converge to another root.
    pub(crate) fn solve(self) -> Option<Eigenpair> {
        let (s, x) = self.solve_widely()?;
        Some((s.value(), x.iter().map(|x| x.value()).collect()))
    }

    /// [`Self::solve`] with results in twice the digits.
    pub(crate) fn solve_widely(mut self) -> Option<(Wide, Vec<Wide>)> {
        let start = self.s.value();
        for _ in 0..STEPS {
            if self.step()? <= LAST {
                let is_near = norm(self.s.value() - start) <= self.room;
                return is_near.then_some((self.s, self.x));
            }
        }
        None
    }

    /// The equations, linearised at the present pair.
    fn linearised(&self) -> Linearised<'a> {
        let system = &self.secular.system;
        let (s, square) = (self.s.value(), self.s * self.s);
        let impedances: Vec<Wide> =
            system.omega2.iter().map(|w2| self.impedance(square, *w2)).collect();
        let residual = |i: usize| {
            let forces = system.shapes.iter().zip(&self.forces).map(|(phi, f)| *f * phi[i]);
            forces.fold(impedances[i] * self.x[i], Wide::add).value()
        };
        let displacements = self.displacements();
        let springs = displacements.iter().enumerate().map(|(a, u)| {
            let kappa = self.stiffness(a);
            let residual = self.forces[a] + kappa * *u * -1.0;
            (kappa.value(), system.springs[a].1 * u.value(), residual.value())
        });
        let x = self.x.iter().map(|x| x.value());
        let slopes = x.clone().zip(&system.omega2).map(|(x, w2)| (2.0 * s + system.beta * w2) * x);
        let d: Vec<C> = impedances.iter().map(|d| d.value()).collect();
        let terms = |i: usize| s.norm_sqr() + system.omega2[i] * (1.0 + system.beta * norm(s));
        let mut near: Vec<usize> =
            (0..d.len()).filter(|&i| norm(d[i]) <= NEAR * terms(i)).collect();
        near.sort_by(|&i, &j| d[i].norm_sqr().total_cmp(&d[j].norm_sqr()));
        near.truncate(MAX_NEAR);
        Linearised {
            phi: &system.shapes,
            residuals: (0..d.len()).map(residual).collect(),
            springs: springs.collect(),
            far: (0..d.len()).filter(|i| !near.contains(i)).collect(),
            x: x.collect(),
            slopes: slopes.collect(),
            near,
            d,
        }
    }

    /// Makes a Newton step. Returns its size relative to the pair; `None` if the equations are singular.
    fn step(&mut self) -> Option<f64> {
        let linear = self.linearised();
        let (forces, amplitudes, root) = linear.step()?;
        let size = |x: &[C]| x.iter().map(C::norm_sqr).sum::<f64>().sqrt();
        let root_size = norm(root) / norm(self.s.value());
        // The step of the vector is one of inverse iteration, which improves any vector. The step of the root is
        // correct only if the vector is.
        if norm(root) <= self.room {
            self.s = self.s + Wide::new(root);
        }
        self.forces.iter_mut().zip(&forces).for_each(|(f, step)| *f = *f + Wide::new(*step));
        self.x.iter_mut().zip(&amplitudes).for_each(|(x, step)| *x = *x + Wide::new(*step));
        let largest = root_size.max(size(&amplitudes) / size(&linear.x));
        largest.is_finite().then_some(largest)
    }
}

/// The equations, linearised at a pair: their residuals and their slopes.
struct Linearised<'a> {
    phi: &'a [Vec<f64>],
    /// For each mode `d_i`, the amplitude `x_i`, `x_i` times the slope of `d_i`, and the residual of its equation.
    d: Vec<C>,
    x: Vec<C>,
    slopes: Vec<C>,
    residuals: Vec<C>,
    /// For each attachment `kappa`, its displacement times `c`, and the residual of its equation.
    springs: Vec<(C, C, C)>,
    /// The modes near resonance, and the other modes.
    near: Vec<usize>,
    far: Vec<usize>,
}

impl Linearised<'_> {
    /// `sum x_i y_i / d_i` over the eliminated modes.
    fn sum(&self, x: impl Fn(usize) -> C, y: impl Fn(usize) -> C) -> C {
        self.far.iter().map(|&i| x(i) * y(i) / self.d[i]).sum()
    }

    /// The steps of forces, amplitudes and root. The step of the amplitudes is orthogonal to them, so that the length
    /// of the vector does not change.
    fn step(&self) -> Option<(Vec<C>, Vec<C>, C)> {
        let (order, n) = (self.springs.len(), self.springs.len() + self.near.len() + 1);
        let phi = |a: usize| move |i: usize| C::from(self.phi[a][i]);
        let conj = |i: usize| self.x[i].conj();
        let (slope, residual) = (|i: usize| self.slopes[i], |i: usize| self.residuals[i]);
        // The columns are those of the unknowns (forces, amplitudes near resonance, root), then the right side.
        let mut rows = vec![vec![C::default(); n + 1]; n];
        for (a, &(kappa, velocity, spring_residual)) in self.springs.iter().enumerate() {
            let row = &mut rows[a];
            (0..order).for_each(|b| row[b] = kappa * self.sum(phi(a), phi(b)));
            row[a] += 1.0;
            self.near.iter().enumerate().for_each(|(k, &i)| row[order + k] = -kappa * phi(a)(i));
            row[n - 1] = kappa * self.sum(phi(a), slope) - velocity;
            row[n] = -spring_residual - kappa * self.sum(phi(a), residual);
        }
        for (k, &i) in self.near.iter().enumerate() {
            let row = &mut rows[order + k];
            (0..order).for_each(|a| row[a] = phi(a)(i));
            (row[order + k], row[n - 1], row[n]) = (self.d[i], slope(i), -residual(i));
        }
        let row = &mut rows[n - 1];
        (0..order).for_each(|a| row[a] = -self.sum(conj, phi(a)));
        self.near.iter().enumerate().for_each(|(k, &i)| row[order + k] = conj(i));
        (row[n - 1], row[n]) = (-self.sum(conj, slope), self.sum(conj, residual));
        // Forces are scaled by the modes' amplitudes, so that a scene with larger masses yields the same numbers, to
        // the last binary digit.
        let sizes: Vec<f64> = self
            .phi
            .iter()
            .map(|phi| phi.iter().fold(0.0, |largest: f64, x| largest.max(x.abs())))
            .collect();
        for (a, size) in sizes.iter().enumerate() {
            rows[a].iter_mut().for_each(|z| *z *= size);
            rows.iter_mut().for_each(|row| row[a] /= size);
        }
        let mut forces = solved(rows)?;
        forces.iter_mut().zip(&sizes).for_each(|(force, size)| *force /= size);
        let near_and_root = forces.split_off(order);
        let root = near_and_root[self.near.len()];
        let mut amplitudes = vec![C::default(); self.d.len()];
        let near = self.near.iter().zip(near_and_root);
        near.for_each(|(&i, step)| amplitudes[i] = step);
        for &i in &self.far {
            let force: C = forces.iter().enumerate().map(|(a, f)| phi(a)(i) * f).sum();
            amplitudes[i] = -(residual(i) + slope(i) * root + force) / self.d[i];
        }
        Some((forces, amplitudes, root))
    }
}

/// The solution of linear equations whose rows end with the right side; `None` if the equations are singular. Rows and
/// columns are scaled, then eliminated with complete pivoting.
fn solved(mut rows: Vec<Vec<C>>) -> Option<Vec<C>> {
    let n = rows.len();
    let mut scales = vec![1.0; n];
    for _ in 0..2 {
        for row in &mut rows {
            let largest = row[..n].iter().map(|z| norm(*z)).fold(0.0, f64::max);
            row.iter_mut().for_each(|z| *z /= largest);
        }
        for (column, scale) in scales.iter_mut().enumerate() {
            let largest = rows.iter().map(|row| norm(row[column])).fold(0.0, f64::max);
            *scale /= largest;
            rows.iter_mut().for_each(|row| row[column] /= largest);
        }
    }
    let mut unknowns: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let entries = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
        let size = |&(i, j): &(usize, usize)| rows[i][j].norm_sqr();
        let (i, j) = entries.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        rows.swap(k, i);
        rows.iter_mut().for_each(|row| row.swap(k, j));
        unknowns.swap(k, j);
        let (above, below) = rows.split_at_mut(k + 1);
        let pivot = &above[k];
        for row in below {
            let share = row[k] / pivot[k];
            row[k..].iter_mut().zip(&pivot[k..]).for_each(|(z, p)| *z -= share * p);
        }
    }
    let mut solution = vec![C::default(); n];
    for k in (0..n).rev() {
        let known: C = (k + 1..n).map(|j| rows[k][j] * solution[unknowns[j]]).sum();
        solution[unknowns[k]] = (rows[k][n] - known) / rows[k][k];
    }
    solution.iter_mut().zip(&scales).for_each(|(x, scale)| *x *= scale);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::spectrum::{deflation::Deflated, roots::Roots};
    use crate::modal::structure::*;

    /// Three springs act on four modes. The refinement starts from roots with a relative error of 1e-7 and from a wrong
    /// vector. The refined pairs must satisfy the equation of motion to the rounding of its terms.
    #[test]
    fn a_pair_is_found_from_a_wrong_vector() {
        let shapes = [[1.0, 1.4, 0.3, 0.9], [1.0, -1.4, 0.8, -0.2], [1.0, 0.2, -1.1, 0.7]];
        let spring = |shape| Attachment { shape, stiffness: 3e7, viscosity: 40.0 };
        let attachments = shapes.each_ref().map(|shape| spring(shape)).to_vec();
        let omega2 = &[0.0, 1e6, 3e7, 4e8];
        let structure = Structure { attachments, ..Structure::free(omega2, 1e-7) };
        let secular = Secular::new(Deflated::new(&structure).0);
        let mut roots = Roots::new(&secular).solve().0;
        roots.retain(|root| secular.value(*root).im > 0.0);
        assert_eq!(roots.len(), 4);
        for root in roots {
            let start = secular.value(root) * (1.0 + 1e-7);
            let wrong = [1.0, -0.5, 0.25, 2.0].map(C::from);
            let (s, x) = Refinement::new(&secular, start, MOVED * norm(start), &wrong)
                .solve()
                .expect("a pair");
            for i in 0..4 {
                let (mut residual, mut size) = (C::default(), 0.0);
                let mut add = |term: C| {
                    residual += term;
                    size += norm(term);
                };
                add((s * s + omega2[i] * (1.0 + 1e-7 * s)) * x[i]);
                for shape in &shapes {
                    let kappa = shape[i] * (3e7 + 40.0 * s);
                    (0..4).for_each(|k| add(kappa * shape[k] * x[k]));
                }
                // In all, amplitudes, root and the sum itself are rounded some twenty times.
                let is_rounding = norm(residual) <= 20.0 * f64::EPSILON * size;
                assert!(is_rounding, "{s} {i}: {residual} of {size}");
            }
        }
    }

    /// The matrix is Hilbert's of order five, with rows and columns scaled over forty decades. The right side is the
    /// sum of the columns, so the solution is 1.
    #[test]
    fn equations_are_solved_whatever_their_scale() {
        let row = |i: i32| {
            let entry = |j: i32| C::from(10f64.powi(10 * i - 5 * j) / f64::from(i + j + 1));
            let mut row: Vec<C> = (0..5).map(entry).collect();
            row.push(row.iter().sum());
            row
        };
        let solution = solved((0..5).map(row).collect()).expect("a solution");
        for (j, x) in solution.into_iter().enumerate() {
            // The sum is rounded by a share of its largest column, which affects the unknowns of small columns most.
            let bound = f64::EPSILON * 5e5 * 10f64.powi(5 * j as i32);
            assert!(norm(x - 1.0) <= bound, "{j}: {x}");
        }
        assert!(solved(vec![vec![C::from(0.0); 2]]).is_none());
    }
}
