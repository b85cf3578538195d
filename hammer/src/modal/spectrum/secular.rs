//! The secular function. Its zeros are the eigenvalues; the matrix of which it is the determinant gives the
//! eigenvectors.
//!
//! With the receptances `R_ab = sum_i phi_{a,i} phi_{b,i} / d_i(s)`, where `d_i = s^2 + beta w_i^2 s + w_i^2`, and with
//! `kappa_a = k_a + c_a s`, the eigenvalues are the zeros of
//!
//! ```text
//! f(s) = det(1 + kappa R) = 1 + kappa_1 R_11 + kappa_2 R_22
//!                             + kappa_1 kappa_2 (R_11 R_22 - R_12^2)
//! ```
//!
//! for two attachments, and of the same determinant of higher order for three and four.
//!
//! A point `s` is stored as an offset from its nearest pole, so that `d_i` does not cancel near it (as in LAPACK's
//! `dlaed4`).
//!
//! The slow pole of an overdamped mode, `beta w_i > 2`, tends to `-1 / beta` with growing frequency: `s + 1 / beta =
//! -s^2 / (beta w_i^2)`. If several such poles crowd there, these small numbers are stored
//! ([`Secular::measured_from_crowd`]), so that their differences keep all digits.

use crate::modal::spectrum::deflation::Deflated;
use crate::modal::spectrum::jet::Jet;
use crate::numerics::poles::{self, Pairs, Point, Weighed};
use num_complex::Complex64 as C;
use std::cell::RefCell;

/// A point of the complex plane, given as an offset from a pole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub(crate) pole: usize,
    pub(crate) offset: C,
}

/// Magnitude of a number whose square neither overflows nor underflows.
pub(crate) fn size(z: C) -> f64 {
    z.norm_sqr().sqrt()
}

/// Pairs of attachments in the order of their weights. Three attachments use the first six pairs.
pub(crate) const PAIRS: [[usize; 2]; 10] =
    [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2], [0, 3], [1, 3], [2, 3], [3, 3]];

/// Largest number of attachments and dominating modes together.
pub(crate) const MAX_ORDER: usize = 6;

/// Number of weights in the sums over the poles for one, two, three and four attachments.
const WEIGHTS: [usize; 4] = [1, 4, 6, 10];

/// Receptances of one or two attachments: those of the vibrating modes, `1 / s^2` of the bodies' translations (`free`),
/// and the sum of `minor_i / d_i` (`joined`) by which the determinant combines the two.
#[derive(Clone, Copy, Debug, Default)]
struct Receptance {
    r11: Jet,
    r12: Jet,
    r22: Jet,
    free: Jet,
    joined: Jet,
    /// `sum 1 / (s - pole)` over all poles.
    poles: C,
}

/// The translations' part of the determinant `R11 R22 - R12^2` without their common factor `1 / s^2`.
/// By Cauchy and Binet it consists of squared minors `(phi_{1,i} phi_{2,j} - phi_{2,i} phi_{1,j})^2`.
/// Without this, a stiff contact between heavy bodies on soft rock would cost ten digits.
#[derive(Default)]
struct Translations {
    modes: Vec<usize>,
    /// For each mode, the sum of its squared minors with all translations.
    minors: Vec<f64>,
    /// The sum of the squared minors of all pairs of translations.
    own: f64,
    /// `phi_a phi_b`, summed over the translations, at the index `a + b`.
    moved: [f64; 3],
}

impl Translations {
    fn new(system: &Deflated) -> Self {
        let n = system.omega2.len();
        let modes: Vec<usize> = (0..n).filter(|&i| system.omega2[i] == 0.0).collect();
        let [x, y] = &system.shapes[..] else {
            return Self { modes, ..Self::default() };
        };
        let squared = |i: usize, j: usize| {
            let minor = x[i] * y[j] - y[i] * x[j];
            minor * minor
        };
        let sum = |i: usize| modes.iter().map(|&a| squared(a, i)).sum::<f64>();
        let minors: Vec<f64> = (0..n).map(sum).collect();
        let own = 0.5 * modes.iter().map(|&a| minors[a]).sum::<f64>();
        let moved = |a: &[f64], b: &[f64]| modes.iter().map(|&i| a[i] * b[i]).sum();
        let moved = [moved(x, x), moved(x, y), moved(y, y)];
        Self { modes, minors, own, moved }
    }
}

