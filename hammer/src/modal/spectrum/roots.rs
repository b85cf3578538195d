//! The Ehrlich-Aberth iteration, which finds all zeros of a secular function at once. A sweep takes O(N^2) operations,
//! while a dense eigensolver takes O(N^3).

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::is_real;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use crate::numerics::poles::{self, Pairs, Point};
use num_complex::Complex64 as C;

/// Limit of the sweeps of the iteration; at most some tens are needed.
const MAX_SWEEPS: usize = 400;
/// How far a root is moved away if it lies on a pole or on another root, as a share of its first distance from it.
const SHOVE: f64 = 1e-6;

/// Two conjugate roots whose imaginary part is below this share of the real part may be about to separate on the real
/// axis.
const PART: f64 = 0.5;
/// Relative displacement that then separates them. From a symmetric position they would remain conjugates.
const ASIDE: C = C::new(-0.06, 0.05);
/// If a step is below this, relative to the distance from the pole, half of the root's digits are correct. The next
/// step, which must be below [`WHOLE`], makes all of them correct.
const HALF: f64 = 1e-8;
const WHOLE: f64 = 1e-14;

/// Relative accuracy of two nearly coincident roots, which is only the square root of rounding.
const COINCIDENT: f64 = 1e-6;
/// Relative accuracy of a root near several poles that nearly coincide, where minors cancel. Two digits are enough for
/// Newton's method to find the root afterwards.
const ROUGH: f64 = 1e-2;

/// Number of consecutive steps, including this one, that are so small that two of them settle the root.
fn steps_in_place(before: u8, size: f64, rough: f64) -> u8 {
    if size <= WHOLE.max(rough) { before + 1 } else { u8::from(size <= HALF) }
}

/// Number of sweeps after which a root counts as settled even with so few correct digits.
const PATIENCE: usize = 60;

/// A step of the iteration for one root.
enum Step {
    /// The root moves by this.
    By(C),
    /// The secular function is zero at the root.
    Exact,
    /// The root lies on a pole or on another root.
    Blocked,
}

/// The iteration for all roots of a secular function.
pub(crate) struct Roots<'a> {
    secular: &'a Secular,
    /// Squared distance of each pole from its nearest neighbour.
    gaps: Vec<f64>,
}

impl<'a> Roots<'a> {
    pub(crate) fn new(secular: &'a Secular) -> Self {
        let mut sites = secular.pairs.clone();
        let mut gap = |j: usize| {
            let (pole, other) = (secular.sites[j], secular.sites[j ^ 1]);
            sites.banish(j / 2);
            let others = poles::nearest(&sites, Point { base: pole, offset: C::default() });
            let pair = &secular.sites[j & !1..][..2];
            sites.set(j / 2, 0, [pair[0].re, pair[0].im, pair[1].re, pair[1].im]);
            others.min((other - pole).norm_sqr())
        };
        Self { secular, gaps: (0..secular.sites.len()).map(&mut gap).collect() }
    }

    fn start(&self) -> Vec<Root> {
        let (system, poles) = (&self.secular.system, &self.secular.poles);
        let n = system.omega2.len();
        let stiffening: f64 = system
            .shapes
            .iter()
            .zip(&system.springs)
            .map(|(shape, (k, _))| k * shape.iter().map(|x| x * x).sum::<f64>())
            .fold(0.0, f64::max);
        // If only a dashpot acts on a translation, its roots must leave their pole too.
        let dashpots = system.shapes.iter().zip(&system.springs).filter(|(_, (k, _))| *k == 0.0);
        let braking: f64 =
            dashpots.map(|(shape, (_, c))| c * shape.iter().map(|x| x * x).sum::<f64>()).sum();
        let mut roots = Vec::with_capacity(2 * n);
        for i in 0..n {
            for side in 0..2 {
                let pole = poles[2 * i + side];
                let gap = if i + 1 < n {
                    norm(poles[2 * (i + 1) + side] - pole)
                } else {
                    (system.omega2[i] + stiffening).sqrt() - system.omega2[i].sqrt()
                };
                // The poles of overdamped modes crowd at -1 / beta, where each root starts near its own pole.
                let least = (1e-6 * stiffening.sqrt()).max(1e-6 * braking);
                let gap = gap.max(1e-3 * norm(pole)).max(least);
                let root = Root { pole: 2 * i + side, offset: C::default() };
                let gap = if self.secular.in_crowd(root).is_some() { self.spacing(i) } else { gap };
                // The two roots do not start as conjugates, because they must be free to separate on the real axis.
                let step = if side == 0 { C::new(-0.11, 0.43) } else { C::new(-0.17, -0.37) };
                roots.push(Root { pole: 2 * i + side, offset: gap * step });
            }
        }
        roots
    }

