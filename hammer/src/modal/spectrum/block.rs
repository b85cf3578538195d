//! Two real coordinates of a decomposed system: `y' = b y`, and their shapes.

use crate::numerics::math;
use crate::numerics::matrix2::Matrix2;
use num_complex::Complex64 as C;

/// Two roots that differ by less than this times their sum form one block: separately, their
/// vectors would be nearly parallel.
pub(crate) const CONFLUENT: f64 = 0.15;

/// True for a root that is real, or one of two that nearly coincide.
pub(crate) fn is_real(root: C) -> bool {
    root.im.abs() <= CONFLUENT * root.re.abs()
}

/// Two real coordinates, `y' = b y`, and their shapes in the free modes, scaled so that the norm of
/// `exp(b t)` never exceeds 1.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The generator, 1/s.
    pub(crate) b: Matrix2,
    /// The rate `|b|` of each coordinate, 1/s.
    pub(crate) rate: [f64; 2],
    /// Displacement shapes of the two coordinates.
    pub(crate) shapes: [Vec<f64>; 2],
    /// True if the first coordinate is a uniform translation, whose motion is a polynomial. The block's polynomial is
    /// then `s^2`, or `s (s + rate)` if a dashpot to the ground brakes the translation.
    pub(crate) rigid: bool,
}

impl Block {
    /// The block of `(s - sigma)^2 + delta`; `shapes` are the mean of the two eigenvectors, and
    /// `scale` times their divided difference.
    pub(crate) fn quadratic(sigma: f64, delta: f64, scale: f64, shapes: [Vec<f64>; 2]) -> Self {
        // A root is rounded. The entries of an oscillating block must stay exactly opposite: otherwise the sum of its
        // eigenvalues (twice the damping) would be lost beside the frequency.
        let turns = (delta - scale * scale).abs() <= 4.0 * f64::EPSILON * delta;
        let back = if turns { scale } else { delta / scale };
        let rate =
            if turns { math::hypot(sigma, scale) } else { sigma.abs() + scale.max(back.abs()) };
        Self { b: [sigma, scale, -back, sigma], rate: [rate; 2], shapes, rigid: false }
    }

    /// The block of two distinct real roots.
    pub(crate) fn real(roots: [f64; 2], shapes: [Vec<f64>; 2]) -> Self {
        let b = [roots[0], 0.0, 0.0, roots[1]];
        Self { b, rate: [-roots[0], -roots[1]], shapes, rigid: false }
    }

    /// The block of a translation that a dashpot to the ground brakes, and of another decay.
    pub(crate) fn braked(root: f64, shapes: [Vec<f64>; 2]) -> Self {
        Self { b: [0.0, 0.0, 0.0, root], rate: [0.0, -root], shapes, rigid: true }
    }

    /// Changes the sign of a translation, which moves all bodies alike, so that it is positive downward.
    pub(crate) fn turn_downward(&mut self) {
        let shape = &mut self.shapes[0];
        if shape.iter().sum::<f64>() < 0.0 {
            shape.iter_mut().for_each(|x| *x = -*x);
        }
    }

    /// The block of a mode that no attachment affects.
    pub(crate) fn free(omega2: f64, beta: f64, shape: Vec<f64>) -> Self {
        if omega2 == 0.0 {
            let zero = vec![0.0; shape.len()];
            let (b, shapes) = ([0.0, 1.0, 0.0, 0.0], [shape, zero]);
            return Self { b, rate: [0.0; 2], shapes, rigid: true };
        }
        Self::single(omega2, beta * omega2, shape)
    }

    /// The block of one mode, `q'' + damping q' + omega2 q = 0` with a positive `omega2`.
    pub(crate) fn single(omega2: f64, damping: f64, shape: Vec<f64>) -> Self {
        let zero = vec![0.0; shape.len()];
        let sigma = -0.5 * damping;
        let delta = omega2 - sigma * sigma;
        let size = delta.abs().sqrt();
        if size <= CONFLUENT * sigma.abs() {
            // The eigenvector does not depend on s, so its divided difference is zero in
            // displacement, and the second coordinate is a pure velocity.
            return Self::quadratic(sigma, delta, 0.5 * sigma.abs(), [shape, zero]);
        }
        if delta > 0.0 {
            return Self::quadratic(sigma, delta, size, [shape, zero]);
        }
        let fast = sigma - size;
        Self::real([omega2 / fast, fast], [shape.clone(), shape])
    }

    /// True if the two coordinates are uncoupled.
    pub(crate) fn is_diagonal(&self) -> bool {
        self.b[1] == 0.0 && self.b[2] == 0.0
    }
}