/// True if the determinant is expanded: for more than two attachments, and for two at one node, which have equal
/// amplitudes in every mode that moves both.
fn is_expanded(system: &Deflated) -> bool {
    let [x, y] = &system.shapes[..] else { return system.shapes.len() > 2 };
    let modes = x.iter().zip(y).zip(&system.omega2);
    let mut common = modes.filter(|((x, y), w2)| **w2 > 0.0 && **x != 0.0 && **y != 0.0);
    common.clone().count() > 1 && common.all(|((x, y), _)| x == y)
}

/// The two roots of `s^2 + beta w2 s + w2`.
fn free_poles(omega2: f64, beta: f64) -> [C; 2] {
    let mean = -0.5 * beta * omega2;
    let discriminant = omega2 - mean * mean;
    if discriminant >= 0.0 {
        let w = discriminant.sqrt();
        [C::new(mean, w), C::new(mean, -w)]
    } else {
        let fast = mean - (-discriminant).sqrt();
        [C::new(omega2 / fast, 0.0), C::new(fast, 0.0)]
    }
}

/// If `beta w` of a mode is above this, its slow pole is within 7 % of `-1 / beta` and belongs to the crowd there.
pub(crate) const CROWDED: f64 = 4.0;

/// The secular function of a deflated structure.
pub(crate) struct Secular {
    /// The deflated structure.
    pub(crate) system: Deflated,
    /// The poles: `poles[2 i]` and `poles[2 i + 1]` are those of mode `i`.
    pub(crate) poles: Vec<C>,
    /// The poles minus `origin`.
    pub(crate) sites: Vec<C>,
    /// The point from which poles are measured: 0 or `-1 / beta`, 1/s.
    pub(crate) origin: f64,
    /// The poles with their weights in the receptances.
    pub(crate) pairs: Pairs,
    /// A copy of `pairs`. While a matrix is made, the modes that dominate are taken out of it.
    pub(crate) others: RefCell<Pairs>,
    /// True for three or four attachments, and for two at one node, whose minors cancel.
    pub(crate) expanded: bool,
    translations: Translations,
}

impl Secular {
    pub(crate) fn new(system: Deflated) -> Self {
        let modes = system.omega2.iter();
        let poles: Vec<C> = modes.flat_map(|&w2| free_poles(w2, system.beta)).collect();
        let sites = poles.clone();
        Self::over(system, poles, sites, 0.0)
    }

    /// True if at least two poles crowd at `-1 / beta`.
    pub(crate) fn is_crowded(&self) -> bool {
        let is_slow = |omega2: &&f64| self.system.beta * omega2.sqrt() > CROWDED;
        self.system.omega2.iter().filter(is_slow).count() > 1
    }

    /// The same function, with poles measured from `-1 / beta`.
    pub(crate) fn measured_from_crowd(self) -> Self {
        let (beta, poles) = (self.system.beta, self.poles);
        let origin = -1.0 / beta;
        let site = |(k, &pole): (usize, &C)| {
            let omega2 = self.system.omega2[k / 2];
            let is_slow = k % 2 == 0 && beta * omega2.sqrt() > 2.0;
            if is_slow { -pole * pole / (beta * omega2) } else { pole - origin }
        };
        let sites = poles.iter().enumerate().map(site).collect();
        Self::over(self.system, poles, sites, origin)
    }

    fn over(system: Deflated, poles: Vec<C>, sites: Vec<C>, origin: f64) -> Self {
        let translations = Translations::new(&system);
        let (weights, expanded) = (WEIGHTS[system.shapes.len() - 1], is_expanded(&system));
        let mut pairs = Pairs::new(system.omega2.len(), poles::ENDS + weights);
        for (i, ends) in sites.chunks_exact(2).enumerate() {
            pairs.set(i, 0, [ends[0].re, ends[0].im, ends[1].re, ends[1].im]);
            let x = system.shapes[0][i];
            match &system.shapes[..] {
                [_] => pairs.set(i, poles::ENDS, [x * x]),
                [_, _] if !expanded && translations.modes.contains(&i) => {}
                [_, y] if !expanded => {
                    let y = y[i];
                    pairs.set(i, poles::ENDS, [x * x, x * y, y * y, translations.minors[i]]);
                }
                shapes => {
                    let used = PAIRS.into_iter().take_while(|[_, b]| *b < shapes.len());
                    for (k, [a, b]) in used.enumerate() {
                        pairs.set(i, poles::ENDS + k, [shapes[a][i] * shapes[b][i]]);
                    }
                }
            }
        }
        let others = RefCell::new(pairs.clone());
        Self { system, poles, sites, origin, pairs, others, expanded, translations }
    }

    /// The point `s` of a root.
    pub(crate) fn value(&self, root: Root) -> C {
        self.poles[root.pole] + root.offset
    }