    /// Distance of the slow pole of mode `i` from the next one of another frequency. It is made smaller for every
    /// second mode, so that the roots of two modes with one frequency start apart.
    fn spacing(&self, i: usize) -> f64 {
        let Secular { system, sites, .. } = self.secular;
        let other = |&k: &usize| system.omega2[k] != system.omega2[i];
        let next = (i..system.omega2.len()).find(other).or_else(|| (0..i).rev().find(other));
        let factor = if i.is_multiple_of(2) { 1.0 } else { 0.7 };
        next.map_or(1e-3 * norm(sites[2 * i]), |k| factor * norm(sites[2 * k] - sites[2 * i]))
    }

    /// The roots, two for each mode. The result is an error if they do not converge, do not come in conjugate pairs, or
    /// do not fit the trace.
    pub(crate) fn solve(&self) -> (Vec<Root>, Result<(), SpectrumError>) {
        let (mut roots, mut result) = (Vec::new(), Err(SpectrumError::Unsettled));
        for ties in [true, false] {
            if result.is_err() && result != Err(SpectrumError::Cancelled) {
                roots = self.start();
                result = self.settle(&mut roots, ties);
            }
        }
        (roots, result)
    }

    /// Iterates until all roots are settled.
    /// If `ties`, the two roots of an oscillating mode are tied: they are conjugates and take one common step, until
    /// they come near the real axis, where they may separate.
    /// Roots with few correct digits settle after [`PATIENCE`] sweeps.
    fn settle(&self, roots: &mut [Root], ties: bool) -> Result<(), SpectrumError> {
        let start = roots.to_vec();
        let is_tied = |i: usize| ties && self.secular.poles[2 * i].im > 0.0;
        let mut tied: Vec<bool> = (0..self.gaps.len() / 2).map(is_tied).collect();
        let mut sites = Pairs::new(tied.len(), poles::PLACES);
        for (i, _) in tied.iter().enumerate().filter(|(_, tied)| **tied) {
            roots[2 * i + 1] = self.mirrored(roots[2 * i]);
        }
        (0..roots.len()).for_each(|k| self.place(&mut sites, k, roots[k]));
        let mut settled = vec![0u8; roots.len()];
        if let Some(mode) = self.secular.sliding() {
            roots[2 * mode].offset = C::default();
            self.place(&mut sites, 2 * mode, roots[2 * mode]);
            settled[2 * mode] = 2;
        }
        for sweep in 0..MAX_SWEEPS {
            let mut moving = false;
            for k in 0..roots.len() {
                let follows = k % 2 == 1 && tied[k / 2];
                if settled[k] >= 2 || follows {
                    continue;
                }
                if interrupt::is_set() {
                    return Err(SpectrumError::Cancelled);
                }
                match self.correction(roots, &mut sites, k) {
                    Step::By(step) => {
                        let value = self.secular.value(roots[k]);
                        // A root that would be rounded to its pole is very near to it, but not on it.
                        let (old, new) = (roots[k].offset, roots[k].offset - step);
                        let is_on_pole = new == C::default();
                        roots[k].offset = if is_on_pole { f64::EPSILON * old } else { new };
                        let distance2 = roots[k].offset.norm_sqr().min(value.norm_sqr());
                        let size = (step.norm_sqr() / distance2).sqrt();
                        let rough = if sweep > PATIENCE { self.rough() } else { 0.0 };
                        settled[k] = steps_in_place(settled[k], size, rough);
                        self.rebase(&mut roots[k]);
                    }
                    Step::Exact => {
                        settled[k] = 2;
                        continue;
                    }
                    Step::Blocked => {
                        let aside = SHOVE * norm(start[k].offset);
                        roots[k].offset = 1.01 * roots[k].offset + aside * C::new(1.0, 2.0);
                    }
                }
                moving = true;
                if tied[k / 2] {
                    let value = self.secular.value(roots[k]);
                    roots[k + 1] = self.mirrored(roots[k]);
                    if value.im <= PART * value.re.abs() {
                        tied[k / 2] = false;
                        settled[k] = 0;
                        roots[k + 1].offset += norm(value) * ASIDE;
                    }
                    self.place(&mut sites, k + 1, roots[k + 1]);
                }
                self.place(&mut sites, k, roots[k]);
            }
            if !moving {
                return self.check(roots);
            }
        }
        Err(SpectrumError::Unsettled)
    }

