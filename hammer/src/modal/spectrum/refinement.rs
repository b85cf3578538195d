//! An eigenpair to working accuracy, by Newton's method with residuals in twice the digits.
//!
//! With the attachments' forces `F` as unknowns of their own, an eigenvector's amplitudes `x` satisfy
//!
//! ```text
//! d_i x_i + sum_a phi_{a,i} F_a = 0,     F_a = kappa_a sum_i phi_{a,i} x_i.
//! ```
//!
//! Neither equation has a term that grows where another vanishes. A step solves the linearised
//! equations in double precision: amplitudes far from resonance are eliminated, those near it are
//! unknowns of a small matrix, which is scaled and eliminated with complete pivoting. How well that is
//! solved decides only how fast the iteration converges; what it converges to is known to twice the digits.

use crate::modal::spectrum::pairing::Eigenpair;
use crate::modal::spectrum::secular::Secular;
use crate::numerics::instant::Double;
use crate::numerics::math::norm;
use crate::numerics::wide::Wide;
use num_complex::Complex64 as C;
use std::ops::Add;

/// Most steps. If the linear equations are solved to two digits of sixteen, eight steps are needed; for one of two
/// close roots some thirty, since each step goes half the way.
const STEPS: usize = 40;
/// A step below this, relative to the vector and the root, is the last.
const LAST: f64 = 1e-18;
/// Part of its size by which a root may move: beyond, it might become another root.
pub(crate) const MOVED: f64 = 1e-6;
/// An amplitude is near resonance if its `|d|` is below this part of its terms.
const NEAR: f64 = 1e-2;
/// Most amplitudes that are unknowns of the small matrix.
const MOST: usize = 16;

/// An eigenpair under refinement.
pub(crate) struct Refinement<'a> {
    secular: &'a Secular,
    s: Wide,
    /// Amplitudes, and forces of the attachments.
    x: Vec<Wide>,
    forces: Vec<Wide>,
    /// How far the root may move.
    room: f64,
}

impl<'a> Refinement<'a> {
    /// Starts from a root, which may move by `room`, and from the amplitudes of its vector in the modes of the secular
    /// function. If these are not finite, all start at 1.
    pub(crate) fn new(secular: &'a Secular, s: C, room: f64, x: &[C]) -> Self {
        let scale = x.iter().map(|x| norm(*x)).fold(0.0, f64::max).recip();
        let scaled: Vec<Wide> = x.iter().map(|x| Wide::new(x * scale)).collect();
        let is_vector = scaled.iter().all(|x| x.value().is_finite());
        let x = if is_vector { scaled } else { vec![Wide::new(C::from(1.0)); x.len()] };
        let mut start = Self { secular, s: Wide::new(s), x, forces: Vec::new(), room };
        start.push();
        start
    }

    /// Computes the attachments' forces from their displacements.
    fn push(&mut self) {
        let moved = self.moved();
        self.forces = moved.iter().enumerate().map(|(a, u)| self.stiffness(a) * *u).collect();
    }

    /// Displacements of the attachments.
    fn moved(&self) -> Vec<Wide> {
        let shapes = self.secular.system.shapes.iter();
        let sum = |shape: &Vec<f64>| {
            let terms = shape.iter().zip(&self.x).map(|(phi, x)| *x * *phi);
            terms.fold(Wide::default(), Wide::add)
        };
        shapes.map(sum).collect()
    }

    /// `k + c s`.
    fn stiffness(&self, a: usize) -> Wide {
        let (k, c) = self.secular.system.springs[a];
        self.s * c + Wide::new(k.into())
    }

    /// `d_i`.
    fn impedance(&self, square: Wide, omega2: f64) -> Wide {
        let damping = Double::new(self.secular.system.beta) * Double::new(omega2);
        let damped = Wide { re: self.s.re * damping, im: self.s.im * damping };
        square + damped + Wide::new(omega2.into())
    }

    /// The root and the amplitudes; none if they do not converge, or if they converge to another root.
    pub(crate) fn solve(self) -> Option<Eigenpair> {
        let (s, x) = self.solve_widely()?;
        Some((s.value(), x.iter().map(|x| x.value()).collect()))
    }

