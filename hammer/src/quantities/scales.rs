//! Quantities derived from the parameters: wave speed, impedance, masses, meshes, timescales and resolutions.

use crate::quantities::parameters::{Parameters, Source};
use crate::quantities::sections::{Body, Sections, Segment};

/// Resolution of displacement guards, as a share of the [travel](Parameters::travel).
const RESOLUTION: f64 = 2e-13;

/// The six timescales of the paper's equation (6), s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Timescales {
    /// Time in which a wave crosses the piston: its length over `c0`.
    pub piston_transit: f64,
    /// Time in which a wave crosses the bit: its length over `c0`.
    pub bit_transit: f64,
    /// Pressure cycle, `sqrt(Mp D1/F0)`.
    pub pressure: f64,
    /// Bit on rock, `sqrt(Mb/KR)`.
    pub drilling: f64,
    /// Energy barrier, `WR/(F0 D1) Mp/CR`.
    pub barrier: f64,
    /// Penalty contact, `sqrt(Mp/KC)`.
    pub contact: f64,
}

impl Parameters {
    /// Wave speed `c0 = sqrt(E/rho)`, m/s.
    pub fn wave_speed(&self) -> f64 {
        (self.material.youngs_modulus / self.material.density).sqrt()
    }

    /// Impedance `Z = A sqrt(E rho)` of a section of this area (m2), N s/m.
    pub fn impedance_of(&self, area: f64) -> f64 {
        area * (self.material.youngs_modulus * self.material.density).sqrt()
    }

    /// The sections of a body. A body without given sections is one section of `length` and `cross_section`. If there
    /// are rods, the bit's sections are below those of the drill string. The result is meaningless for a body that is a
    /// point mass.
    pub fn sections(&self, body: Body) -> Sections {
        let (length, _, own) = self.own(body);
        let uniform = [Segment { length, area: self.cross_section }];
        let listed = if own.is_empty() { &uniform[..] } else { own };
        let string = (body == Body::Bit).then(|| self.drill.sections().map(|(_, section)| section));
        let (last, above) = (listed[listed.len() - 1], listed[..listed.len() - 1].iter().copied());
        Sections::ending(string.into_iter().flatten().chain(above), last)
    }

    /// Stiffness `E A d / h` of the mesh at the contact, N/m: the larger one of piston and bit.
    /// The mesh has the degree `d` and spans of length `h`; for splines `h / d` is the distance between neighbouring
    /// coefficients.
    pub fn mesh_stiffness(&self) -> f64 {
        Body::ALL.map(|body| self.end_stiffness(body)).into_iter().fold(0.0, f64::max)
    }

    /// The stiffness `E A d / h` of one body's mesh, N/m: at the upper end of the bit, at the lower end of any other
    /// body. It is infinite for a point mass.
    pub(crate) fn end_stiffness(&self, body: Body) -> f64 {
        if self.is_lumped(body) {
            return f64::INFINITY;
        }
        let sections = self.sections(body);
        let (list, spans) = (sections.as_slice(), sections.spans(self.spans(body)));
        let section = if body == Body::Bit { 0 } else { list.len() - 1 };
        let area_over_span = list[section].area * (spans[section] as f64 / list[section].length);
        self.material.youngs_modulus * area_over_span * self.mesh.degree as f64
    }

    /// Number of spans of a body's mesh: its elements, but at least one for each section.
    pub fn spans(&self, body: Body) -> usize {
        self.own(body).1.max(self.sections(body).as_slice().len())
    }

    /// Piston mass: `rho A Lp`, or the sum over its sections, kg.
    pub fn piston_mass(&self) -> f64 {
        self.mass(Body::Piston)
    }

    /// Bit mass: `rho A Lb`, or the sum over its sections, kg.
    pub fn bit_mass(&self) -> f64 {
        self.mass(Body::Bit)
    }

    /// Mass of all bodies, kg.
    pub fn total_mass(&self) -> f64 {
        self.bodies().map(|body| self.mass(body)).sum()
    }

    /// Work that is needed for a metre of hole, `E_v pi D^2 / 4`, J/m.
    pub(crate) fn work_per_length(&self) -> f64 {
        let area = 0.25 * std::f64::consts::PI * self.hole.diameter * self.hole.diameter;
        self.rock.specific_energy * area
    }

    /// The length scale of the motion, m. It is the longest of
    /// * the initial gap `g0`;
    /// * the stroke `D1` of a relay, or the distance of an air hammer's furthest port;
    /// * the distance that the piston travels at its initial velocity while waves cross both bodies;
    /// * the penetration of the rock under the bodies' weight.
    ///
    /// If all of these are zero, it is the piston's length.
    pub fn travel(&self) -> f64 {
        let stroke = match self.drive.source {
            Source::Relay => self.drive.stroke,
            Source::Air => self.air.furthest(),
            Source::Force | Source::Pressure => 0.0,
        };
        let flight = self.piston.initial_velocity.abs() * self.transits();
        let weight = self.gravity.abs() * self.total_mass();
        let rest = weight / self.rock.stiffness;
        let travel = self.contact.initial_gap.max(stroke).max(flight).max(rest);
        if travel > 0.0 { travel } else { self.sections(Body::Piston).length() }
    }

    /// Time `T1 + T2` in which a wave crosses piston and bit, s.
    fn transits(&self) -> f64 {
        let length = |body| self.sections(body).length();
        (length(Body::Piston) + length(Body::Bit)) / self.wave_speed()
    }

    /// Time in which a wave crosses the piston and what it strikes (the shank of a drill string, or the bit), s.
    pub(crate) fn struck_transits(&self) -> f64 {
        let struck = match self.drill.rods {
            0 => self.sections(Body::Bit).length(),
            _ => self.drill.shank.length,
        };
        self.sections(Body::Piston).length() / self.wave_speed() + struck / self.wave_speed()
    }

    /// Resolutions of guards: a displacement (m) and a velocity (m/s). A guard has crossed its level once it is beyond
    /// it by its resolution. The first is a share of the [travel](Self::travel). The second is the speed of an
    /// oscillation with the first as its amplitude, at the frequency `2 pi / (T1 + T2)` of the bodies' lowest waves. So
    /// the resolutions scale with the scene's length (to the last binary digit) and time. The reference hammer has
    /// 1e-14 m and 1e-9 m/s.
    pub fn resolutions(&self) -> [f64; 2] {
        let displacement = RESOLUTION * self.travel();
        [displacement, displacement * std::f64::consts::TAU / self.transits()]
    }

    /// The timescales of the paper's equation (6).
    pub fn timescales(&self) -> Timescales {
        let (mp, mb) = (self.piston_mass(), self.bit_mass());
        let (drive, rock) = (&self.drive, &self.rock);
        Timescales {
            piston_transit: self.sections(Body::Piston).length() / self.wave_speed(),
            bit_transit: self.sections(Body::Bit).length() / self.wave_speed(),
            pressure: (mp * drive.stroke / drive.amplitude).sqrt(),
            drilling: (mb / rock.stiffness).sqrt(),
            barrier: rock.energy_barrier / (drive.amplitude * drive.stroke) * mp / rock.viscosity,
            contact: (mp / self.contact.stiffness).sqrt(),
        }
    }
}