    /// The root minus `-1 / beta`, if its pole belongs to the crowd there.
    pub(crate) fn in_crowd(&self, root: Root) -> Option<C> {
        let beta_w = self.system.beta * self.system.omega2[root.pole / 2].sqrt();
        let is_slow = self.origin != 0.0 && root.pole.is_multiple_of(2) && beta_w > CROWDED;
        is_slow.then(|| self.sites[root.pole] + root.offset)
    }

    /// The mode of a translation that only a dashpot to the ground resists. Its pole at 0 is also a simple root.
    pub(crate) fn sliding(&self) -> Option<usize> {
        self.system.sliding.as_ref()?;
        self.system.omega2.iter().position(|&omega2| omega2 == 0.0)
    }

    /// True if the root is the one at 0 of [`Self::sliding`].
    pub(crate) fn slides(&self, root: Root) -> bool {
        self.sliding().is_some_and(|mode| root.pole == 2 * mode) && root.offset == C::default()
    }

    /// `root - poles[j]`, without cancellation.
    pub(crate) fn off_pole(&self, root: Root, j: usize) -> C {
        (self.sites[root.pole] - self.sites[j]) + root.offset
    }

    /// `a - b`, without cancellation.
    pub(crate) fn difference(&self, a: Root, b: Root) -> C {
        (self.sites[a.pole] - self.sites[b.pole]) + (a.offset - b.offset)
    }

    /// The position of a root, in the form that the sums over the poles need.
    pub(crate) fn point(&self, root: Root) -> Point {
        Point { base: self.sites[root.pole], offset: root.offset }
    }

    fn receptance(&self, root: Root) -> Receptance {
        let jet = |[at, slope]: [C; 2]| Jet { at, slope };
        let at = self.point(root);
        if self.system.shapes.len() == 1 {
            let Weighed { poles, sums: [r11] } = poles::weighed(&self.pairs, at);
            return Receptance { r11: jet(r11), poles, ..Receptance::default() };
        }
        let Weighed { poles, sums } = poles::weighed(&self.pairs, at);
        let [r11, r12, r22, joined] = sums.map(jet);
        let free = if self.translations.modes.is_empty() {
            Jet::default()
        } else {
            let inverse = self.value(root).inv();
            let square = inverse * inverse;
            Jet { at: square, slope: -2.0 * square * inverse }
        };
        Receptance { r11, r12, r22, free, joined, poles }
    }

    /// `R_ab`, including the translations.
    fn whole(&self, r: &Receptance, a: usize, b: usize) -> Jet {
        let mut sum = [r.r11, r.r12, r.r22][a + b];
        sum.add(self.translations.moved[a + b], r.free);
        sum
    }

    /// `R11 R22 - R12^2`, from whichever of two sums cancels less. Between the bars' resonances each receptance is
    /// small; below the first resonance the translations dominate.
    fn determinant(&self, r: &Receptance, own: [Jet; 2]) -> Jet {
        let cross = self.whole(r, 0, 1);
        let terms = |a: usize, b: usize| {
            let vibration = size([r.r11, r.r12, r.r22][a + b].at);
            vibration + self.translations.moved[a + b].abs() * size(r.free.at)
        };
        let whole_size = size(own[0].at) * terms(1, 1)
            + size(own[1].at) * terms(0, 0)
            + 2.0 * size(cross.at) * terms(0, 1);
        let free = size(r.free.at);
        let split = size(r.r11.at * r.r22.at)
            + r.r12.at.norm_sqr()
            + free * (size(r.joined.at) + self.translations.own * free);
        if whole_size <= split {
            return own[0] * own[1] - cross * cross;
        }
        let mut det = r.r11 * r.r22 - r.r12 * r.r12;
        det.add(1.0, r.free * r.joined);
        det.add(self.translations.own, r.free * r.free);
        det
    }

    /// `kappa_a = k_a + c_a s`.
    pub(crate) fn stiff(&self, a: usize, s: C) -> Jet {
        let (k, c) = self.system.springs[a];
        Jet { at: k + c * s, slope: C::new(c, 0.0) }
    }

    /// `1 / d_i` of every mode.
    pub(crate) fn compliances(&self, root: Root) -> Vec<C> {
        let [real, imaginary] = poles::inverse_products(&self.pairs, self.point(root));
        let parts = real.iter().zip(&imaginary).take(self.system.omega2.len());
        parts.map(|(re, im)| C::new(*re, *im)).collect()
    }

