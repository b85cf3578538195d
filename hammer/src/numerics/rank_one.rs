//! Eigenvalues and eigenvectors of a diagonal matrix plus a multiple of one dyad, `D + k z z'` with `D >= 0` and `k >
//! 0`.
//!
//! The eigenvalues are the zeros of `1 + k sum z_i^2 / (d_i - lambda)`: one between any two neighbouring values of `D`,
//! and one above the largest. Each is stored as a difference from its nearest `d`, so that small ones do not lose
//! digits. The eigenvectors `z_i / (d_i - lambda)` are computed with that `z` for which the computed eigenvalues are
//! exact (Gu and Eisenstat, SIAM J. Matrix Anal. Appl. 15, 1994). They are therefore orthogonal to rounding even if two
//! eigenvalues are close.

use crate::numerics::kernel::norm;

/// Relative difference below which values count as equal.
const EQUAL: f64 = 4.0 * f64::EPSILON;
/// Limit of the steps to a zero. A few are usual; bisection alone takes a hundred.
const STEPS: usize = 200;

/// The eigenvalues in ascending order, each with its eigenvector of norm 1.
pub fn pairs(d: &[f64], k: f64, z: &[f64]) -> Vec<(f64, Vec<f64>)> {
    let n = d.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| d[i].total_cmp(&d[j]));
    let reach = k * norm(z);
    // `moved` are the directions that the dyad changes, one for each distinct value of D; `unchanged` are the others.
    let (mut moved, mut unchanged): (Vec<Moved>, Vec<(f64, Direction)>) = (Vec::new(), Vec::new());
    for i in order {
        let mut next = Moved { d: d[i], z: z[i], v: vec![(i, 1.0)] };
        let equal = moved.last().is_some_and(|last| d[i] - last.d <= EQUAL * d[i]);
        if let Some(last) = moved.pop_if(|_| equal) {
            let (combined, other) = next.turned(last);
            next = combined;
            unchanged.push((next.d, other));
        }
        if reach * next.z.abs() > 0.25 * f64::EPSILON * next.d {
            moved.push(next);
        } else {
            unchanged.push((next.d, next.v));
        }
    }
    let zeros: Vec<Zero> = (0..moved.len()).map(|i| Zero::between(&moved, k, i)).collect();
    let z: Vec<f64> = (0..moved.len()).map(|i| exact(&moved, &zeros, i)).collect();
    let add = |direction: &Direction, share: f64, v: &mut [f64]| {
        direction.iter().for_each(|&(i, x)| v[i] += share * x);
    };
    let mut list = Vec::with_capacity(n);
    for (value, direction) in &unchanged {
        let mut v = vec![0.0; n];
        add(direction, 1.0, &mut v);
        list.push((*value, v));
    }
    for zero in zeros {
        let shares: Vec<f64> = (0..moved.len()).map(|i| z[i] / zero.below(&moved, i)).collect();
        let size = norm(&shares);
        let mut v = vec![0.0; n];
        for (share, direction) in shares.iter().zip(&moved) {
            add(&direction.v, share / size, &mut v);
        }
        list.push((moved[zero.nearest].d + zero.beyond, v));
    }
    list.sort_by(|a: &(f64, Vec<f64>), b| a.0.total_cmp(&b.0));
    list
}

/// A vector, given by its nonzero entries.
type Direction = Vec<(usize, f64)>;

/// A direction that the dyad changes, with its value of `D` and the component of `z` along it.
struct Moved {
    d: f64,
    z: f64,
    v: Direction,
}

impl Moved {
    /// Rotates two directions with the same value of `D` into one that the dyad changes and one that it leaves
    /// unchanged.
    fn turned(self, other: Self) -> (Self, Direction) {
        let z = (self.z * self.z + other.z * other.z).sqrt();
        let (c, s) = if z > 0.0 { (self.z / z, other.z / z) } else { (1.0, 0.0) };
        let scaled = |v: &Direction, a: f64| v.iter().map(|&(i, x)| (i, a * x)).collect::<Vec<_>>();
        // The two directions have no entry in common.
        let sum = |a: f64, b: f64| [scaled(&self.v, a), scaled(&other.v, b)].concat();
        (Self { d: self.d, z, v: sum(c, s) }, sum(-s, c))
    }
}

/// An eigenvalue, stored as its difference `beyond` from the nearest value of `D`.
struct Zero {
    nearest: usize,
    beyond: f64,
}

impl Zero {
    /// `d_i - lambda`.
    fn below(&self, all: &[Moved], i: usize) -> f64 {
        (all[i].d - all[self.nearest].d) - self.beyond
    }