    /// The same in twice the digits.
    pub(crate) fn solve_widely(mut self) -> Option<(Wide, Vec<Wide>)> {
        let start = self.s.value();
        for _ in 0..STEPS {
            if self.step()? <= LAST {
                let near = norm(self.s.value() - start) <= self.room;
                return near.then_some((self.s, self.x));
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
        let rest = |i: usize| {
            let pushes = system.shapes.iter().zip(&self.forces).map(|(phi, f)| *f * phi[i]);
            pushes.fold(impedances[i] * self.x[i], Wide::add).value()
        };
        let moved = self.moved();
        let springs = moved.iter().enumerate().map(|(a, u)| {
            let kappa = self.stiffness(a);
            let lack = self.forces[a] + kappa * *u * -1.0;
            (kappa.value(), system.springs[a].1 * u.value(), lack.value())
        });
        let x = self.x.iter().map(|x| x.value());
        let turned = x.clone().zip(&system.omega2).map(|(x, w2)| (2.0 * s + system.beta * w2) * x);
        let d: Vec<C> = impedances.iter().map(|d| d.value()).collect();
        let terms = |i: usize| s.norm_sqr() + system.omega2[i] * (1.0 + system.beta * norm(s));
        let mut near: Vec<usize> =
            (0..d.len()).filter(|&i| norm(d[i]) <= NEAR * terms(i)).collect();
        near.sort_by(|&i, &j| d[i].norm_sqr().total_cmp(&d[j].norm_sqr()));
        near.truncate(MOST);
        Linearised {
            phi: &system.shapes,
            rest: (0..d.len()).map(rest).collect(),
            springs: springs.collect(),
            far: (0..d.len()).filter(|i| !near.contains(i)).collect(),
            x: x.collect(),
            turned: turned.collect(),
            near,
            d,
        }
    }

    /// A Newton step, and its size relative to the pair; none if the equations are singular.
    fn step(&mut self) -> Option<f64> {
        let linear = self.linearised();
        let (forces, moves, turn) = linear.step()?;
        let size = |x: &[C]| x.iter().map(C::norm_sqr).sum::<f64>().sqrt();
        let turned = norm(turn) / norm(self.s.value());
        // The step of the vector is one of inverse iteration, which leads on from any vector; that of the root is only
        // right if the vector is.
        if norm(turn) <= self.room {
            self.s = self.s + Wide::new(turn);
        }
        self.forces.iter_mut().zip(&forces).for_each(|(f, by)| *f = *f + Wide::new(*by));
        self.x.iter_mut().zip(&moves).for_each(|(x, by)| *x = *x + Wide::new(*by));
        let most = turned.max(size(&moves) / size(&linear.x));
        most.is_finite().then_some(most)
    }
}

/// The equations linearised at a pair: their residuals there, and their slopes.
struct Linearised<'a> {
    phi: &'a [Vec<f64>],
    /// `d_i`, the amplitudes, `x_i` times the slope of `d_i`, and the residual of each mode's equation.
    d: Vec<C>,
    x: Vec<C>,
    turned: Vec<C>,
    rest: Vec<C>,
    /// For each attachment `kappa`, its displacement times `c`, and the residual of its equation.
    springs: Vec<(C, C, C)>,
    /// Modes near resonance, and the others.
    near: Vec<usize>,
    far: Vec<usize>,
}

impl Linearised<'_> {
    /// `sum x_i y_i / d_i` over the eliminated modes.
    fn sum(&self, x: impl Fn(usize) -> C, y: impl Fn(usize) -> C) -> C {
        self.far.iter().map(|&i| x(i) * y(i) / self.d[i]).sum()
    }

