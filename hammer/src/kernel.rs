//! Loops over modes: the only code whose speed is felt.
//!
//! A modal vector is stored as `[first coordinates | second coordinates]`.

/// `y := E y` block by block; `e` holds `[e11 | e12 | e21 | e22]`.
pub fn rotate(e: &[f64], y: &mut [f64]) {
    let n = y.len() / 2;
    let (a, b) = y.split_at_mut(n);
    let (e11, rest) = e.split_at(n);
    let (e12, rest) = rest.split_at(n);
    let (e21, e22) = rest.split_at(n);
    for i in 0..n {
        let (p, q) = (a[i], b[i]);
        a[i] = e11[i] * p + e12[i] * q;
        b[i] = e21[i] * p + e22[i] * q;
    }
}

const LANES: usize = 8;

/// `a . b`.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; LANES];
    let (ca, cb) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for l in 0..LANES {
            sums[l] += x[l] * y[l];
        }
    }
    sums.iter().sum::<f64>() + tail
}

/// `w . |y|`.
pub fn bound(w: &[f64], y: &[f64]) -> f64 {
    let n = w.len().min(y.len());
    let (w, y) = (&w[..n], &y[..n]);
    let mut sums = [0.0; LANES];
    let (cw, cy) = (w.chunks_exact(LANES), y.chunks_exact(LANES));
    let tail: f64 = cw.remainder().iter().zip(cy.remainder()).map(|(w, y)| w * y.abs()).sum();
    for (w, y) in cw.zip(cy) {
        for l in 0..LANES {
            sums[l] += w[l] * y[l].abs();
        }
    }
    sums.iter().sum::<f64>() + tail
}

/// `out := m x`, `m` row by row.
pub fn multiply(m: &[f64], x: &[f64], out: &mut [f64]) {
    for (row, o) in m.chunks_exact(x.len()).zip(out) {
        *o = dot(row, x);
    }
}

/// `x . m x`, `m` row by row.
pub fn quadratic(m: &[f64], x: &[f64]) -> f64 {
    m.chunks_exact(x.len()).zip(x).map(|(row, xi)| xi * dot(row, x)).sum()
}
