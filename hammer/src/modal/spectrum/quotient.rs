//! Functions of `s` modulo `q(s) = (s - sigma)^2 + delta`, in double-double arithmetic: the common
//! factor of two roots that may coincide.
//!
//! A function of `s` has the remainder `a + b e`, `e = s - sigma`, `e^2 = -delta`. This arithmetic
//! has no singularity where the roots meet: `a` and `b` are the function's mean over the two and
//! its divided difference. For the secular function both are zero; for the eigenvector they are the
//! two columns of an invariant pair.

use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::instant::Double;
use crate::numerics::minors::{self, Matrix, Ring};

/// A remainder `one + e * (s - sigma)`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Remainder {
    one: Double,
    e: Double,
}

impl Remainder {
    fn number(value: f64) -> Self {
        Self { one: Double::new(value), e: Double::default() }
    }

    fn plus(self, other: Self) -> Self {
        Self { one: self.one + other.one, e: self.e + other.e }
    }

    fn minus(self, other: Self) -> Self {
        Self { one: self.one - other.one, e: self.e - other.e }
    }

    fn scaled(self, factor: f64) -> Self {
        let factor = Double::new(factor);
        Self { one: factor * self.one, e: factor * self.e }
    }
}

/// `(s - sigma)^2 + delta`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor {
    sigma: Double,
    delta: Double,
}

impl Ring for Factor {
    type Number = Remainder;

    fn product(&self, a: Remainder, b: Remainder) -> Remainder {
        Remainder { one: a.one * b.one - self.delta * a.e * b.e, e: a.one * b.e + a.e * b.one }
    }

    fn difference(&self, a: Remainder, b: Remainder) -> Remainder {
        a.minus(b)
    }
}

/// Newton steps with one cofactor: each gains as many digits as that is accurate to, eight or more,
/// and the factor starts with as many; four steps reach double-double precision.
const STEPS: usize = 4;
/// Part of a factor that twice the digits do not resolve.
const LAST: f64 = f64::EPSILON * f64::EPSILON / 16.0;
/// Largest correction of a factor, relative to its roots: it was accurate to more than half the
/// digits.
const MOVED: f64 = 1e-6;

impl Factor {
    pub(crate) fn new(sigma: f64, delta: f64) -> Self {
        Self { sigma: Double::new(sigma), delta: Double::new(delta) }
    }

    /// `sigma` and `delta`, rounded.
    pub(crate) fn values(&self) -> [f64; 2] {
        [self.sigma.value(), self.delta.value()]
    }

    /// The factor of two separate roots; none if the iteration does not converge.
    pub(crate) fn of(secular: &Secular, pair: [Root; 2]) -> Option<Self> {
        let [a, b] = pair.map(|root| secular.value(root));
        let half = 0.5 * secular.apart(pair[0], pair[1]);
        // f = f / q times q: its slope at a root is f / q times that of q there.
        let [p, m] = pair.map(|root| secular.function(root).1);
        let (p, m) = (p / (2.0 * half), -m / (2.0 * half));
        let cofactor = [0.5 * (p + m).re, (0.5 * (p - m) / half).re];
        Self::new(0.5 * (a + b).re, -(half * half).re).refined(secular, cofactor)
    }

    /// The nearest factor of the secular function, by Newton's method: the remainder of `f` over
    /// the factor is `cofactor` times the factor's error. `cofactor` is `f / q` as a remainder, to
    /// a few digits. None if the iteration does not converge.
    pub(crate) fn refined(mut self, secular: &Secular, cofactor: [f64; 2]) -> Option<Self> {
        let cofactor = Remainder { one: Double::new(cofactor[0]), e: Double::new(cofactor[1]) };
        let start = self.values();
        let size = start[0].abs().max(start[1].abs().sqrt());
        let mut left = f64::NAN;
        for step in 0..=STEPS {
            let lacks = self.product(self.secular(secular), self.inverse(cofactor));
            let lack = lacks.e.value().abs() * size + lacks.one.value().abs();
            let before = std::mem::replace(&mut left, lack);
            if step == STEPS {
                break;
            }
            self.delta = self.delta + lacks.one;
            self.sigma = self.sigma - lacks.e * Double::new(0.5);
            // It converges linearly: the next correction would be less than rounding.
            let is_last = left * (left / before) <= LAST * size * size;
            if is_last && secular.system.shapes.len() > 2 {
                break;
            }
        }
        let [sigma, delta] = self.values();
        let moved = (sigma - start[0]).abs() * size + (delta - start[1]).abs();
        (moved <= MOVED * size * size && left <= f64::EPSILON * size * size).then_some(self)
    }

    fn inverse(&self, a: Remainder) -> Remainder {
        let norm = a.one * a.one + self.delta * a.e * a.e;
        Remainder { one: a.one / norm, e: -a.e / norm }
    }