    /// Size of the steps that rounding alone may cause, relative to the distance from the pole.
    fn rough(&self) -> f64 {
        if self.secular.expanded { ROUGH } else { COINCIDENT }
    }

    fn mirrored(&self, root: Root) -> Root {
        let oscillates = self.secular.poles[root.pole].im != 0.0;
        let pole = if oscillates { root.pole ^ 1 } else { root.pole };
        Root { pole, offset: root.offset.conj() }
    }

    /// The Ehrlich-Aberth step `1 / (P'/P - sum_k 1/(x - x_k))` of the polynomial `P = f prod d_i`.
    fn correction(&self, roots: &[Root], sites: &mut Pairs, k: usize) -> Step {
        let (f, slope, poles) = self.secular.function(roots[k]);
        if f == C::default() {
            return Step::Exact;
        }
        let mut sum = slope / f + poles;
        let other = k ^ 1;
        sites.banish(k / 2);
        sum -= poles::inverse_distances(sites, self.secular.point(roots[k]));
        sum -= self.secular.difference(roots[k], roots[other]).inv();
        self.place(sites, k, roots[k]);
        self.place(sites, other, roots[other]);
        let step = 1.0 / sum;
        if step.is_finite() { Step::By(step) } else { Step::Blocked }
    }

    /// Writes the position of root `k` to `sites`, over which the sums are taken.
    fn place(&self, sites: &mut Pairs, k: usize, root: Root) {
        let Point { base, offset } = self.secular.point(root);
        sites.set(k / 2, 2 * (k % 2), [base.re, base.im]);
        sites.set(k / 2, 4 + 2 * (k % 2), [offset.re, offset.im]);
    }

    /// Changes the pole from which a root is measured to the nearest one, if that is much nearer.
    fn rebase(&self, root: &mut Root) {
        let mut nearest = root.pole;
        let mut distance = root.offset.norm_sqr();
        // Within half the distance to the next pole, no other pole is much nearer.
        if 4.0 * distance < self.gaps[root.pole] {
            return;
        }
        if poles::nearest(&self.secular.pairs, self.secular.point(*root)) >= 0.5 * distance {
            return;
        }
        for j in 0..self.secular.poles.len() {
            let d = self.secular.off_pole(*root, j).norm_sqr();
            if d < 0.5 * distance {
                (nearest, distance) = (j, d);
            }
        }
        root.offset = self.secular.off_pole(*root, nearest);
        root.pole = nearest;
    }

    /// Checks that the sum of the roots is minus the trace of the damping, and that roots come in conjugate pairs.
    fn check(&self, roots: &[Root]) -> Result<(), SpectrumError> {
        let system = &self.secular.system;
        let sum: C = roots.iter().map(|&r| self.secular.value(r)).sum();
        let size: f64 = roots.iter().map(|&r| norm(self.secular.value(r))).sum();
        let mut trace: f64 = system.omega2.iter().map(|w2| system.beta * w2).sum();
        for (shape, (_, c)) in system.shapes.iter().zip(&system.springs) {
            trace += c * shape.iter().map(|x| x * x).sum::<f64>();
        }
        if !sum.is_finite() || norm(sum + trace) > 1e-7 * size {
            return Err(SpectrumError::Trace);
        }
        let values = roots.iter().map(|&root| self.secular.value(root));
        let sides = values.filter(|&s| !is_real(s)).map(|s| s.im.signum());
        if sides.sum::<f64>() == 0.0 { Ok(()) } else { Err(SpectrumError::Unpaired) }
    }
}
