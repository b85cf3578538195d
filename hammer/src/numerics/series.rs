//! Power series up to a fixed order, coefficient by coefficient, and their projection on lower powers.

use std::array::from_fn;

/// Highest power of a series.
pub const ORDER: usize = 14;
/// Number of coefficients of a projection.
pub const LOW: usize = 7;

/// Coefficients of a power series.
pub type Powers = [f64; ORDER + 1];

/// Highest power of the motion of rigid bodies. A body rings on the rock and at the contact while the air's series are
/// still good. Its further powers follow from the lower ones, without any product of series.
pub const HIGH: usize = 20;
/// Coefficients of such a motion.
pub type HighPowers = [f64; HIGH + 1];

/// Nodes on the interval from 0 to 1 for interpolation with this many coefficients: the zeros of the Legendre
/// polynomial.
pub const NODES: [f64; LOW] = [
    0.025446043828620757,
    0.12923440720030277,
    0.2970774243113014,
    0.5,
    0.7029225756886985,
    0.8707655927996972,
    0.9745539561713792,
];

/// The polynomial with these values at the nodes, by Newton's divided differences.
pub fn through(values: &[f64; LOW]) -> [f64; LOW] {
    let mut differences = *values;
    for order in 1..LOW {
        for i in (order..LOW).rev() {
            let rise = differences[i] - differences[i - 1];
            differences[i] = rise / (NODES[i] - NODES[i - order]);
        }
    }
    let mut sum = [0.0; LOW];
    for (node, difference) in NODES.iter().zip(differences).rev() {
        (0..LOW).rev().for_each(|k| {
            let risen = if k > 0 { sum[k - 1] } else { difference };
            sum[k] = risen - node * sum[k];
        });
    }
    sum
}

/// The powers of `t`. Even and odd ones are found beside each other.
#[inline(always)]
pub fn powers<const COUNT: usize>(t: f64) -> [f64; COUNT] {
    let (mut powers, square) = ([1.0; COUNT], t * t);
    powers[1] = t;
    for k in 2..COUNT {
        powers[k] = powers[k - 2] * square;
    }
    powers
}

