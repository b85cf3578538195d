//! Eigenvectors of a matrix by its real Schur form, whose blocks have one or two rows.
//!
//! Sylvester's equation separates each block from those above it.
//! Two real roots whose vectors are nearly parallel become one block. All other pairs are refined to the last digit
//! ([`Refinement`]).

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::{Block, CONFLUENT};
use crate::modal::spectrum::pairing::{Eigenpair, coincide, unit};
use crate::modal::spectrum::refinement::{MOVED, Refinement};
use crate::modal::spectrum::secular::Secular;
use crate::modal::spectrum::states::{Vector, reduced};
use crate::numerics::kernel::norm;
use crate::numerics::math;
use crate::numerics::matrix2::Matrix2;
use nalgebra::{DMatrix, Matrix4, Schur, Vector4};
use num_complex::Complex64 as C;

/// Limit of the steps of Francis' iteration for each row.
const STEPS: usize = 100;
/// Share of its size by which one of two close roots may move.
const ROOM: f64 = 1e-2;
/// If two roots are closer than this share of their size, the difference of their vectors has too few correct digits of
/// thirty.
const APART: f64 = 1e-9;

/// Finds the eigenpairs in the space that `states` span. Adds them to the `known` ones, except roots that nearly
/// coincide, and returns the blocks of these.
///
/// # Errors
///
/// [`SpectrumError::Cancelled`]; [`SpectrumError::Unsettled`] if Francis' iteration does not end.
pub(crate) fn blocks(
    secular: &Secular,
    known: &mut Vec<Vector>,
    states: &[Vec<f64>],
) -> Result<Vec<Block>, SpectrumError> {
    if states.is_empty() {
        return Ok(Vec::new());
    }
    let matrix = reduced(&secular.system, states).ok_or(SpectrumError::Unsettled)?;
    let steps = STEPS * matrix.nrows();
    let (q, t) =
        Schur::try_new(matrix, f64::EPSILON, steps).ok_or(SpectrumError::Unsettled)?.unpack();
    let (mut places, mut i) = (Vec::new(), 0);
    while i < t.nrows() {
        let rows = if i + 1 < t.nrows() && t[(i + 1, i)] != 0.0 { 2 } else { 1 };
        places.push((i, rows));
        i += rows;
    }
    let small = f64::EPSILON * t.amax();
    Form { secular, known, states, q, t, places, small }.blocks()
}

/// The Schur form `S = Q T Q'`.
struct Form<'a> {
    secular: &'a Secular,
    known: &'a mut Vec<Vector>,
    states: &'a [Vec<f64>],
    q: DMatrix<f64>,
    t: DMatrix<f64>,
    /// The first row of each block on the diagonal, and its number of rows.
    places: Vec<(usize, usize)>,
    /// Rounding of the largest entry.
    small: f64,
}

