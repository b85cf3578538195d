//! Where a force is largest along a leg, and how high that is with a parameter changed.
//!
//! At a maximum within a stretch a shift of its instant costs nothing: the derivative of a peak is
//! that of the force at a fixed time. Where a stretch's end cuts a force off (the dashpot's at the
//! barrier or at a touch), the end's own shift counts.

use crate::laws::event::Displacement;
use crate::laws::rock::Spring;
use crate::modal::model::{Model, Span};
use crate::modal::stretch::PANEL;
use crate::modal::system::{Functional, System, TAYLOR};
use crate::numerics::kernel;
use crate::numerics::math;
use crate::numerics::poly::Poly;
use crate::tangent::change::Change;
use crate::tangent::leg::{Leg, Run};
use crate::tangent::line::Line;
use crate::tangent::response::still;
use crate::tangent::viscous::{powers, series};
use serde::{Deserialize, Serialize};

/// Panels of a leg that are looked at, times the length of the modal vector: as the engine's own
/// search, which then gives up too.
const BUDGET: usize = 50_000_000;
/// Looks at a panel: 16 in two radians of the fastest motion.
const LOOKS: usize = 16;
/// Newton's steps from the best look.
const STEPS: usize = 8;

/// The largest force of a step so far, and its derivatives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Summit {
    /// N.
    pub value: f64,
    /// A line each.
    pub slopes: Vec<f64>,
    /// The force's rate, if it is cut off by the event that ends the leg.
    pub cut: Option<f64>,
}

/// A force `k u + c u'` on a leg.
pub(crate) struct Force<'a> {
    pub run: &'a Run,
    displacement: Displacement,
    functional: usize,
    stiffness: f64,
    viscosity: f64,
    poly: Poly,
}

/// A maximum.
pub(crate) struct Top {
    /// From the start of the leg, s.
    pub at: f64,
    pub value: f64,
    /// Rate of the force there, N/s.
    pub rate: f64,
    /// Displacement and its rate there.
    u: [f64; 2],
    /// The oscillation there.
    pub z: Vec<f64>,
}

/// Contact and rock force of a leg, those that act.
pub(crate) fn forces<'a>(model: &Model, leg: &'a Leg) -> [Option<Force<'a>>; 2] {
    let Some(run) = leg.runs.first() else { return [None, None] };
    let force = |displacement, stiffness: f64, viscosity| {
        let functional = run.span.share(displacement).filter(|_| stiffness != 0.0)?;
        let poly = still(&run.system.functionals[functional], &leg.loads);
        Some(Force { run, displacement, functional, stiffness, viscosity, poly })
    };
    let line = Spring::of(leg.mode.rock).coefficients(&model.parameters.rock);
    let contact = force(Displacement::Gap, -model.contact, 0.0);
    let closed = matches!(run.span, Span::Both(_));
    [contact.filter(|_| closed), force(Displacement::Tip, line.stiffness, line.viscosity)]
}