    /// The secular function, its derivative, and `sum 1 / (s - pole)` over all poles.
    pub(crate) fn function(&self, root: Root) -> (C, C, C) {
        if self.expanded {
            return self.expanded_function(root);
        }
        let s = self.value(root);
        let r = self.receptance(root);
        let stiff = |a: usize| self.stiff(a, s);
        let first = stiff(0) * r.r11;
        if self.system.shapes.len() == 1 {
            return (1.0 + first.at, first.slope, r.poles);
        }
        let own = [self.whole(&r, 0, 0), self.whole(&r, 1, 1)];
        let det = self.determinant(&r, own);
        let mut f = stiff(0) * own[0];
        f.add(1.0, stiff(1) * own[1]);
        f.add(1.0, stiff(0) * stiff(1) * det);
        (1.0 + f.at, f.slope, r.poles)
    }

    /// Amplitudes of the attachments' forces in the eigenvector at `s`, from one row of the singular 2 by 2 matrix
    /// `1 + kappa R`. They are analytic in `s`.
    fn forces(&self, r: &Receptance, s: C, second: bool) -> [C; 2] {
        let kappa = |a: usize| self.system.springs[a].0 + self.system.springs[a].1 * s;
        let cross = self.whole(r, 0, 1).at;
        if second {
            [-kappa(0) * cross, 1.0 + kappa(0) * self.whole(r, 0, 0).at]
        } else {
            [1.0 + kappa(1) * self.whole(r, 1, 1).at, -kappa(1) * cross]
        }
    }

    /// True if the second row of the matrix is larger, and so gives the eigenvector at `s` more accurately.
    fn prefers_second(&self, r: &Receptance, s: C) -> bool {
        let square = |f: [C; 2]| f[0].norm_sqr() + f[1].norm_sqr();
        // The rows are compared as compliances: each is divided by its spring's stiffness.
        let spring = |i: usize| {
            let (k, c) = self.system.springs[i];
            (k + c * s).norm_sqr()
        };
        square(self.forces(r, s, true)) * spring(1) > square(self.forces(r, s, false)) * spring(0)
    }

    /// The eigenvector's amplitudes `sum_a phi_{a,i} F_a / d_i`, where `F_a` are the attachments' forces.
    fn amplitudes(&self, root: Root, forces: &[C; MAX_ORDER]) -> Vec<C> {
        let (shapes, compliances) = (&self.system.shapes, self.compliances(root));
        if !self.expanded {
            let pushes = self.pushes(root).into_iter().zip(compliances);
            return pushes.map(|(push, compliance)| push * compliance).collect();
        }
        let force = |i: usize| forces.iter().zip(shapes).map(|(f, shape)| f * shape[i]).sum::<C>();
        let products = compliances.iter().enumerate().map(|(i, compliance)| force(i) * compliance);
        let mut amplitudes: Vec<C> = products.collect();
        for (mode, own) in self.borders(root).into_iter().zip(&forces[shapes.len()..]) {
            amplitudes[mode] = *own;
        }
        amplitudes
    }

    /// `sum_a phi_{a,i} F_a` for each mode, if there is one attachment, or two whose determinant is not expanded.
    fn pushes(&self, root: Root) -> Vec<C> {
        let shapes = &self.system.shapes;
        if shapes.len() == 1 {
            return shapes[0].iter().map(|&x| C::new(x, 0.0)).collect();
        }
        let (s, r) = (self.value(root), self.receptance(root));
        let second = self.prefers_second(&r, s);
        let forces = self.forces(&r, s, second);
        let (first, other) = if second { (1, 0) } else { (0, 1) };
        let (x, y) = (&shapes[first], &shapes[other]);
        let receptance = [r.r11, r.r22][other].at;
        let kappa = self.system.springs[other].0 + self.system.springs[other].1 * s;
        // Below the bars' resonances, this is what remains of the sum when the translations cancel.
        let slow = self.translations.moved[2 * other] * size(r.free.at) > size(receptance);
        let push = |i: usize| {
            if !slow {
                return shapes[0][i] * forces[0] + shapes[1][i] * forces[1];
            }
            let minor = |&a: &usize| (x[i] * y[a] - y[i] * x[a]) * y[a];
            let moved: f64 = self.translations.modes.iter().map(minor).sum();
            x[i] + kappa * (x[i] * receptance - y[i] * r.r12.at + moved * r.free.at)
        };
        (0..self.system.omega2.len()).map(push).collect()
    }

    /// The eigenvector's amplitudes in the modes of the deflated structure, not normalised.
    pub(crate) fn vector(&self, root: Root) -> Vec<C> {
        if let Some(shape) = self.system.sliding.as_ref().filter(|_| self.slides(root)) {
            return self.system.merged(shape).into_iter().map(C::from).collect();
        }
        self.amplitudes(root, &self.row_forces(root))
    }
}
