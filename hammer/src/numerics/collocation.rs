//! Gauss's collocation on an interval, `0 <= tau <= 1`.
//!
//! A function is known at the nodes, the zeros of Legendre's polynomial `P_N`. Its projection on the
//! polynomials of degree below `N` has Legendre coefficients that are sums over the nodes, and so has
//! its integral up to any place. What the projection leaves out has neither mean nor first moments.

use std::array::from_fn;
use std::sync::OnceLock;

/// Nodes of an interval.
pub const STAGES: usize = 7;

/// Coefficients of the powers of `tau`, of an integral of what is known at the nodes.
pub type Powers = [f64; STAGES + 1];

/// Values at the nodes.
pub type Nodal = [f64; STAGES];

/// Nodes, weights, and sums over nodes.
#[derive(Debug)]
pub struct Rule {
    /// Zeros of `P_N`.
    pub nodes: Nodal,
    /// A value's share in each Legendre coefficient; in the first it is its weight in the mean.
    legendre: [Nodal; STAGES],
    /// A value's share in the integral up to each node.
    pub once: [Nodal; STAGES],
    /// A value's share in the integral of that.
    pub twice: [Nodal; STAGES],
    /// Legendre's polynomials in powers.
    powers: [Nodal; STAGES],
}

impl Rule {
    /// The rule, made at the first use.
    pub fn get() -> &'static Self {
        static RULE: OnceLock<Rule> = OnceLock::new();
        RULE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let nodes: Nodal = from_fn(zero);
        let weights: Nodal = nodes.map(|x| {
            // Of all nodes: 1 / sum (2k + 1) P_k^2.
            let p = polynomials(x);
            1.0 / (0..STAGES).map(|k| odd(k) * p[k] * p[k]).sum::<f64>()
        });
        let legendre = from_fn(|k| from_fn(|i| odd(k) * weights[i] * polynomials(nodes[i])[k]));
        let shares = |of: fn(f64) -> [f64; STAGES]| {
            from_fn(|i| {
                let integrals = of(nodes[i]);
                from_fn(|j| {
                    let terms = legendre.iter().zip(integrals);
                    terms.map(|(share, integral): (&Nodal, f64)| share[j] * integral).sum()
                })
            })
        };
        let mut powers = [[0.0; STAGES]; STAGES];
        powers[0][0] = 1.0;
        (powers[1][0], powers[1][1]) = (-1.0, 2.0);
        for k in 1..STAGES - 1 {
            // (k + 1) P_(k+1) = (2k + 1) (2 tau - 1) P_k - k P_(k-1), exact in whole numbers.
            for j in 0..=k + 1 {
                let risen = if j > 0 { powers[k][j - 1] } else { 0.0 };
                let sum = odd(k) * (2.0 * risen - powers[k][j]) - k as f64 * powers[k - 1][j];
                powers[k + 1][j] = sum / (k + 1) as f64;
            }
        }
        let (once, twice) = (shares(integrals), shares(second_integrals));
        Self { nodes, legendre, once, twice, powers }
    }

    /// The Legendre coefficients of the projection.
    pub fn coefficients(&self, values: &Nodal) -> Nodal {
        from_fn(|k| dot(&self.legendre[k], values))
    }

    /// The last of them.
    pub fn last(&self, values: &Nodal) -> f64 {
        dot(&self.legendre[STAGES - 1], values)
    }

    /// The projection in powers of `tau`.
    pub fn projection(&self, values: &Nodal) -> Nodal {
        let mut sum = [0.0; STAGES];
        for (c, powers) in self.coefficients(values).iter().zip(&self.powers) {
            sum.iter_mut().zip(powers).for_each(|(sum, power)| *sum += c * power);
        }
        sum
    }

    /// `start` and `factor` times the projection's integral, in powers of `tau`.
    pub fn integral(&self, start: f64, factor: f64, values: &Nodal) -> Powers {
        let projection = self.projection(values);
        from_fn(|k| if k == 0 { start } else { factor * projection[k - 1] / k as f64 })
    }
}

