//! Chooses the mesh that a scene needs for given outputs, from the width of the sharpest wave front.
//!
//! Where piston and bit meet, the force rises within `tau = Z/KC`, so the front is `w = c tau` wide. Here `1/Z = 1/Zp +
//! 1/Zb`, with the impedances of the sections that meet. A rock that unloads as stiffly as the contact also makes a
//! front, of the width `w = c Zt / (gamma KR)` with the impedance `Zt` of the bit's last section. A chuck makes one of
//! the width `w = c Z/ks`, with the impedances of the sections of bit and casing that meet. (The chuck's viscosity
//! makes jumps of the force, of the share `cs / (Z + cs)`, which no mesh resolves at once.)
//!
//! At the mesh's shortest wave, `k = pi/h`, the front's amplitude is about `1 / (1 + (k w)^2)`. This part is wrong on
//! the mesh, and rings until damping, `exp(-beta (c k)^2 t / 2)`, has reduced it. The largest force comes about `t = 12
//! tau` after the first contact, so that
//!
//! ```text
//! error = exp(-6 beta c w (pi/h)^2) / (1 + (pi w / h)^2)
//! ```
//!
//! The factor 12 is empirical. It is on the safe side for splines of degree 3 and more, whose dispersion is small.
//! For linear elements dispersion dominates.
//!
//! For a rate, a coarser mesh suffices: all waves of a blow contribute to it, and those as short as the front carry
//! little energy. On splines of degree 3 with spans of `4 w` the error of the rate of penetration is below 1 %, and
//! falls with the power 3.6 of the spans. (The error of the tip's own advance is up to 4 %.) Below a drill string the
//! rate depends on how much of the blow's wave passes the couplings. That wave is twice as long as the piston, and
//! spans of 0.22 of its length are short enough. These rules are empirical. The tests of `resolution` check their
//! errors over randomly drawn hammers.

use crate::numerics::math;
use crate::quantities::parameters::{MAX_ELEMENTS, Parameters};
use crate::quantities::sections::Body;

/// The kind of output that is read. It decides how fine the mesh must be.
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
    /// All readings.
    pub const ALL: [Self; 3] = [Self::Rate, Self::Force, Self::Stress];

    /// The reading's name, one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Force => "force",
            Self::Stress => "stress",
        }
    }

    /// The reading with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reading| reading.name() == name)
    }

    /// Default of the relative error that the mesh must keep.
    pub fn usual_error(self) -> f64 {
        match self {
            Self::Rate => 0.01,
            Self::Force | Self::Stress => 0.05,
        }
    }
}

/// A mesh for a stated error.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MeshAdvice {
    /// Degree of the splines.
    pub degree: usize,
    /// Spans of each body that has sections.
    pub spans: Vec<(Body, usize)>,
}

impl MeshAdvice {
    /// Number of spans of a body.
    pub fn of(&self, body: Body) -> Option<usize> {
        self.spans.iter().find(|(other, _)| *other == body).map(|(_, spans)| *spans)
    }

    /// Sets this mesh in a scene's parameters.
    pub fn apply(&self, parameters: &mut Parameters) {
        parameters.mesh.degree = self.degree;
        self.spans.iter().for_each(|(body, spans)| *parameters.elements_mut(*body) = *spans);
    }
}

/// With a casing, the largest force comes after waves have passed through casing and bit, and the errors of several
/// fronts add up. This empirical factor therefore narrows the front.
const SHARPER: f64 = 0.5;
/// For errors below this, the higher degree costs less.
const FINE: f64 = 1e-4;
/// Degree of the splines for errors above and below [`FINE`].
const DEGREES: [usize; 2] = [5, 7];
/// For rates: the degree of the splines, and the empirical law of the error. It is `RATE_ERROR` on spans of `RATE_SPAN`
/// widths of the front, and falls with the power `RATE_ORDER` of the span.
const RATE_DEGREE: usize = 3;
const RATE_ERROR: f64 = 0.01;
const RATE_SPAN: f64 = 4.0;
const RATE_ORDER: f64 = 3.6;
/// For rates under a drill string: the longest span, as a share of the length of a blow's wave.
const STRING_SPAN: f64 = 0.22;
/// Least number of spans of a body. They resolve its longest waves, whatever the front's width.
const LEAST_SPANS: f64 = 4.0;

impl Parameters {
    /// Width of the sharpest wave front that ties and rock can make in piston and bit, m.
    pub fn front_width(&self) -> f64 {
        let [piston, bit] = Body::ALL.map(|body| self.sections(body));
        let (above, below) = (piston.as_slice(), bit.as_slice());
        let [a, b, tip] = [above[above.len() - 1], below[0], below[below.len() - 1]]
            .map(|section| self.impedance_of(section.area));
        let contact = a * b / (a + b) / self.contact.stiffness;
        let rock = tip / self.rock.unloading_stiffness();
        (self.wave_speed() * contact.min(rock)).min(self.frame_front())
    }

