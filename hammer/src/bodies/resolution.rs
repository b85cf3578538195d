//! The mesh that a scene needs, from the width of its sharpest wave front.
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

use crate::numerics::math;
use crate::quantities::parameters::{MAX_ELEMENTS, Parameters};
use crate::quantities::sections::{Body, Segment};

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
        let own =
            if self.casing.segments > 0 { casing.as_slice().last().map_or(0.0, end) } else { 0.0 };
        self.wave_speed() / ((end(&bit.as_slice()[0]) + own) * self.chuck.stiffness)
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

    /// Spans of a body on which fronts of some width (m) are resolved to this error; `None` if it would
    /// need more than [`MAX_ELEMENTS`].
    fn spans_for(&self, body: Body, width: f64, error: f64) -> Option<usize> {
        let sections = self.sections(body);
        let (mut fine, mut coarse) = (sections.length() / MAX_ELEMENTS as f64, sections.length());
        if self.error_behind(width, fine) > error {
            return None;
        }
        // The error grows with the span.
        for _ in 0..60 {
            let middle = 0.5 * (fine + coarse);
            if self.error_behind(width, middle) > error { coarse = middle } else { fine = middle }
        }
        let needed = sections.as_slice().iter().map(|s| (s.length / fine).ceil() as usize);
        Some(needed.sum::<usize>()).filter(|spans| *spans <= MAX_ELEMENTS)
    }

    /// The mesh on which forces at an impact have a relative error of at most `error`; periods and
    /// rates are more accurate. In an elastic casing the chuck makes the front. `None` if a body would
    /// need more than [`MAX_ELEMENTS`] spans because contact, rock, chuck and damping make too sharp a
    /// front.
    ///
    /// ```
    /// let mesh = hammer::Parameters::default().mesh_for(1e-3).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.piston, mesh.casing), (5, 83, None));
    /// ```
    pub fn mesh_for(&self, error: f64) -> Option<MeshAdvice> {
        let width = self.front_width();
        let casing = match self.casing.segments {
            0 => None,
            _ => Some(self.spans_for(Body::Casing, SHARPER * self.chuck_front(), error)?),
        };
        let [piston, bit] = Body::ALL.map(|body| self.spans_for(body, width, error));
        let degree = DEGREES[usize::from(error < FINE)];
        Some(MeshAdvice { degree, piston: piston?, bit: bit?, casing })
    }
}
