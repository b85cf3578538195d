//! All zeros of a secular function at once, by the Ehrlich-Aberth iteration: O(N^2) per sweep, where a dense
//! eigensolver takes O(N^3).

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::is_real;
use crate::modal::spectrum::secular::{Root, Secular};
use crate::numerics::math::norm;
use crate::numerics::poles::{self, Pairs, Point};
use num_complex::Complex64 as C;

/// Sweeps of the iteration; tens are needed at most.
const MAX_SWEEPS: usize = 400;
/// Displacement of a root that lies on a pole or on another root, relative to the spacing of the poles.
const SHOVE: f64 = 1e-6;

/// Two conjugate roots with an imaginary part below this part of the real one may be about to separate on the real
/// axis.
const PART: f64 = 0.5;
/// Relative displacement that then separates them: from a symmetric start they would stay conjugates.
const ASIDE: C = C::new(-0.06, 0.05);
/// A step smaller than this, relative to the distance from the pole, shows that the root has half its digits. The next
/// step, which must be below [`WHOLE`], gives it all.
const HALF: f64 = 1e-8;
const WHOLE: f64 = 1e-14;

/// Two nearly coincident roots are accurate to the square root of rounding only.
const COINCIDENT: f64 = 1e-6;
/// Of a root beside several poles that nearly coincide, minors cancel: two digits are enough for Newton's method to
/// find it afterwards.
const ROUGH: f64 = 1e-2;

/// Number of consecutive steps below these limits.
fn steps_in_place(before: u8, size: f64, rough: f64) -> u8 {
    if size <= WHOLE.max(rough) { before + 1 } else { u8::from(size <= HALF) }
}

/// Sweeps after which a root with these few digits may count as settled.
const PATIENCE: usize = 60;

/// The result of an iteration for one root.
enum Step {
    /// Move by this.
    By(C),
    /// The secular function is zero here.
    Exact,
    /// It lies on a pole or on another root.
    Blocked,
}

/// The iteration.
pub(crate) struct Roots<'a> {
    secular: &'a Secular,
    /// Squared distance of each pole to the next.
    gaps: Vec<f64>,
}

