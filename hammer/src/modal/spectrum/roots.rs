//! All zeros of a secular function at once, by the Ehrlich-Aberth iteration: O(N^2) per sweep, where a dense
//! eigensolver takes O(N^3).

use crate::error::SpectrumError;
use crate::interrupt;
use crate::modal::spectrum::block::is_real;
use crate::modal::spectrum::secular::{Root, Secular, WEIGHTS};
use crate::modal::spectrum::undamped;
use crate::numerics::math::norm;
use crate::numerics::poles::{self, AWAY, PLACES, Pairs, Point};
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
/// After such a small step other roots do not matter to the next one.
const ALONE: f64 = 1e-6;

/// Two nearly coincident roots are accurate to the square root of rounding only.
const COINCIDENT: f64 = 1e-6;
/// Of a root beside several poles that nearly coincide, minors cancel: two digits are enough for Newton's method to
/// find it afterwards.
const ROUGH: f64 = 1e-2;

/// Number of consecutive steps below these limits. A step so much smaller than the last that the next would be below the
/// second one is both.
fn steps_in_place(before: u8, [last, size]: [f64; 2], rough: f64) -> u8 {
    let whole = WHOLE.max(rough);
    match size {
        _ if size * size <= whole * last => 2,
        _ if size <= whole => before + 1,
        _ => u8::from(size <= HALF),
    }
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
    pub(crate) secular: &'a Secular,
}

impl Roots<'_> {
    /// A place of each root, near the known ones.
    fn start(&self, near: &[Option<C>]) -> Vec<Root> {
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
            if let Some(known) = near.get(i).copied().flatten() {
                let mut root = Root { pole: 2 * i, offset: known - poles[2 * i] };
                self.rebase(&mut root);
                if root.offset != C::default() {
                    (roots[2 * i], roots[2 * i + 1]) = (root, self.mirrored(root));
                }
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
        for (near, ties) in [(true, true), (false, true), (false, false)] {
            if end.is_err() && end != Err(SpectrumError::Cancelled) {
                let near = if near { undamped::roots(&self.secular.system) } else { Vec::new() };
                roots = self.start(&near);
                let turns = |i: usize| self.secular.poles[2 * i].im > 0.0;
                let known = |i: usize| near.get(i).is_some_and(Option::is_some);
                let tied = (0..roots.len() / 2).map(|i| ties && (turns(i) || known(i)));
                end = self.settle(&mut roots, &mut tied.collect::<Vec<_>>(), !near.is_empty());
            }
        }
        (roots, end)
    }

    /// Iterates. Roots of a mode that are tied are conjugates and take one common step, until they come
    /// near the real axis, where they may separate. Those known to few digits settle after [`PATIENCE`] sweeps. From a
    /// good start, `quick` takes a step in proportion for the last.
    fn settle(
        &self,
        roots: &mut [Root],
        tied: &mut [bool],
        quick: bool,
    ) -> Result<(), SpectrumError> {
        let start = roots.to_vec();
        let mut sites = Pairs::new(tied.len(), PLACES, AWAY);
        for (i, _) in tied.iter().enumerate().filter(|(_, tied)| **tied) {
            roots[2 * i + 1] = self.mirrored(roots[2 * i]);
        }
        (0..roots.len()).for_each(|k| self.place(&mut sites, k, roots[k]));
        let mut settled = vec![0u8; roots.len()];
        let mut last = vec![if quick { 1.0 } else { 0.0 }; roots.len()];
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
                match self.correction(roots, &mut sites, k, quick && last[k] < ALONE) {
                    Step::By(step) => {
                        let value = self.secular.value(roots[k]);
                        // A root that is rounded to its pole is very near to it, but not there.
                        let (from, left) = (roots[k].offset, roots[k].offset - step);
                        let is_there = left == C::default();
                        roots[k].offset = if is_there { f64::EPSILON * from } else { left };
                        let near = roots[k].offset.norm_sqr().min(value.norm_sqr());
                        let size = (step.norm_sqr() / near).sqrt();
                        let rough = if sweep > PATIENCE { self.rough() } else { 0.0 };
                        settled[k] = steps_in_place(settled[k], [last[k], size], rough);
                        last[k] = if quick { size } else { 0.0 };
                        self.rebase(&mut roots[k]);
                    }
                    Step::Exact => {
                        settled[k] = 2;
                        [k, k ^ 1].into_iter().for_each(|k| self.place(&mut sites, k, roots[k]));
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
                }
                [k, k ^ 1].into_iter().for_each(|k| self.place(&mut sites, k, roots[k]));
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

    /// The Ehrlich-Aberth step `1 / (P'/P - sum_k 1/(x - x_k))`, `P = f prod d_i`; of a root that is `alone` without the
    /// last sum. It takes the mode's roots out of `sites`.
    fn correction(&self, roots: &[Root], sites: &mut Pairs, k: usize, alone: bool) -> Step {
        let (f, slope, poles) = self.secular.function(roots[k]);
        if f == C::default() {
            return Step::Exact;
        }
        let mut sum = slope / f + poles;
        if !alone {
            sites.set(k / 2, 0, AWAY);
            sum -= poles::inverse_distances(sites, self.secular.point(roots[k]));
            sum -= self.secular.difference(roots[k], roots[k ^ 1]).inv();
        }
        let step = 1.0 / sum;
        if step.is_finite() { Step::By(step) } else { Step::Blocked }
    }

    /// Writes the position of root `k` to the sums over all roots.
    fn place(&self, sites: &mut Pairs, k: usize, root: Root) {
        let Point { base, offset } = self.secular.point(root);
        sites.set(k / 2, 2 * (k % 2), [base.re, base.im]);
        sites.set(k / 2, 4 + 2 * (k % 2), [offset.re, offset.im]);
    }

    /// Moves the origin of a root to its nearest pole. The poles of one side lie on a curve in their order, no more of
    /// them in one place than there are attachments.
    fn rebase(&self, root: &mut Root) {
        let steps = (1..=WEIGHTS.len()).map(|step| 2 * step);
        loop {
            let here = root.pole;
            let near = steps.clone().flat_map(|step| [here.wrapping_sub(step), here + step]);
            let near = near.chain([here ^ 1]).filter(|j| *j < self.secular.poles.len());
            let distance = |j: usize| self.secular.off_pole(*root, j).norm_sqr();
            let best = near.map(|j| (distance(j), j)).min_by(|a, b| a.0.total_cmp(&b.0));
            match best {
                Some((least, best)) if least < root.offset.norm_sqr() => {
                    *root = Root { pole: best, offset: self.secular.off_pole(*root, best) };
                }
                _ => return,
            }
        }
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
