//! The mesh that a scene needs, from the width of its sharpest wave front.
//!
//! Where the bodies meet, the force rises within `tau = Z/KC`, with `1/Z = 1/Zp + 1/Zb` of the
//! sections that meet, so the front is `w = c tau` wide. A rock line as stiff as the contact makes
//! one too: `w = c Zt / (gamma KR)` with the bit's last section. At the mesh's shortest wave,
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
use crate::quantities::sections::Body;
use crate::quantities::parameters::{MAX_ELEMENTS, Parameters};

/// A mesh for a stated error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshAdvice {
    /// Degree of the splines.
    pub degree: usize,
    /// Spans of the piston.
    pub piston: usize,
    /// Spans of the bit.
    pub bit: usize,
}

/// Below this error, the higher degree is the cheaper one.
const FINE: f64 = 1e-4;
/// Degrees above and below [`FINE`].
const DEGREES: [usize; 2] = [5, 7];

impl Parameters {
    /// Width of the sharpest front that contact and rock can make, m.
    pub fn front_width(&self) -> f64 {
        let [piston, bit] = Body::ALL.map(|body| self.sections(body));
        let (above, below) = (piston.as_slice(), bit.as_slice());
        let [a, b, tip] = [above[above.len() - 1], below[0], below[below.len() - 1]]
            .map(|section| self.impedance_of(section.area));
        let contact = a * b / (a + b) / self.contact.stiffness;
        let rock = tip / (self.rock.unloading_ratio * self.rock.stiffness);
        self.wave_speed() * contact.min(rock)
    }

    /// Relative error of the forces at an impact, on splines with spans of this length (m), by the
    /// formula above.
    pub fn mesh_error(&self, span: f64) -> f64 {
        let (width, k) = (self.front_width(), std::f64::consts::PI / span);
        let damping = 6.0 * self.material.damping_time * self.wave_speed() * width * k * k;
        math::exp(-damping) / (1.0 + (k * width) * (k * width))
    }

    /// The mesh on which forces at an impact have a relative error of at most `error`; periods and
    /// rates are more accurate. `None` if a body would need more than [`MAX_ELEMENTS`] spans
    /// because contact, rock and damping make too sharp a front.
    ///
    /// ```
    /// let mesh = hammer::Parameters::default().mesh_for(1e-3).expect("a mesh");
    /// assert_eq!((mesh.degree, mesh.piston), (5, 83));
    /// ```
    pub fn mesh_for(&self, error: f64) -> Option<MeshAdvice> {
        let shortest = |body: Body| self.sections(body).length() / MAX_ELEMENTS as f64;
        let mut fine = shortest(Body::Piston).min(shortest(Body::Bit));
        let mut coarse = self.sections(Body::Piston).length() + self.sections(Body::Bit).length();
        if self.mesh_error(fine) > error {
            return None;
        }
        // The error grows with the span.
        for _ in 0..60 {
            let middle = 0.5 * (fine + coarse);
            if self.mesh_error(middle) > error { coarse = middle } else { fine = middle }
        }
        let spans = |body: Body| {
            let sections = self.sections(body);
            let needed = sections.as_slice().iter().map(|s| (s.length / fine).ceil() as usize);
            Some(needed.sum::<usize>()).filter(|spans| *spans <= MAX_ELEMENTS)
        };
        let degree = DEGREES[usize::from(error < FINE)];
        Some(MeshAdvice { degree, piston: spans(Body::Piston)?, bit: spans(Body::Bit)? })
    }
}