impl<'a> Roots<'a> {
    pub(crate) fn new(secular: &'a Secular) -> Self {
        let mut sites = secular.pairs.clone();
        let mut gap = |j: usize| {
            let (here, other) = (secular.sites[j], secular.sites[j ^ 1]);
            sites.banish(j / 2);
            let others = poles::nearest(&sites, Point { base: here, offset: C::default() });
            let ends = &secular.sites[j & !1..][..2];
            sites.set(j / 2, 0, [ends[0].re, ends[0].im, ends[1].re, ends[1].im]);
            others.min((other - here).norm_sqr())
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
        // Translations that only a dashpot holds must leave their pole too.
        let alone = system.shapes.iter().zip(&system.springs).filter(|(_, (k, _))| *k == 0.0);
        let braking: f64 =
            alone.map(|(shape, (_, c))| c * shape.iter().map(|x| x * x).sum::<f64>()).sum();
        let mut roots = Vec::with_capacity(2 * n);
        for i in 0..n {
            for side in 0..2 {
                let here = poles[2 * i + side];
                let gap = if i + 1 < n {
                    norm(poles[2 * (i + 1) + side] - here)
                } else {
                    (system.omega2[i] + stiffening).sqrt() - system.omega2[i].sqrt()
                };
                // Overdamped modes crowd at -1 / beta: each root starts near its own pole.
                let least = (1e-6 * stiffening.sqrt()).max(1e-6 * braking);
                let gap = gap.max(1e-3 * norm(here)).max(least);
                let here = Root { pole: 2 * i + side, offset: C::default() };
                let gap = if self.secular.in_crowd(here).is_some() { self.spacing(i) } else { gap };
                // Not a conjugate pair: two roots must be free to separate on the real axis.
                let step = if side == 0 { C::new(-0.11, 0.43) } else { C::new(-0.17, -0.37) };
                roots.push(Root { pole: 2 * i + side, offset: gap * step });
            }
        }
        roots
    }

    /// Distance of the slow pole of mode `i` to the next of another frequency, slightly smaller for
    /// every other mode, so that two of one frequency start apart.
    fn spacing(&self, i: usize) -> f64 {
        let Secular { system, sites, .. } = self.secular;
        let other = |&k: &usize| system.omega2[k] != system.omega2[i];
        let next = (i..system.omega2.len()).find(other).or_else(|| (0..i).rev().find(other));
        let part = if i.is_multiple_of(2) { 1.0 } else { 0.7 };
        next.map_or(1e-3 * norm(sites[2 * i]), |k| part * norm(sites[2 * k] - sites[2 * i]))
    }

    /// The roots, two per mode, and whether all are known: an error if they do not converge, are no conjugates,
    /// or do not fit the trace.
    pub(crate) fn solve(&self) -> (Vec<Root>, Result<(), SpectrumError>) {
        let (mut roots, mut end) = (Vec::new(), Err(SpectrumError::Unsettled));
        for ties in [true, false] {
            if end.is_err() && end != Err(SpectrumError::Cancelled) {
                roots = self.start();
                end = self.settle(&mut roots, ties);
            }
        }
        (roots, end)
    }

    /// Iterates. Roots of a mode that are tied are conjugates and take one common step, until they come
    /// near the real axis, where they may separate. Those known to few digits settle after [`PATIENCE`] sweeps.
    fn settle(&self, roots: &mut [Root], ties: bool) -> Result<(), SpectrumError> {
        let start = roots.to_vec();
        let turns = |i: usize| ties && self.secular.poles[2 * i].im > 0.0;
        let mut tied: Vec<bool> = (0..self.gaps.len() / 2).map(turns).collect();
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
                        // A root that is rounded to its pole is very near to it, but not there.
                        let (from, left) = (roots[k].offset, roots[k].offset - step);
                        let is_there = left == C::default();
                        roots[k].offset = if is_there { f64::EPSILON * from } else { left };
                        let near = roots[k].offset.norm_sqr().min(value.norm_sqr());
                        let size = (step.norm_sqr() / near).sqrt();
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

    /// Rounding alone may cause steps of this size, relative to the distance from the pole.
    fn rough(&self) -> f64 {
        if self.secular.expanded { ROUGH } else { COINCIDENT }
    }

    /// The conjugate of a root.
    fn mirrored(&self, root: Root) -> Root {
        let turns = self.secular.poles[root.pole].im != 0.0;
        let pole = if turns { root.pole ^ 1 } else { root.pole };
        Root { pole, offset: root.offset.conj() }
    }

    /// The Ehrlich-Aberth step `1 / (P'/P - sum_k 1/(x - x_k))`, `P = f prod d_i`.
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

    /// Writes the position of root `k` to the sums over all roots.
    fn place(&self, sites: &mut Pairs, k: usize, root: Root) {
        let Point { base, offset } = self.secular.point(root);
        sites.set(k / 2, 2 * (k % 2), [base.re, base.im]);
        sites.set(k / 2, 4 + 2 * (k % 2), [offset.re, offset.im]);
    }

    /// Moves the origin of a root to its nearest pole.
    fn rebase(&self, root: &mut Root) {
        let mut best = root.pole;
        let mut distance = root.offset.norm_sqr();
        // No other pole is much nearer within half the distance to the next.
        if 4.0 * distance < self.gaps[root.pole] {
            return;
        }
        if poles::nearest(&self.secular.pairs, self.secular.point(*root)) >= 0.5 * distance {
            return;
        }
        for j in 0..self.secular.poles.len() {
            let d = self.secular.off_pole(*root, j).norm_sqr();
            if d < 0.5 * distance {
                (best, distance) = (j, d);
            }
        }
        root.offset = self.secular.off_pole(*root, best);
        root.pole = best;
    }

    /// The sum of the roots is minus the trace of the damping.
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
