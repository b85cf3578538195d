//! The secular function in twice the digits: for roots that the first fifteen leave unsettled, because all of
//! them cancel. Poles follow from the frequencies here, so their own rounding does not matter.

use crate::modal::spectrum::secular::{PAIRS, Root, Secular};
use crate::numerics::instant::Double;
use crate::numerics::minors::{self, Matrix, Ring};
use crate::numerics::wide::Wide;
use num_complex::Complex64 as C;

/// A function of `s` and its derivative.
#[derive(Clone, Copy, Debug, Default)]
struct Jet {
    at: Wide,
    slope: Wide,
}

impl Jet {
    fn plus(self, other: Self) -> Self {
        Self { at: self.at + other.at, slope: self.slope + other.slope }
    }

    fn times(self, factor: Double) -> Self {
        let times = |z: Wide| Wide { re: z.re * factor, im: z.im * factor };
        Self { at: times(self.at), slope: times(self.slope) }
    }
}

/// Arithmetic of such functions.
struct Jets;

impl Ring for Jets {
    type Number = Jet;

    fn product(&self, a: Jet, b: Jet) -> Jet {
        Jet { at: a.at * b.at, slope: a.slope * b.at + a.at * b.slope }
    }

    fn difference(&self, a: Jet, b: Jet) -> Jet {
        a.plus(b.times(Double::new(-1.0)))
    }
}

impl Secular {
    /// `d_i`, where `s` is `at` away from the origin of the poles.
    fn impedance(&self, s: Wide, at: Wide, omega2: f64) -> Jet {
        let damping = Double::new(self.system.beta) * Double::new(omega2);
        let times = |z: Wide| Wide { re: z.re * damping, im: z.im * damping };
        // Measured from -1 / beta, the stiffness is in the damping's term.
        let rest = if self.origin == 0.0 { omega2 } else { 0.0 };
        let at = s * s + times(at) + Wide::new(C::from(rest));
        let slope = s * 2.0 + Wide { re: damping, im: Double::default() };
        Jet { at, slope }
    }

    /// The secular function, its derivative, and `sum 1 / (s - pole)`. The modes that dominate are rows and
    /// columns of their own here too.
    pub(crate) fn exact_function(&self, root: Root) -> (C, C, C) {
        let system = &self.system;
        let at = Wide::new(self.sites[root.pole]) + Wide::new(root.offset);
        let origin = match self.origin {
            0.0 => Double::default(),
            _ => Double::new(-1.0) / Double::new(system.beta),
        };
        let s = at + Wide { re: origin, im: Double::default() };
        let stiff = |a: usize| {
            let (k, c) = system.springs[a];
            Jet { at: s * c + Wide::new(C::from(k)), slope: Wide::new(C::from(c)) }
        };
        let (order, borders) = (system.shapes.len(), self.borders(root));
        let (mut matrix, mut poles): (Matrix<Jet>, _) = (Matrix::default(), Wide::default());
        let pairs: Vec<_> = PAIRS.into_iter().take_while(|[_, b]| *b < order).collect();
        let mut own = Vec::new();
        for (mode, omega2) in system.omega2.iter().enumerate() {
            let d = self.impedance(s, at, *omega2);
            let inverse = d.at.inverse();
            let both = d.slope * inverse;
            poles = poles + both;
            let compliance = Jet { at: inverse, slope: both * inverse * -1.0 };
            if borders.contains(&mode) {
                own.push((mode, compliance));
                continue;
            }
            for &[a, b] in &pairs {
                let weight =
                    Double::new(system.shapes[a][mode]) * Double::new(system.shapes[b][mode]);
                matrix[a][b] = matrix[a][b].plus(compliance.times(weight));
            }
        }
        let one = Jet { at: Wide::new(C::from(1.0)), slope: Wide::default() };
        for &[a, b] in &pairs {
            let moved = matrix[a][b];
            matrix[a][b] = Jets.product(stiff(a), moved);
            matrix[b][a] = Jets.product(stiff(b), moved);
            if a == b {
                matrix[a][a] = one.plus(matrix[a][a]);
            }
        }
        for (k, &(mode, compliance)) in (order..).zip(&own) {
            for (a, shape) in system.shapes.iter().enumerate() {
                let phi = Double::new(shape[mode]);
                matrix[a][k] = Jets.product(stiff(a), compliance).times(phi);
                matrix[k][a] = one.times(-phi);
            }
            matrix[k][k] = one;
        }
        let f = minors::determinant(&Jets, &matrix, order + own.len());
        (f.at.value(), f.slope.value(), poles.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::spectrum::deflation::Deflated;
    use crate::modal::structure::{Attachment, Structure};

    /// Two unit masses on springs of 2^60 between them and 1/2 to the ground: `s^4 f` is `P = s^4 + (2^61 + 1/2) s^2
    /// + 2^59`, in which 61 bits cancel at `s = i/2`: there it is -1/16, of 106 bits 2^-41 are left.
    #[test]
    fn sixty_bits_may_cancel() {
        let spring = |shape, stiffness| Attachment { shape, stiffness, viscosity: 0.0 };
        let attachments =
            vec![spring(&[1.0, -1.0][..], 2f64.powi(60)), spring(&[0.0, 1.0][..], 0.5)];
        let structure = Structure { attachments, ..Structure::free(&[0.0, 0.0], 0.0) };
        let secular = Secular::new(Deflated::new(&structure).0);
        let at = Root { pole: 0, offset: C::new(0.0, 0.5) };
        let off = |f: C| (f + 1.0).norm_sqr().sqrt();
        assert!(off(secular.function(at).0) > 0.5, "one double is not enough");
        let (f, slope, _) = secular.exact_function(at);
        assert!(off(f) < 2f64.powi(-40), "{f}");
        // P' / s^4 - 4 P / s^5: of its two terms the first is 2^65 and more.
        let known = C::new(0.0, 2f64.powi(65));
        assert!((slope - known).norm_sqr().sqrt() < 1e-14 * known.im, "{slope}");
    }
}
