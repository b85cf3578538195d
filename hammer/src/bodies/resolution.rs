//! The mesh that a scene needs for what is read of it, from the width of its sharpest wave front.
//!
//! Where the bodies meet, the force rises within `tau = Z/KC`, with `1/Z = 1/Zp + 1/Zb` of the
//! sections that meet, so the front is `w = c tau` wide. A rock line as stiff as the contact makes
//! one too: `w = c Zt / (gamma KR)` with the bit's last section; and a chuck, `w = c Z/ks`, with the
//! sections of bit and casing that meet. (Its viscosity makes jumps, by a part `cs / (Z + cs)` of the
//! force, which no mesh resolves at once.) At the mesh's shortest wave,
//! `k = pi/h`, the front's amplitude goes like `1 / (1 + (k w)^2)`. That part is wrong on the mesh,
//! and rings until damping, `exp(-beta (c k)^2 t / 2)`, has reduced it. The largest force comes
//! about `t = 12 tau` after the first:
//!
//! ```text
//! error = exp(-6 beta c w (pi/h)^2) / (1 + (pi w / h)^2)
//! ```
//!
//! The factor 12 is empirical, and on the safe side for splines from degree 3 on, whose dispersion
//! is far smaller (for linear elements it dominates).
//!
//! A rate needs less: it is made by all waves of a blow, and those that are as short as the front carry
//! little of its energy. On splines of degree 3 with spans of `4 w` the rate of penetration errs by less than
//! a hundredth (the tip's own gain by up to four), and with finer ones like their power of 3.6. Below a drill
//! string it is made by what comes through the couplings: the wave of a blow, twice as long as the piston,
//! for which spans of 0.22 of that are enough. These rules are empirical; `reports/mesh.md` has their errors
//! over drawn hammers and the presets.

use crate::numerics::math;
use crate::quantities::parameters::{MAX_ELEMENTS, Parameters};
use crate::quantities::sections::{Body, Segment};

/// What is read of a scene, for which its mesh is to be fine enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// Rates, periods, energies and powers of blows.
    Rate,
    /// The largest force of contact or rock, or of the chuck.
    Force,
    /// The largest stress along the bodies.
    Stress,
}

impl Reading {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rate, Self::Force, Self::Stress];

    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Force => "force",
            Self::Stress => "stress",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reading| reading.name() == name)
    }

    /// Relative error that is asked for where none is given.
    pub fn usual_error(self) -> f64 {
        match self {
            Self::Rate => 0.01,
            Self::Force | Self::Stress => 0.05,
        }
    }
}

/// A mesh for a stated error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshAdvice {
    /// Degree of the splines.
    pub degree: usize,
    /// Spans of the piston.
    pub piston: usize,
    /// Spans of the bit.
    pub bit: usize,
    /// Spans of a casing, if that has sections.
    pub casing: Option<usize>,
}

/// The chuck's largest force comes after waves have run through bit and casing, in which errors of
/// several fronts add up: as if its front were that much narrower (empirical).
const SHARPER: f64 = 0.5;
/// Below this error, the higher degree is the cheaper one.
const FINE: f64 = 1e-4;
/// Degrees above and below [`FINE`].
const DEGREES: [usize; 2] = [5, 7];
/// The degree that a rate needs, and its error on spans of this many widths of the front, which goes like
/// this power of the span (all empirical).
const RATE_DEGREE: usize = 3;
const RATE_ERROR: f64 = 0.01;
const RATE_SPAN: f64 = 4.0;
const RATE_ORDER: f64 = 3.6;
/// The same spans under a drill string, over the length of a blow's wave.
const STRING_SPAN: f64 = 0.22;
/// A body has this many spans at least, so that its longest waves are resolved whatever the front.
const LEAST_SPANS: f64 = 4.0;

impl Parameters {
    /// Width of the sharpest front that contact, rock and chuck can make in piston and bit, m.
    pub fn front_width(&self) -> f64 {
        let [piston, bit] = Body::ALL.map(|body| self.sections(body));
        let (above, below) = (piston.as_slice(), bit.as_slice());
        let [a, b, tip] = [above[above.len() - 1], below[0], below[below.len() - 1]]
            .map(|section| self.impedance_of(section.area));
        let contact = a * b / (a + b) / self.contact.stiffness;
        let rock = tip / (self.rock.unloading_ratio * self.rock.stiffness);
        let chuck = if self.has_casing() { self.chuck_front() } else { f64::INFINITY };
        (self.wave_speed() * contact.min(rock)).min(chuck)
    }