    /// The step of forces, amplitudes and root. The step of the amplitudes is orthogonal to them, so that the length of
    /// the vector stays.
    fn step(&self) -> Option<(Vec<C>, Vec<C>, C)> {
        let (order, n) = (self.springs.len(), self.springs.len() + self.near.len() + 1);
        let phi = |a: usize| move |i: usize| C::from(self.phi[a][i]);
        let (conj, turned, rest) =
            (|i: usize| self.x[i].conj(), |i: usize| self.turned[i], |i: usize| self.rest[i]);
        // Unknowns: forces, amplitudes near resonance, root; then the right side.
        let mut rows = vec![vec![C::default(); n + 1]; n];
        for (a, &(kappa, speed, lack)) in self.springs.iter().enumerate() {
            let row = &mut rows[a];
            (0..order).for_each(|b| row[b] = kappa * self.sum(phi(a), phi(b)));
            row[a] += 1.0;
            self.near.iter().enumerate().for_each(|(k, &i)| row[order + k] = -kappa * phi(a)(i));
            row[n - 1] = kappa * self.sum(phi(a), turned) - speed;
            row[n] = -lack - kappa * self.sum(phi(a), rest);
        }
        for (k, &i) in self.near.iter().enumerate() {
            let row = &mut rows[order + k];
            (0..order).for_each(|a| row[a] = phi(a)(i));
            (row[order + k], row[n - 1], row[n]) = (self.d[i], self.turned[i], -self.rest[i]);
        }
        let row = &mut rows[n - 1];
        (0..order).for_each(|a| row[a] = -self.sum(conj, phi(a)));
        self.near.iter().enumerate().for_each(|(k, &i)| row[order + k] = conj(i));
        (row[n - 1], row[n]) = (-self.sum(conj, turned), self.sum(conj, rest));
        // Forces are scaled by the modes' amplitudes, so that a heavier scene has the same numbers to the last bit.
        let sizes: Vec<f64> = self
            .phi
            .iter()
            .map(|phi| phi.iter().fold(0.0, |most: f64, x| most.max(x.abs())))
            .collect();
        for (a, size) in sizes.iter().enumerate() {
            rows[a].iter_mut().for_each(|z| *z *= size);
            rows.iter_mut().for_each(|row| row[a] /= size);
        }
        let mut forces = solved(rows)?;
        forces.iter_mut().zip(&sizes).for_each(|(force, size)| *force /= size);
        let near = forces.split_off(order);
        let turn = near[self.near.len()];
        let mut moves = vec![C::default(); self.d.len()];
        self.near.iter().zip(near).for_each(|(&i, by)| moves[i] = by);
        for &i in &self.far {
            let push: C = forces.iter().enumerate().map(|(a, f)| phi(a)(i) * f).sum();
            moves[i] = -(self.rest[i] + self.turned[i] * turn + push) / self.d[i];
        }
        Some((forces, moves, turn))
    }
}

/// The solution of linear equations, whose rows end with the right side: rows and columns are scaled, and eliminated
/// with complete pivoting. None if the equations are singular.
fn solved(mut rows: Vec<Vec<C>>) -> Option<Vec<C>> {
    let n = rows.len();
    let mut scales = vec![1.0; n];
    for _ in 0..2 {
        for row in &mut rows {
            let most = row[..n].iter().map(|z| norm(*z)).fold(0.0, f64::max);
            row.iter_mut().for_each(|z| *z /= most);
        }
        for (column, scale) in scales.iter_mut().enumerate() {
            let most = rows.iter().map(|row| norm(row[column])).fold(0.0, f64::max);
            *scale /= most;
            rows.iter_mut().for_each(|row| row[column] /= most);
        }
    }
    let mut places: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let entries = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
        let best = |&(i, j): &(usize, usize)| rows[i][j].norm_sqr();
        let (i, j) = entries.max_by(|a, b| best(a).total_cmp(&best(b)))?;
        rows.swap(k, i);
        rows.iter_mut().for_each(|row| row.swap(k, j));
        places.swap(k, j);
        let (above, below) = rows.split_at_mut(k + 1);
        let pivot = &above[k];
        for row in below {
            let share = row[k] / pivot[k];
            row[k..].iter_mut().zip(&pivot[k..]).for_each(|(z, p)| *z -= share * p);
        }
    }
    let mut solution = vec![C::default(); n];
    for k in (0..n).rev() {
        let known: C = (k + 1..n).map(|j| rows[k][j] * solution[places[j]]).sum();
        solution[places[k]] = (rows[k][n] - known) / rows[k][k];
    }
    solution.iter_mut().zip(&scales).for_each(|(x, scale)| *x *= scale);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::spectrum::{deflation::Deflated, roots::Roots};
    use crate::modal::structure::*;

    /// Three springs on four modes. The refinement begins with roots that are off by 1e-7 of themselves and without
    /// vectors, and the equation of motion then holds to a rounding of each of its terms.
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
                let (mut left, mut size) = (C::default(), 0.0);
                let mut add = |term: C| {
                    left += term;
                    size += norm(term);
                };
                add((s * s + omega2[i] * (1.0 + 1e-7 * s)) * x[i]);
                for shape in &shapes {
                    let kappa = shape[i] * (3e7 + 40.0 * s);
                    (0..4).for_each(|k| add(kappa * shape[k] * x[k]));
                }
                // Amplitudes, root and the sum itself are rounded some twenty times.
                assert!(norm(left) <= 20.0 * f64::EPSILON * size, "{s} {i}: {left} of {size}");
            }
        }
    }

    /// Hilbert's matrix of order five, with rows and columns scaled over forty decades: its solution is
    /// known, since the right side is the sum of its columns.
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
            // The smallest columns are rounded in the sum: each is known to a part of the largest.
            let known = f64::EPSILON * 5e5 * 10f64.powi(5 * j as i32);
            assert!(norm(x - 1.0) <= known, "{j}: {x}");
        }
        assert!(solved(vec![vec![C::from(0.0); 2]]).is_none());
    }
}