    /// `s` itself.
    fn variable(&self) -> Remainder {
        Remainder { one: self.sigma, e: Double::new(1.0) }
    }

    /// `k_a + c_a s`.
    fn spring(&self, secular: &Secular, a: usize) -> Remainder {
        let (k, c) = secular.system.springs[a];
        Remainder::number(k).plus(self.variable().scaled(c))
    }

    /// `1 / d_i = 1 / (s^2 + beta w_i^2 s + w_i^2)` of every mode.
    fn compliances(&self, secular: &Secular) -> Vec<Remainder> {
        let s = self.variable();
        let square = self.product(s, s);
        let beta = Double::new(secular.system.beta);
        let inverse = |&w2: &f64| {
            let w2 = Double::new(w2);
            let damped = Remainder { one: beta * w2 * s.one + w2, e: beta * w2 * s.e };
            self.inverse(square.plus(damped))
        };
        secular.system.omega2.iter().map(inverse).collect()
    }

    /// `R_ab = sum_i phi_{a,i} phi_{b,i} / d_i`.
    fn receptance(secular: &Secular, compliances: &[Remainder], a: usize, b: usize) -> Remainder {
        let shapes = secular.system.shapes[a].iter().zip(&secular.system.shapes[b]);
        let terms = shapes.zip(compliances).map(|((x, y), r)| {
            let weight = Double::new(*x) * Double::new(*y);
            Remainder { one: weight * r.one, e: weight * r.e }
        });
        terms.fold(Remainder::default(), Remainder::plus)
    }

    /// `1 + kappa R` of three attachments or four.
    fn matrix(&self, secular: &Secular, compliances: &[Remainder]) -> Matrix<Remainder> {
        let mut matrix = Matrix::default();
        let order = secular.system.shapes.len();
        let stiff: Vec<Remainder> = (0..order).map(|a| self.spring(secular, a)).collect();
        for (a, b) in (0..order).flat_map(|a| (a..order).map(move |b| (a, b))) {
            let moved = Self::receptance(secular, compliances, a, b);
            matrix[b][a] = self.product(stiff[b], moved);
            matrix[a][b] = self.product(stiff[a], moved);
            if a == b {
                matrix[a][a] = Remainder::number(1.0).plus(matrix[a][a]);
            }
        }
        matrix
    }

    /// The secular function.
    fn secular(&self, secular: &Secular) -> Remainder {
        let compliances = self.compliances(secular);
        if secular.system.shapes.len() > 2 {
            let matrix = self.matrix(secular, &compliances);
            return minors::determinant(self, &matrix, secular.system.shapes.len());
        }
        let receptance = |a, b| Self::receptance(secular, &compliances, a, b);
        let first = self.product(self.spring(secular, 0), receptance(0, 0));
        let one = Remainder::number(1.0);
        if secular.system.shapes.len() == 1 {
            return one.plus(first);
        }
        let stiff = [self.spring(secular, 0), self.spring(secular, 1)];
        let cross = receptance(0, 1);
        let second = self.product(stiff[1], receptance(1, 1));
        let across = self.product(self.product(stiff[0], stiff[1]), self.product(cross, cross));
        one.plus(first).plus(second).plus(self.product(first, second)).minus(across)
    }

    /// Mean and divided difference of the eigenvector in the free modes, from one row of the
    /// singular matrix `1 + kappa R` (of three attachments or four, from the cofactors of a row);
    /// not normalised.
    pub(crate) fn vectors(&self, secular: &Secular, row: usize) -> [Vec<f64>; 2] {
        let system = &secular.system;
        let order = system.shapes.len();
        let compliances = self.compliances(secular);
        let one = Remainder::number(1.0);
        let forces: Vec<Remainder> = if order == 1 {
            vec![one]
        } else if order > 2 {
            let matrix = self.matrix(secular, &compliances);
            minors::cofactors(self, &matrix, order, row)[..order].to_vec()
        } else {
            let receptance = |a, b| Self::receptance(secular, &compliances, a, b);
            let (mine, other) = if row == 1 { (0, 1) } else { (1, 0) };
            let stiff = self.spring(secular, mine);
            let own = one.plus(self.product(stiff, receptance(mine, mine)));
            let cross = Remainder::default().minus(self.product(stiff, receptance(0, 1)));
            if other == 0 { vec![own, cross] } else { vec![cross, own] }
        };
        let mut vectors = [vec![0.0; system.modes], vec![0.0; system.modes]];
        for (i, compliance) in compliances.iter().enumerate() {
            let pushes = forces.iter().zip(&system.shapes).map(|(f, shape)| f.scaled(shape[i]));
            let push = pushes.fold(Remainder::default(), Remainder::plus);
            let amplitude = self.product(push, *compliance);
            for &(mode, weight) in &system.members[i] {
                vectors[0][mode] += weight * amplitude.one.value();
                vectors[1][mode] += weight * amplitude.e.value();
            }
        }
        vectors
    }
}