    /// Relative error of the forces at an impact on the scene's own mesh, by this module's formula for the longest span
    /// of piston and bit.
    pub fn force_error(&self) -> f64 {
        self.error_behind(self.front_width(), self.longest_span())
    }

    /// Relative error of a rate on the scene's own mesh, by this module's law for the longest span of piston and bit;
    /// `None` for linear and quadratic elements, whose dispersion the law leaves out.
    pub fn rate_error(&self) -> Option<f64> {
        let share = self.longest_span() / self.rate_span(self.front_width());
        (self.mesh.degree >= RATE_DEGREE).then(|| RATE_ERROR * math::pow(share, RATE_ORDER))
    }

    /// Longest span of piston and bit, m.
    fn longest_span(&self) -> f64 {
        let longest = Body::ALL.map(|body| {
            let nodes = self.sections(body).nodes(self.spans(body));
            nodes.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
        });
        longest[0].max(longest[1])
    }

    /// The span with which the error of rates is [`RATE_ERROR`], m, for fronts of this width (m).
    fn rate_span(&self, width: f64) -> f64 {
        if self.drill.rods == 0 { RATE_SPAN * width } else { STRING_SPAN * self.blow_wave() }
    }

    /// Relative error of the forces behind a front of this width (m), on splines with spans of this length (m).
    fn error_behind(&self, width: f64, span: f64) -> f64 {
        let k = std::f64::consts::PI / span;
        let damping = 6.0 * self.material.damping_time * self.wave_speed() * width * k * k;
        math::exp(-damping) / (1.0 + (k * width) * (k * width))
    }

    /// Longest span of a body (m) with which fronts of this width (m) are resolved to this error; `None` if even the
    /// shortest span is too long.
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

    /// Least number of spans with which no span of a body is longer than `longest`, m; `None` if it is above
    /// [`MAX_ELEMENTS`].
    fn spans_of(&self, body: Body, longest: f64) -> Option<usize> {
        let sections = self.sections(body);
        let needed = sections.as_slice().iter().map(|s| (s.length / longest).ceil());
        let needed: f64 = needed.sum();
        (needed <= MAX_ELEMENTS as f64).then_some(needed as usize)
    }

    /// The mesh on which rates have a relative error of at most `error`.
    fn mesh_for_rate(&self, error: f64) -> Option<MeshAdvice> {
        let factor = math::pow(error / RATE_ERROR, 1.0 / RATE_ORDER);
        let spans = |body: Body, width: f64| {
            let shortest_wave = self.sections(body).length() / LEAST_SPANS;
            let keeps_shape = match self.drill.rods {
                0 => f64::INFINITY,
                _ => self.longest_string_span(RATE_DEGREE),
            };
            self.spans_of(
                body,
                (factor * self.rate_span(width)).min(shortest_wave).min(keeps_shape),
            )
        };
        self.mesh_of(RATE_DEGREE, 1.0, spans)
    }

    /// A mesh of this degree. `spans` returns a body's number of spans for the width of the wave front in it; in the
    /// casing that is the front which its own tie causes, times `factor`.
    fn mesh_of(
        &self,
        degree: usize,
        factor: f64,
        spans: impl Fn(Body, f64) -> Option<usize>,
    ) -> Option<MeshAdvice> {
        let [width, frame_width] = [self.front_width(), factor * self.frame_front()];
        let body_spans = |body: Body| {
            let width = if Body::ALL.contains(&body) { width } else { frame_width };
            Some((body, spans(body, width)?))
        };
        let meshed = self.bodies().filter(|body| !self.is_lumped(*body));
        Some(MeshAdvice { degree, spans: meshed.map(body_spans).collect::<Option<_>>()? })
    }

    /// The mesh on which outputs of this kind have a relative error of at most `error`.
    /// It is `None` if a body would need more than [`MAX_ELEMENTS`] spans because ties, rock and damping make too sharp
    /// a front.
    /// In an elastic casing, the front is the one that its own tie makes.
    ///
    /// ```
    /// use hammer::{Body, Parameters, Reading};
    ///
    /// let mesh = Parameters::default().mesh_for(Reading::Rate, 0.01).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.of(Body::Piston)), (3, Some(16)));
    /// let mesh = Parameters::default().mesh_for(Reading::Force, 1e-3).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.of(Body::Piston)), (5, Some(83)));
    /// ```
    pub fn mesh_for(&self, reading: Reading, error: f64) -> Option<MeshAdvice> {
        if reading == Reading::Rate {
            return self.mesh_for_rate(error);
        }
        let spans =
            |body: Body, width: f64| self.spans_of(body, self.span_for(body, width, error)?);
        self.mesh_of(DEGREES[usize::from(error < FINE)], SHARPER, spans)
    }
}