impl Force<'_> {
    fn functional(&self) -> &Functional {
        &self.run.system.functionals[self.functional]
    }

    /// Where it is largest from `from` on, if that is more than `best`.
    pub(crate) fn top(&self, from: f64, span: f64, mut best: f64) -> Option<Top> {
        let system: &System = &self.run.system;
        let mut z = self.run.start.clone();
        system.rotate(from, &mut z);
        let mut powers_of = vec![vec![0.0; z.len()]; TAYLOR];
        let (mut t, mut found) = (from, None);
        for _ in 0..(BUDGET / z.len().max(1)).max(1) {
            if self.ceiling(&z, t, span) <= best {
                break;
            }
            let h = (PANEL / system.rate_max).min(span - t);
            powers(system, &mut z, h, &mut powers_of);
            let u = series(&powers_of, &self.functional().rows[0], &self.poly, t, h);
            let force: [f64; TAYLOR] = std::array::from_fn(|k| {
                let rate = u.get(k + 1).map_or(0.0, |c| (k + 1) as f64 * c / h);
                self.stiffness * u[k] + self.viscosity * rate
            });
            let s = highest(&force);
            let [value, rate, _] = rates(&force, s);
            if value > best {
                best = value;
                let [x, v, _] = rates(&u, s);
                found = Some((t + s * h, value, rate / h, [x, v / h]));
            }
            t += h;
            if t >= span {
                break;
            }
        }
        let (at, value, rate, u) = found?;
        let mut z = self.run.start.clone();
        system.rotate(at, &mut z);
        Some(Top { at, value, rate, u, z })
    }

    /// Bound on the force from `t` on.
    fn ceiling(&self, z: &[f64], t: f64, end: f64) -> f64 {
        let f = self.functional();
        let (rate, span) = (self.poly.derivative().shifted(t), end - t);
        let terms = rate.0.iter().enumerate();
        let drift: f64 = terms.map(|(k, c)| c.abs() * math::powi(span, k)).sum();
        self.stiffness * self.poly.at(t)
            + self.stiffness.abs() * (drift * span + kernel::bound(&f.weights[0], z))
            + self.viscosity * (drift + kernel::bound(&f.weights[1], z))
    }

    /// Its derivative at a top that a line stands at.
    pub(crate) fn slope(&self, top: &Top, line: &Line, change: &Change, model: &Model) -> f64 {
        let ([x, v], changes) = match self.displacement {
            Displacement::Gap => (line.gap(model), [-change.contact, 0.0]),
            // The spring's own changes.
            _ => (line.tip(model), change.springs[self.spring() as usize]),
        };
        self.stiffness * x + self.viscosity * v + changes[0] * top.u[0] + changes[1] * top.u[1]
    }

    fn spring(&self) -> Spring {
        match self.run.span {
            Span::Bit(spring) | Span::Both(spring) => spring,
            Span::Piston => Spring::Free,
        }
    }
}

/// A polynomial on `[0, 1]`, and its two derivatives.
fn rates(p: &[f64; TAYLOR], s: f64) -> [f64; 3] {
    p.iter().rev().fold([0.0; 3], |[a, b, c], x| [a * s + x, b * s + a, c * s + 2.0 * b])
}

/// Where a polynomial is largest on `[0, 1]`: from the best look by Newton's method.
fn highest(p: &[f64; TAYLOR]) -> f64 {
    let looks = (0..=LOOKS).map(|k| k as f64 / LOOKS as f64);
    let best = looks.fold((0.0, f64::NEG_INFINITY), |best, s| {
        let [value, ..] = rates(p, s);
        if value > best.1 { (s, value) } else { best }
    });
    let (low, high) = ((best.0 - 1.0 / LOOKS as f64).max(0.0), best.0 + 1.0 / LOOKS as f64);
    let mut s = best.0;
    for _ in 0..STEPS {
        let [_, slope, curve] = rates(p, s);
        if curve >= 0.0 {
            break;
        }
        s = (s - slope / curve).clamp(low, high.min(1.0));
    }
    if rates(p, s)[0] >= best.1 { s } else { best.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taylor polynomials of known functions: the place is where the slope vanishes, to the root
    /// of rounding at worst; at a rising end it is the end.
    #[test]
    fn a_polynomial_is_largest_where_its_slope_vanishes_or_at_an_end() {
        let mut term = 1.0;
        // sin(2 s): largest at pi / 4.
        let sine: [f64; TAYLOR] = std::array::from_fn(|k| {
            let c = [0.0, 1.0, 0.0, -1.0][k % 4] * term;
            term *= 2.0 / (k + 1) as f64;
            c
        });
        assert!((highest(&sine) - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        let mut line = [0.0; TAYLOR];
        line[1] = 3.0;
        assert_eq!(highest(&line), 1.0);
        line[1] = -3.0;
        assert_eq!(highest(&line), 0.0);
    }
}