/// A sum of products.
pub fn dot(a: &Nodal, b: &Nodal) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Value at `tau`.
pub fn value(powers: &[f64], tau: f64) -> f64 {
    powers.iter().rev().fold(0.0, |sum, c| sum * tau + c)
}

/// Slope at `tau`.
pub fn slope(powers: &[f64], tau: f64) -> f64 {
    let terms = powers.iter().enumerate().skip(1).rev();
    terms.fold(0.0, |sum, (k, c)| sum * tau + k as f64 * c)
}

fn odd(k: usize) -> f64 {
    (2 * k + 1) as f64
}

/// Legendre's polynomials on the interval, up to one beyond those of the projection.
fn polynomials(tau: f64) -> [f64; STAGES + 2] {
    let x = 2.0 * tau - 1.0;
    let mut p = [1.0; STAGES + 2];
    p[1] = x;
    for k in 1..=STAGES {
        p[k + 1] = (odd(k) * x * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64;
    }
    p
}

/// Their integrals from 0.
fn integrals_beyond(tau: f64) -> [f64; STAGES + 1] {
    let p = polynomials(tau);
    from_fn(|k| if k == 0 { tau } else { (p[k + 1] - p[k - 1]) / (2.0 * odd(k)) })
}

fn integrals(tau: f64) -> [f64; STAGES] {
    let integrals = integrals_beyond(tau);
    from_fn(|k| integrals[k])
}

/// The integrals of these.
fn second_integrals(tau: f64) -> [f64; STAGES] {
    let once = integrals_beyond(tau);
    from_fn(|k| match k {
        0 => 0.5 * tau * tau,
        _ => (once[k + 1] - once[k - 1]) / (2.0 * odd(k)),
    })
}

/// Zero `i` of `P_N`, by bisection between the equal steps that separate it, then Newton's method.
fn zero(i: usize) -> f64 {
    const STEPS: usize = 64 * STAGES * STAGES;
    let at = |step: usize| step as f64 / STEPS as f64;
    let p = |tau| polynomials(tau)[STAGES];
    let signs = (0..STEPS).filter(|&step| (p(at(step)) < 0.0) != (p(at(step + 1)) < 0.0));
    let [mut low, mut high] = signs.map(|step| [at(step), at(step + 1)]).nth(i).unwrap_or_default();
    let below = p(low) < 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if (p(middle) < 0.0) == below { low = middle } else { high = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values, integrals and moments of a polynomial of the projection's degree are exact; the bounds
    /// are roundings of its terms. In powers, Legendre's polynomial of degree 6 on [0, 1] has
    /// coefficients up to 3150, and 13 times the mean of values with it: 7 terms of up to 4e4 roundings.
    #[test]
    fn polynomials_are_integrated_exactly() {
        let rule = Rule::get();
        let degree = STAGES - 1;
        let power = |tau: f64, k: usize| (0..k).fold(1.0, |p, _| p * tau);
        let values: Nodal = from_fn(|i| power(rule.nodes[i], degree));
        let projection = rule.projection(&values);
        for (k, c) in projection.iter().enumerate() {
            let expected = if k == degree { 1.0 } else { 0.0 };
            assert!((c - expected).abs() < 7.0 * 4e4 * f64::EPSILON, "{k}: {c}");
        }
        for i in 0..STAGES {
            let tau = rule.nodes[i];
            let once = power(tau, degree + 1) / (degree + 1) as f64;
            let twice = power(tau, degree + 2) / ((degree + 1) * (degree + 2)) as f64;
            assert!((dot(&rule.once[i], &values) - once).abs() < 1e-15);
            assert!((dot(&rule.twice[i], &values) - twice).abs() < 1e-15);
        }
        // Gauss's rule for the whole interval, the mean, is exact up to the degree 2 N - 1.
        let highest: Nodal = from_fn(|i| power(rule.nodes[i], 2 * STAGES - 1));
        assert!((rule.coefficients(&highest)[0] - 0.5 / STAGES as f64).abs() < 1e-15);
    }
}