    /// Width of the front that the chuck makes in bit and casing, m.
    fn chuck_front(&self) -> f64 {
        let end = |section: &Segment| 1.0 / self.impedance_of(section.area);
        let (bit, casing) = (self.sections(Body::Bit), self.sections(Body::Casing));
        let casing_end =
            if self.casing.segments > 0 { casing.as_slice().last().map_or(0.0, end) } else { 0.0 };
        self.wave_speed() / ((end(&bit.as_slice()[0]) + casing_end) * self.chuck.stiffness)
    }

    /// Relative error of the forces at an impact on the scene's own mesh, by the formula above: that of
    /// its longest span in piston and bit.
    pub fn force_error(&self) -> f64 {
        let longest = Body::ALL.map(|body| {
            let nodes = self.sections(body).nodes(self.spans(body));
            nodes.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
        });
        self.mesh_error(longest[0].max(longest[1]))
    }

    /// Relative error of the forces at an impact, on splines with spans of this length (m), by the
    /// formula above.
    pub fn mesh_error(&self, span: f64) -> f64 {
        self.error_behind(self.front_width(), span)
    }

    /// The same behind a front of some width, m.
    fn error_behind(&self, width: f64, span: f64) -> f64 {
        let k = std::f64::consts::PI / span;
        let damping = 6.0 * self.material.damping_time * self.wave_speed() * width * k * k;
        math::exp(-damping) / (1.0 + (k * width) * (k * width))
    }

    /// Longest span of a body (m) on which fronts of some width (m) are resolved to this error; `None` if
    /// there is none.
    fn span_for(&self, body: Body, width: f64, error: f64) -> Option<f64> {
        let length = self.sections(body).length();
        let (mut fine, mut coarse) = (length / MAX_ELEMENTS as f64, length);
        if self.error_behind(width, fine) > error {
            return None;
        }
        // The error grows with the span.
        for _ in 0..60 {
            let middle = 0.5 * (fine + coarse);
            if self.error_behind(width, middle) > error { coarse = middle } else { fine = middle }
        }
        Some(fine)
    }

    /// Spans of a body that are no longer than this, m; `None` if they are more than [`MAX_ELEMENTS`].
    fn spans_of(&self, body: Body, longest: f64) -> Option<usize> {
        let sections = self.sections(body);
        let needed = sections.as_slice().iter().map(|s| (s.length / longest).ceil());
        let needed: f64 = needed.sum();
        (needed <= MAX_ELEMENTS as f64).then_some(needed as usize)
    }

    /// The mesh on which rates have a relative error of at most `error`.
    fn mesh_for_rate(&self, error: f64) -> Option<MeshAdvice> {
        let part = math::pow(error / RATE_ERROR, 1.0 / RATE_ORDER);
        let spans = |body: Body, width: f64| {
            let shortest_wave = self.sections(body).length() / LEAST_SPANS;
            let (span, keeps_shape) = match self.drill.rods {
                0 => (RATE_SPAN * width, f64::INFINITY),
                _ => (STRING_SPAN * self.blow_wave(), self.longest_string_span(RATE_DEGREE)),
            };
            self.spans_of(body, (part * span).min(shortest_wave).min(keeps_shape))
        };
        let width = self.front_width();
        let casing = match self.casing.segments {
            0 => None,
            _ => Some(spans(Body::Casing, self.chuck_front())?),
        };
        let [piston, bit] = Body::ALL.map(|body| spans(body, width));
        Some(MeshAdvice { degree: RATE_DEGREE, piston: piston?, bit: bit?, casing })
    }

    /// The mesh on which what is read has a relative error of at most `error`. In an elastic casing the
    /// chuck makes the front. `None` if a body would need more than [`MAX_ELEMENTS`] spans because
    /// contact, rock, chuck and damping make too sharp a front.
    ///
    /// ```
    /// use hammer::{Parameters, Reading};
    ///
    /// let mesh = Parameters::default().mesh_for(Reading::Rate, 0.01).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.piston, mesh.casing), (3, 16, None));
    /// let mesh = Parameters::default().mesh_for(Reading::Force, 1e-3).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.piston, mesh.casing), (5, 83, None));
    /// ```
    pub fn mesh_for(&self, reading: Reading, error: f64) -> Option<MeshAdvice> {
        if reading == Reading::Rate {
            return self.mesh_for_rate(error);
        }
        let width = self.front_width();
        let spans =
            |body: Body, width: f64| self.spans_of(body, self.span_for(body, width, error)?);
        let casing = match self.casing.segments {
            0 => None,
            _ => Some(spans(Body::Casing, SHARPER * self.chuck_front())?),
        };
        let [piston, bit] = Body::ALL.map(|body| spans(body, width));
        let degree = DEGREES[usize::from(error < FINE)];
        Some(MeshAdvice { degree, piston: piston?, bit: bit?, casing })
    }
}