/// Value at `t`.
pub fn value(powers: &[f64], t: f64) -> f64 {
    powers.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// Value at `t`, and slope. Even and odd powers are summed side by side, which takes half as long.
pub fn value_and_slope(powers: &[f64], t: f64) -> [f64; 2] {
    let (pairs, rest) = powers.as_chunks::<2>();
    let (mut sums, mut slopes) = ([rest.first().copied().unwrap_or(0.0), 0.0], [0.0; 2]);
    let square = t * t;
    for pair in pairs.iter().rev() {
        for i in 0..2 {
            slopes[i] = slopes[i] * square + sums[i];
            sums[i] = sums[i] * square + pair[i];
        }
    }
    [sums[0] + t * sums[1], sums[1] + 2.0 * t * (slopes[0] + t * slopes[1])]
}

/// Projections of the first polynomials of some that stand side by side, on lower powers, over the interval from 0 to 1. From the highest power
/// down, the part that is orthogonal to all lower powers is removed: a multiple of the Legendre polynomial. All
/// projections have the same number of coefficients, at most [`LOW`]. Further powers are removed if that changes no
/// polynomial by more than its `allowed` error.
#[inline(always)]
pub fn projections<const COUNT: usize, const ALL: usize>(
    all: &[[f64; ALL]; ORDER + 1],
    allowed: [f64; COUNT],
) -> [[f64; COUNT]; LOW] {
    let (mut low, mut left) = ([[0.0; COUNT]; LOW], [0.0; COUNT]);
    low.iter_mut().zip(all).for_each(|(low, row)| low.copy_from_slice(&row[..COUNT]));
    for (row, parts) in all[LOW..].iter().zip(&PROJECTED) {
        for k in 0..LOW {
            (0..COUNT).for_each(|i| low[k][i] += parts[k] * row[i]);
        }
    }
    for k in (1..LOW).rev() {
        let parts = low[k].map(|c| c / ORTHOGONAL[k][k]);
        // In the interval the magnitude of the Legendre polynomial is at most one.
        let out: [f64; COUNT] = from_fn(|i| left[i] + parts[i].abs());
        if out.iter().zip(allowed).any(|(out, allowed)| *out > allowed) {
            break;
        }
        left = out;
        for (row, p) in low[..k].iter_mut().zip(&ORTHOGONAL[k]) {
            (0..COUNT).for_each(|i| row[i] -= parts[i] * p);
        }
        low[k] = [0.0; COUNT];
    }
    low
}

/// The projections of the powers from [`LOW`] on.
static PROJECTED: [[f64; LOW]; ORDER + 1 - LOW] = {
    let (mut all, mut power) = ([[0.0; LOW]; ORDER + 1 - LOW], LOW);
    while power <= ORDER {
        let mut left = [0.0; ORDER + 1];
        left[power] = 1.0;
        let mut k = power;
        while k >= LOW {
            let (part, mut i) = (left[k] / ORTHOGONAL[k][k], 0);
            while i < k {
                left[i] -= part * ORTHOGONAL[k][i];
                i += 1;
            }
            k -= 1;
        }
        let mut i = 0;
        while i < LOW {
            all[power - LOW][i] = left[i];
            i += 1;
        }
        power += 1;
    }
    all
};

/// The Legendre polynomials on the interval from 0 to 1, `sum_i (-1)^(j + i) C(j, i) C(j + i, i) t^i`.
static ORTHOGONAL: [Powers; ORDER + 1] = {
    let (mut all, mut j) = ([[0.0; ORDER + 1]; ORDER + 1], 0);
    while j <= ORDER {
        let (mut c, mut i) = (if j % 2 == 0 { 1.0 } else { -1.0 }, 0);
        while i <= j {
            all[j][i] = c;
            c *= -(((j - i) * (j + i + 1)) as f64) / ((i + 1) * (i + 1)) as f64;
            i += 1;
        }
        j += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of the distances from the nodes is orthogonal to every lower power, and a polynomial is reproduced
    /// from its values at the nodes, up to roundings of coefficients up to 924.
    #[test]
    fn a_polynomial_is_known_at_the_nodes() {
        let one: Powers = from_fn(|k| f64::from(u8::from(k == 0)));
        let distances = NODES.iter().fold(one, |powers, node| {
            from_fn(|k| if k > 0 { powers[k - 1] } else { 0.0 } - node * powers[k])
        });
        let left = projections(&distances.map(|c| [c]), [0.0]);
        assert!(left.iter().all(|[c]| c.abs() < 30.0 * f64::EPSILON));
        let powers: [f64; LOW] = from_fn(|k| 1.0 / (k + 1) as f64 - 0.3);
        let found = through(&NODES.map(|node| value(&powers, node)));
        for (found, exact) in found.iter().zip(powers) {
            assert!((found - exact).abs() < 924.0 * 7.0 * f64::EPSILON, "{found} {exact}");
        }
    }

    /// A polynomial of low degree is its own projection. What the projection of a higher power leaves out is
    /// orthogonal to all lower powers. The coefficients are below 1e4, of some thirty terms each.
    #[test]
    fn what_a_projection_leaves_out_is_orthogonal_to_what_it_keeps() {
        for high in 0..=ORDER {
            let only: [[f64; 1]; ORDER + 1] = from_fn(|k| [f64::from(u8::from(k == high))]);
            let lower = projections(&only, [0.0]);
            for moment in 0..LOW {
                let mean = |k: usize| 1.0 / (k + moment + 1) as f64;
                let left = mean(high) - (0..LOW).map(|k| lower[k][0] * mean(k)).sum::<f64>();
                assert!(left.abs() < 30.0 * 1e4 * f64::EPSILON, "{high} {moment}: {left:e}");
            }
        }
    }
}