    /// The zero between value `i` of `D` and the next value, or above the last value.
    fn between(all: &[Moved], k: f64, i: usize) -> Self {
        // The sum `1 + k sum z^2 / (d - lambda)` without the term of the nearest value, and its slope, at a distance
        // `x` from that value.
        let rest = |nearest: usize, x: f64| {
            let (mut sum, mut slope) = (1.0, 0.0);
            for (_, other) in all.iter().enumerate().filter(|(j, _)| *j != nearest) {
                let difference = (other.d - all[nearest].d) - x;
                let term = k * other.z * other.z / difference;
                sum += term;
                slope += term / difference;
            }
            (sum, slope)
        };
        let own = |j: usize| k * all[j].z * all[j].z;
        let (nearest, mut low, mut high) = match all.get(i + 1) {
            None => (i, 0.0, k * all.iter().map(|m| m.z * m.z).sum::<f64>()),
            Some(next) => {
                let half = 0.5 * (next.d - all[i].d);
                let is_low = rest(i, half).0 - own(i) / half >= 0.0;
                if is_low { (i, 0.0, half) } else { (i + 1, -half, 0.0) }
            }
        };
        // The function `x rest(x) - k z^2` has the same zero and no pole at the nearest value. It rises through a zero
        // above that value, and falls through one below.
        let (pole_term, side) = (own(nearest), if high > 0.0 { 1.0 } else { -1.0 });
        let mut x = 0.0;
        for _ in 0..STEPS {
            let (sum, slope) = rest(nearest, x);
            let value = x * sum - pole_term;
            if side * value > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - value / (sum + x * slope);
            let inside = newton > low.min(high) && newton < low.max(high);
            let next = if inside { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= EQUAL * next.abs() {
                x = next;
                break;
            }
            x = next;
        }
        Self { nearest, beyond: x }
    }
}

/// The component of `z` along direction `i` for which the computed zeros are exact.
fn exact(all: &[Moved], zeros: &[Zero], i: usize) -> f64 {
    let mut square = 1.0;
    for (j, zero) in zeros.iter().enumerate() {
        let above = -zero.below(all, i);
        // Each zero is paired with its neighbouring value of `D` on the side away from `i`.
        square *= match j {
            _ if j < i => above / (all[j].d - all[i].d),
            _ if j + 1 < all.len() => above / (all[j + 1].d - all[i].d),
            _ => above,
        };
    }
    square.abs().sqrt().copysign(all[i].z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::kernel::inner_product;

    /// The values of `D` are zero, equal, nearly equal or far apart, and the components of `z` have all sizes down to
    /// zero. The eigenvectors must be orthonormal, and with their eigenvalues must reproduce the matrix.
    #[test]
    fn the_pairs_are_orthonormal_and_make_up_the_matrix() {
        let mut seed = 1u64;
        let mut unit = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for round in 0..200 {
            let n = 2 + round % 30;
            let mut d: Vec<f64> = (0..n).map(|_| 1e9 * unit()).collect();
            for i in 0..n {
                match round % 4 {
                    1 if i < 3 => d[i] = 0.0,
                    2 if i > 0 => d[i] = d[i - 1] * (1.0 + 1e-14 * (unit() - 0.3)),
                    3 => d[i] *= (-40.0 * unit()).exp(),
                    _ => {}
                }
            }
            let z: Vec<f64> = (0..n).map(|_| (unit() - 0.5) * (-40.0 * unit()).exp()).collect();
            let k = 1e9 * (40.0 * (unit() - 0.5)).exp();
            let pairs = pairs(&d, k, &z);
            assert!(pairs.len() == n && pairs.is_sorted_by_key(|pair| pair.0));
            let scale = d.iter().fold(k * inner_product(&z, &z), |a, b| a.max(*b));
            for (i, (_, v)) in pairs.iter().enumerate() {
                for (j, (_, w)) in pairs.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    // The bound is one rounding for each of the n factors and terms, with a margin.
                    let bound = 20.0 * n as f64 * f64::EPSILON;
                    assert!((inner_product(v, w) - expected).abs() < bound, "{round} {i} {j}");
                }
            }
            for a in 0..n {
                for b in 0..n {
                    let sum: f64 = pairs.iter().map(|(value, v)| value * v[a] * v[b]).sum();
                    let diagonal = if a == b { d[a] } else { 0.0 };
                    let error = (sum - diagonal - k * z[a] * z[b]).abs();
                    assert!(error < 20.0 * n as f64 * f64::EPSILON * scale, "{round} {a} {b}");
                }
            }
        }
    }
}