impl Form<'_> {
    fn blocks(mut self) -> Result<Vec<Block>, SpectrumError> {
        let (mut blocks, mut reals) = (Vec::new(), Vec::new());
        for (place, &(i, rows)) in self.places.clone().iter().enumerate() {
            if interrupt::is_set() {
                return Err(SpectrumError::Cancelled);
            }
            let (columns, t) = (self.separated(&[place]).0, &self.t);
            if rows == 2 {
                let b = [t[(i, i)], t[(i, i + 1)], t[(i + 1, i)], t[(i + 1, i + 1)]];
                blocks.extend(self.block(&columns, b));
            } else {
                let x = self.shape(&columns[0]).into_iter().map(C::from).collect();
                reals.push((place, self.refined((t[(i, i)].into(), x))));
            }
        }
        reals.sort_by(|a, b| b.1.pair.0.re.total_cmp(&a.1.pair.0.re));
        let mut reals = reals.into_iter().peekable();
        while let Some((place, vector)) = reals.next() {
            if let Some((other, _)) = reals.next_if(|(_, next)| coincide(&vector.pair, &next.pair))
            {
                let places = [place.min(other), place.max(other)];
                let (columns, coupling) = self.separated(&places);
                let [a, b] = places.map(|place| self.places[place].0);
                let b = [self.t[(a, a)], coupling, 0.0, self.t[(b, b)]];
                blocks.extend(self.block(&columns, b));
            } else {
                self.known.push(vector);
            }
        }
        Ok(blocks)
    }

    /// The pair, refined by Newton's method, or the given pair if the method leads to a known one.
    fn refined(&self, (s, x): Eigenpair) -> Vector {
        let refined = Refinement::new(self.secular, s, MOVED * math::norm(s), &x).solve();
        let vector = refined.map(|pair| Vector::new(&self.secular.system, pair));
        let vector = vector.filter(|vector| self.is_new(vector));
        vector.unwrap_or_else(|| Vector::new(&self.secular.system, (s, x)))
    }

    fn is_new(&self, vector: &Vector) -> bool {
        !self.known.iter().any(|known| vector.repeats(known))
    }

    /// The displacements of the state `Z Q y`.
    fn shape(&self, y: &[f64]) -> Vec<f64> {
        let mut shape = vec![0.0; self.secular.system.omega2.len()];
        for (z, row) in self.states.iter().zip(self.q.row_iter()) {
            let share: f64 = row.iter().zip(y).map(|(q, y)| q * y).sum();
            shape.iter_mut().zip(z.iter().step_by(2)).for_each(|(x, z)| *x += share * z);
        }
        shape
    }

    /// Columns `Y` with `T Y = Y B`, which in the rows of these blocks are the unit matrix. For two blocks of one row
    /// each, `B` is triangular, and the coupling above its diagonal is returned too.
    fn separated(&self, blocks: &[usize]) -> (Vec<Vec<f64>>, f64) {
        let (t, m) = (&self.t, self.t.nrows());
        let rows_of = |k: &usize| self.places[*k].0..self.places[*k].0 + self.places[*k].1;
        let block_rows: Vec<usize> = blocks.iter().flat_map(rows_of).collect();
        let mut y = vec![vec![0.0; m]; block_rows.len()];
        block_rows.iter().zip(&mut y).for_each(|(row, y)| y[*row] = 1.0);
        let mut coupling = 0.0;
        let entry = |c: usize, d: usize, coupling: f64| match (c, d) {
            _ if c == d => t[(block_rows[c], block_rows[c])],
            (0, 1) if blocks.len() == 2 => coupling,
            _ if blocks.len() == 2 => 0.0,
            _ => t[(block_rows[c], block_rows[d])],
        };
        for place in (0..*blocks.last().unwrap_or(&0)).rev() {
            let (i, rows) = self.places[place];
            let source =
                |a: usize, y: &[f64]| -> f64 { (i + rows..m).map(|k| t[(i + a, k)] * y[k]).sum() };
            if blocks.len() == 2 && place == blocks[0] {
                coupling = source(0, &y[1]);
                continue;
            }
            // Sylvester's equation is T_ii X - X B = -source.
            let (mut matrix, mut right) = (Matrix4::<f64>::identity(), Vector4::<f64>::zeros());
            for (a, c) in (0..rows).flat_map(|a| (0..block_rows.len()).map(move |c| (a, c))) {
                let row = 2 * a + c;
                matrix[(row, row)] = 0.0;
                (0..rows).for_each(|b| matrix[(row, 2 * b + c)] += t[(i + a, i + b)]);
                (0..block_rows.len())
                    .for_each(|d| matrix[(row, 2 * a + d)] -= entry(d, c, coupling));
                right[row] = -source(a, &y[c]);
            }
            let x = self.solved(matrix, right);
            for (a, c) in (0..rows).flat_map(|a| (0..block_rows.len()).map(move |c| (a, c))) {
                y[c][i + a] = x[2 * a + c];
            }
        }
        (y, coupling)
    }

    /// The solution of linear equations. If rounding makes it too large, it is replaced by one of limited size.
    fn solved(&self, matrix: Matrix4<f64>, right: Vector4<f64>) -> Vector4<f64> {
        let x = matrix.full_piv_lu().solve(&right);
        let fits = |x: &Vector4<f64>| self.small * x.amax() <= right.amax().max(self.small);
        x.filter(fits).unwrap_or_else(|| match right.amax() <= 64.0 * self.small {
            true => Vector4::zeros(),
            false => right / self.small,
        })
    }

    /// The block of two columns with `T Y = Y B`; `None` for an oscillation, which is added to the known pairs.
    fn block(&mut self, columns: &[Vec<f64>], b: Matrix2) -> Option<Block> {
        let v = [0, 1].map(|k| self.shape(&columns[k]));
        let sigma = 0.5 * (b[0] + b[3]);
        let (a, p, c) = (0.5 * (b[0] - b[3]), b[1], b[2]);
        let delta = -(a * a + p * c);
        let mix =
            |x: C, y: C| -> Vec<C> { v[0].iter().zip(&v[1]).map(|(s, t)| x * s + y * t).collect() };
        // The eigenpair of the root `sigma + half`.
        let pair = |half: C| {
            let x =
                if p.abs() > c.abs() { mix(p.into(), half - a) } else { mix(half + a, c.into()) };
            (sigma + half, x)
        };
        if delta > (CONFLUENT * sigma) * (CONFLUENT * sigma) {
            let vector = self.refined(pair(C::new(0.0, delta.sqrt())));
            self.known.push(vector);
            return None;
        }
        let half = if delta > 0.0 { C::new(0.0, delta.sqrt()) } else { (-delta).sqrt().into() };
        if let Some(block) = self.confluent([half, -half].map(pair)) {
            return Some(block);
        }
        // The vector that `B - sigma` changes most is the divided difference of the eigenvectors. The result of this
        // change is their mean.
        let scale = 0.5 * sigma.abs();
        let real = |x: f64, y: f64| self.real(&mix(x.into(), y.into()));
        let (means, differences) = ([real(a, c), real(p, -a)], [real(1.0, 0.0), real(0.0, 1.0)]);
        let ratio = |k: usize| norm(&means[k]) / norm(&differences[k]);
        let k = usize::from(ratio(1) > ratio(0));
        let difference = differences[k].iter().map(|x| scale * x);
        Some(together(sigma, delta, [means[k].clone(), difference.collect()]))
    }

    /// The real part of a vector, converted to the free modes.
    fn real(&self, x: &[C]) -> Vec<f64> {
        self.secular.system.unmerged(x).iter().map(|z| z.re).collect()
    }

    /// The block of two roots that are close together; `None` if they are too close, or not found. Each pair is refined
    /// to twice the digits, so that enough of them are left in the difference of the vectors.
    fn confluent(&self, [one, other]: [Eigenpair; 2]) -> Option<Block> {
        let refine = |(s, x): Eigenpair| {
            let room = ROOM * math::norm(s);
            let (s, x) = Refinement::new(self.secular, s, room, &x).solve_widely()?;
            let pair = (s.value(), x.iter().map(|x| x.value()).collect());
            self.is_new(&Vector::new(&self.secular.system, pair)).then_some((s, x))
        };
        let is_oscillation = one.0.im != 0.0;
        let (s, x) = refine(one)?;
        let (t, y) = if is_oscillation {
            (s.conjugate(), x.iter().map(|x| x.conjugate()).collect())
        } else {
            refine(other)?
        };
        let difference = s - t;
        if math::norm(difference.value()) < APART * math::norm(s.value()) {
            return None;
        }
        // Both vectors are scaled so that the same amplitude is 1 in both.
        let size = |k: usize| x[k].value().norm_sqr();
        let largest = (0..x.len()).max_by(|&i, &j| size(i).total_cmp(&size(j)))?;
        let (one, other) = (x[largest].inverse(), y[largest].inverse());
        let pairs = x.iter().zip(&y).map(|(x, y)| (*x * one, *y * other));
        let (means, differences): (Vec<C>, Vec<C>) = pairs
            .map(|(x, y)| (((x + y) * 0.5).value(), ((x - y) * difference.inverse()).value()))
            .unzip();
        let sigma = ((s + t) * 0.5).value().re;
        let scale = 0.5 * sigma.abs();
        let differences = self.real(&differences).iter().map(|x| scale * x).collect();
        let delta = -(difference * difference * 0.25).value().re;
        let block = together(sigma, delta, [self.real(&means), differences]);
        block.shapes.iter().flatten().all(|x| x.is_finite()).then_some(block)
    }
}

/// The block with the characteristic polynomial `(s - sigma)^2 + delta`, from the mean of its vectors and `sigma / 2`
/// times their divided difference. The two together are scaled to norm 1.
fn together(sigma: f64, delta: f64, [mean, difference]: [Vec<f64>; 2]) -> Block {
    let unit_pair = unit([&mean[..], &difference].concat());
    let (mean, difference) = unit_pair.split_at(unit_pair.len() / 2);
    Block::quadratic(sigma, delta, 0.5 * sigma.abs(), [mean.to_vec(), difference.to_vec()])
}
