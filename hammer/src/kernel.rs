//! Loops over modes: the only code whose speed is felt.
//!
//! A modal vector is stored as `[first coordinates | second coordinates]`. Every loop runs
//! over chunks of [`LANES`] independent sums, so that it becomes vector code of whatever
//! width the processor at hand has (chosen at run time), and adds in the same order on
//! all of them: the answer does not depend on the machine.

use pulp::{Arch, NullaryFnOnce};
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

/// Declares a function whose body is compiled for each kind of processor.
macro_rules! vectorised {
    ($(#[$doc:meta])* fn $name:ident($($arg:ident: $kind:ty),*) -> $out:ty as $op:ident $body:block) => {
        struct $op<'a> {
            $($arg: $kind),*
        }

        impl<'a> NullaryFnOnce for $op<'a> {
            type Output = $out;

            #[inline(always)]
            fn call(self) -> $out {
                let Self { $($arg),* } = self;
                $body
            }
        }

        $(#[$doc])*
        #[inline]
        pub fn $name<'a>($($arg: $kind),*) -> $out {
            ARCH.dispatch($op { $($arg),* })
        }
    };
}

vectorised! {
    /// `y := E y` block by block; `e` holds `[e11 | e12 | e21 | e22]`.
    fn rotate(e: &'a [f64], y: &'a mut [f64]) -> () as Rotate {
        rotate_loop(e, y);
    }
}

vectorised! {
    /// `a . b`.
    fn dot(a: &'a [f64], b: &'a [f64]) -> f64 as Dot {
        dot_loop(a, b)
    }
}

vectorised! {
    /// `w . |y|`.
    fn bound(w: &'a [f64], y: &'a [f64]) -> f64 as Bound {
        let n = w.len().min(y.len());
        let ((cw, tw), (cy, ty)) = (lanes(&w[..n]), lanes(&y[..n]));
        let mut s = [0.0; LANES];
        for (x, y) in cw.iter().zip(cy) {
            for l in 0..LANES {
                s[l] += x[l] * y[l].abs();
            }
        }
        let mut tail = 0.0;
        for (x, y) in tw.iter().zip(ty) {
            tail += x * y.abs();
        }
        sum(s) + tail
    }
}

vectorised! {
    /// `[r . y, s . y, w . |y|, u . |y|]` in one pass; lengths are multiples of [`LANES`].
    fn probe(rows: [&'a [f64]; 2], weights: [&'a [f64]; 2], y: &'a [f64]) -> [f64; 4] as Probe {
        let (r, s) = (lanes(rows[0]).0, lanes(rows[1]).0);
        let (w, u) = (lanes(weights[0]).0, lanes(weights[1]).0);
        let mut sums = [[0.0; LANES]; 4];
        for ((((y, r), s), w), u) in lanes(y).0.iter().zip(r).zip(s).zip(w).zip(u) {
            for l in 0..LANES {
                sums[0][l] += r[l] * y[l];
                sums[1][l] += s[l] * y[l];
                sums[2][l] += w[l] * y[l].abs();
                sums[3][l] += u[l] * y[l].abs();
            }
        }
        [sum(sums[0]), sum(sums[1]), sum(sums[2]), sum(sums[3])]
    }
}

vectorised! {
    /// Taylor terms: adds `factor row . (B scale)^k / k! y` to `terms[k]`; `y` is used up.
    fn taylor(
        b: &'a [f64],
        row: &'a [f64],
        y: &'a mut [f64],
        scale: f64,
        factor: f64,
        terms: &'a mut [f64]
    ) -> () as Taylor {
        terms[0] += factor * dot_loop(row, y);
        for k in 1..terms.len() {
            rotate_loop(b, y);
            let s = scale / k as f64;
            for x in y.iter_mut() {
                *x *= s;
            }
            terms[k] += factor * dot_loop(row, y);
        }
    }
}

vectorised! {
    /// `out := m x`, `m` row by row.
    fn multiply(m: &'a [f64], x: &'a [f64], out: &'a mut [f64]) -> () as Multiply {
        for (row, o) in m.chunks_exact(x.len()).zip(out) {
            *o = dot_loop(row, x);
        }
    }
}

/// A symmetric form `x . m x`, packed: row `i` up to its diagonal, rounded up to whole
/// lanes, off-diagonal entries doubled. Half the memory, and it stays in the nearest cache.
#[derive(Clone, Debug, Default)]
pub struct Form {
    rows: Vec<f64>,
}

impl Form {
    /// From the full matrix, row by row, of a size that is a multiple of [`LANES`].
    pub fn new(full: &[f64], size: usize) -> Self {
        let mut rows = Vec::new();
        for i in 0..size {
            for k in 0..(i + 1).next_multiple_of(LANES) {
                rows.push(match k.cmp(&i) {
                    std::cmp::Ordering::Less => full[i * size + k] + full[k * size + i],
                    std::cmp::Ordering::Equal => full[i * size + i],
                    std::cmp::Ordering::Greater => 0.0,
                });
            }
        }
        Self { rows }
    }

    /// `x . m x`.
    pub fn of(&self, x: &[f64]) -> f64 {
        quadratic(&self.rows, x)
    }
}

vectorised! {
    fn quadratic(rows: &'a [f64], x: &'a [f64]) -> f64 as Quadratic {
        let mut totals = [0.0; LANES];
        let mut rest = rows;
        for (i, xi) in x.iter().enumerate() {
            let length = (i + 1).next_multiple_of(LANES);
            let (row, next) = rest.split_at(length);
            rest = next;
            let mut s = [0.0; LANES];
            for (r, y) in lanes(row).0.iter().zip(lanes(&x[..length]).0) {
                for l in 0..LANES {
                    s[l] += r[l] * y[l];
                }
            }
            for l in 0..LANES {
                totals[l] += xi * s[l];
            }
        }
        sum(totals)
    }
}

/// Points of a [`Fan`].
pub const FAN: usize = 32;

/// A polynomial at the points `(i + 1) / FAN`.
pub struct Fan {
    /// Values.
    pub value: [f64; FAN],
    /// Second derivatives.
    pub bend: [f64; FAN],
    /// Bounds on the third derivative from 0 to there (the polynomial of absolute
    /// coefficients, which only rises).
    pub twist: [f64; FAN],
}

vectorised! {
    /// Looks at `sum q_k x^k` all over `[0, 1]` at once.
    fn fan(q: &'a [f64]) -> Fan as FanOp {
        let mut f = Fan { value: [0.0; FAN], bend: [0.0; FAN], twist: [0.0; FAN] };
        let mut x = [0.0; FAN];
        for i in 0..FAN {
            x[i] = (i + 1) as f64 / FAN as f64;
        }
        for (k, &c) in q.iter().enumerate().rev() {
            for i in 0..FAN {
                f.value[i] = f.value[i] * x[i] + c;
            }
            if k >= 2 {
                let d = (k * (k - 1)) as f64 * c;
                for i in 0..FAN {
                    f.bend[i] = f.bend[i] * x[i] + d;
                }
            }
            if k >= 3 {
                let d = (k * (k - 1) * (k - 2)) as f64 * c.abs();
                for i in 0..FAN {
                    f.twist[i] = f.twist[i] * x[i] + d;
                }
            }
        }
        f
    }
}
