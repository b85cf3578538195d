//! Loops over modes: the only code whose speed is felt.
//!
//! A modal vector is stored as `[first coordinates | second coordinates]`. Every loop runs
//! over chunks of [`LANES`] independent sums, so that it becomes vector code of whatever
//! width the processor at hand has (chosen at run time), and adds in the same order on
//! all of them: the answer does not depend on the machine.

use pulp::Arch;
use std::sync::LazyLock;

/// Independent sums; modal vectors are padded to a multiple of this.
pub const LANES: usize = 8;

static ARCH: LazyLock<Arch> = LazyLock::new(Arch::new);

type Lane = [f64; LANES];

#[inline(always)]
fn lanes(x: &[f64]) -> (&[Lane], &[f64]) {
    x.as_chunks()
}

#[inline(always)]
fn sum(lane: Lane) -> f64 {
    let half: [f64; 4] = std::array::from_fn(|l| lane[l] + lane[l + 4]);
    (half[0] + half[2]) + (half[1] + half[3])
}

#[inline(always)]
fn dot_loop(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((ca, ta), (cb, tb)) = (lanes(&a[..n]), lanes(&b[..n]));
    let mut s = [0.0; LANES];
    for (x, y) in ca.iter().zip(cb) {
        for l in 0..LANES {
            s[l] += x[l] * y[l];
        }
    }
    let mut tail = 0.0;
    for (x, y) in ta.iter().zip(tb) {
        tail += x * y;
    }
    sum(s) + tail
}

#[inline(always)]
fn rotate_loop(e: &[f64], y: &mut [f64]) {
    let n = y.len() / 2;
    let (a, b) = y.split_at_mut(n);
    let (e11, rest) = e.split_at(n);
    let (e12, rest) = rest.split_at(n);
    let (e21, e22) = rest.split_at(n);
    let (e12, e21, e22) = (&e12[..n], &e21[..n], &e22[..n]);
    for i in 0..n {
        let (p, q) = (a[i], b[i]);
        a[i] = e11[i] * p + e12[i] * q;
        b[i] = e21[i] * p + e22[i] * q;
    }
}

/// `y := E y` block by block; `e` holds `[e11 | e12 | e21 | e22]`.
pub fn rotate(e: &[f64], y: &mut [f64]) {
    ARCH.dispatch(
        #[inline(always)]
        || rotate_loop(e, y),
    );
}

/// `a . b`.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    ARCH.dispatch(
        #[inline(always)]
        || dot_loop(a, b),
    )
}

/// `w . |y|`.
pub fn bound(w: &[f64], y: &[f64]) -> f64 {
    ARCH.dispatch(
        #[inline(always)]
        || {
            let n = w.len().min(y.len());
            let ((cw, tw), (cy, ty)) = (lanes(&w[..n]), lanes(&y[..n]));
            let mut s = [0.0; LANES];
            for (x, y) in cw.iter().zip(cy) {
                for l in 0..LANES {
                    s[l] += x[l] * y[l].abs();
                }
            }
            let tail: f64 = tw.iter().zip(ty).map(|(x, y)| x * y.abs()).sum();
            sum(s) + tail
        },
    )
}

/// `[r . y, s . y, w . |y|, u . |y|]` in one pass; lengths are multiples of [`LANES`].
pub fn probe(rows: [&[f64]; 2], weights: [&[f64]; 2], y: &[f64]) -> [f64; 4] {
    ARCH.dispatch(
        #[inline(always)]
        || {
            let (r, s, w, u) =
                (lanes(rows[0]).0, lanes(rows[1]).0, lanes(weights[0]).0, lanes(weights[1]).0);
            let mut sums = [[0.0; LANES]; 4];
            for ((((y, r), s), w), u) in lanes(y).0.iter().zip(r).zip(s).zip(w).zip(u) {
                for l in 0..LANES {
                    sums[0][l] += r[l] * y[l];
                    sums[1][l] += s[l] * y[l];
                    sums[2][l] += w[l] * y[l].abs();
                    sums[3][l] += u[l] * y[l].abs();
                }
            }
            sums.map(sum)
        },
    )
}

/// Taylor terms: adds `factor row . (B scale)^k / k! y` to `terms[k]`; `y` is used up.
pub fn taylor(b: &[f64], row: &[f64], y: &mut [f64], scale: f64, factor: f64, terms: &mut [f64]) {
    ARCH.dispatch(
        #[inline(always)]
        || {
            terms[0] += factor * dot_loop(row, y);
            for (k, term) in terms.iter_mut().enumerate().skip(1) {
                rotate_loop(b, y);
                let s = scale / k as f64;
                for x in y.iter_mut() {
                    *x *= s;
                }
                *term += factor * dot_loop(row, y);
            }
        },
    );
}

/// `out := m x`, `m` row by row.
pub fn multiply(m: &[f64], x: &[f64], out: &mut [f64]) {
    ARCH.dispatch(
        #[inline(always)]
        || {
            for (row, o) in m.chunks_exact(x.len()).zip(out) {
                *o = dot_loop(row, x);
            }
        },
    );
}

/// `x . m x`, `m` row by row.
pub fn quadratic(m: &[f64], x: &[f64]) -> f64 {
    ARCH.dispatch(
        #[inline(always)]
        || {
            let mut total = 0.0;
            for (row, xi) in m.chunks_exact(x.len()).zip(x) {
                total += xi * dot_loop(row, x);
            }
            total
        },
    )
}

/// Points of a [`Fan`].
pub const FAN: usize = 32;

/// A polynomial at the points `(i + 1) / FAN`: value, and a bound on the second derivative
/// from 0 to there (the polynomial of absolute coefficients, which only rises).
pub struct Fan {
    /// Values.
    pub value: [f64; FAN],
    /// Bounds on the second derivative.
    pub bend: [f64; FAN],
}

/// Looks at `sum q_k x^k` all over `[0, 1]` at once.
pub fn fan(q: &[f64]) -> Fan {
    ARCH.dispatch(
        #[inline(always)]
        || {
            let mut f = Fan { value: [0.0; FAN], bend: [0.0; FAN] };
            let x: [f64; FAN] = std::array::from_fn(|i| (i + 1) as f64 / FAN as f64);
            for (k, &c) in q.iter().enumerate().rev() {
                for i in 0..FAN {
                    f.value[i] = f.value[i] * x[i] + c;
                }
                if k >= 2 {
                    let d = (k * (k - 1)) as f64 * c.abs();
                    for i in 0..FAN {
                        f.bend[i] = f.bend[i] * x[i] + d;
                    }
                }
            }
            f
        },
    )
}
