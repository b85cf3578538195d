//! Spectral elements: Lagrange polynomials on Legendre-Gauss-Lobatto nodes, integrated by the
//! quadrature of the same nodes, so that the mass is diagonal (Patera 1984; Canuto et al.,
//! *Spectral Methods*, 2006). A second discretisation of bars, of another family than splines:
//! what both converge to is the continuum.

use crate::linear::Real;

/// A reference element on `[-1, 1]`.
#[derive(Clone, Debug)]
pub struct Lobatto<T> {
    /// Ends, and zeros of `P_d'`, ascending.
    pub nodes: Vec<T>,
    /// Weights `2 / (d (d + 1) P_d(x)^2)`.
    pub weights: Vec<T>,
    /// `sum_q w_q l_i'(x_q) l_j'(x_q)`, row after row.
    pub stiffness: Vec<Vec<T>>,
}

/// `P_d` and `P_d'` at `x` inside the interval: Bonnet's recursion.
pub(crate) fn legendre<T: Real>(degree: usize, x: T) -> [T; 2] {
    let (mut before, mut here) = (T::from(1.0), x);
    for k in 1..degree {
        let [n, next] = [k, k + 1].map(|k| T::from(k as f64));
        let ahead = ((n + next) * x * here - n * before) / next;
        (before, here) = (here, ahead);
    }
    [here, T::from(degree as f64) * (before - x * here) / (T::from(1.0) - x * x)]
}

impl<T: Real> Lobatto<T> {
    /// Of a degree, at least 1.
    pub fn new(degree: usize) -> Self {
        let d = degree as f64;
        let (one, all) = (T::from(1.0), T::from(d * (d + 1.0)));
        let inner = |i: usize| {
            // Newton's method on P': (1 - x^2) P'' = 2 x P' - d (d + 1) P.
            let mut x = T::from(-(std::f64::consts::PI * i as f64 / d).cos());
            for _ in 0..12 {
                let [p, slope] = legendre(degree, x);
                let second = (T::from(2.0) * x * slope - all * p) / (one - x * x);
                x = x - slope / second;
            }
            x
        };
        let node = |i: usize| match i {
            0 => -one,
            i if i == degree => one,
            i => inner(i),
        };
        let nodes: Vec<T> = (0..=degree).map(node).collect();
        let value = |x: &T| match x.to_f64().abs() < 1.0 {
            true => legendre(degree, *x)[0],
            false if x.to_f64() < 0.0 && degree % 2 == 1 => -one,
            false => one,
        };
        let values: Vec<T> = nodes.iter().map(value).collect();
        let weights: Vec<T> = values.iter().map(|&p| T::from(2.0) / (all * p * p)).collect();
        // l_j'(x_q) = P(x_q) / (P(x_j) (x_q - x_j)), and at q = j zero but at the ends.
        let slope = |q: usize, j: usize| match q == j {
            false => values[q] / (values[j] * (nodes[q] - nodes[j])),
            true if q == 0 => -(all / T::from(4.0)),
            true if q == degree => all / T::from(4.0),
            true => T::default(),
        };
        let entry = |i: usize, j: usize| {
            let terms = (0..=degree).map(|q| weights[q] * slope(q, i) * slope(q, j));
            terms.fold(T::default(), |sum, term| sum + term)
        };
        let stiffness = (0..=degree).map(|i| (0..=degree).map(|j| entry(i, j)).collect()).collect();
        Self { nodes, weights, stiffness }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dd::Dd;

    /// Quadrature with `d + 1` nodes is exact up to degree `2 d - 1`; stiffness likewise, and
    /// without force under a uniform displacement.
    #[test]
    fn quadrature_and_stiffness_are_exact_to_double_doubles() {
        for degree in 1..=14 {
            let element = Lobatto::<Dd>::new(degree);
            for power in 0..2 * degree {
                let at = |x: &Dd| (0..power).fold(Dd::from(1.0), |y, _| y * *x);
                let pairs = element.nodes.iter().zip(&element.weights);
                let sum = pairs.fold(Dd::default(), |sum, (x, &w)| sum + w * at(x));
                let even = if power % 2 == 0 { 2.0 } else { 0.0 };
                let exact = Dd::from(even) / Dd::from((power + 1) as f64);
                assert!((sum - exact).to_f64().abs() < 1e-28, "{degree} {power}");
            }
            for row in &element.stiffness {
                let dot = |u: &dyn Fn(usize) -> Dd| {
                    (0..=degree).fold(Dd::default(), |sum, j| sum + row[j] * u(j))
                };
                assert!(dot(&|_| Dd::from(1.0)).to_f64().abs() < 1e-26 * (degree * degree) as f64);
            }
            // Half the energy of x is 1.
            let pairs = (0..=degree).flat_map(|i| (0..=degree).map(move |j| (i, j)));
            let x = &element.nodes;
            let energy = pairs
                .fold(Dd::default(), |sum, (i, j)| sum + x[i] * element.stiffness[i][j] * x[j]);
            assert!((energy - Dd::from(2.0)).to_f64().abs() < 1e-26 * (degree * degree) as f64);
        }
    }

    #[test]
    fn three_nodes_are_those_of_simpson() {
        let element = Lobatto::<f64>::new(2);
        assert!(element.nodes[1].abs() < 1e-15);
        for (weight, simpson) in element.weights.iter().zip([1.0 / 3.0, 4.0 / 3.0, 1.0 / 3.0]) {
            assert!((weight - simpson).abs() < 1e-15);
        }
    }
}
