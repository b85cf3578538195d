//! The parameters of a scene, with their defaults.
//!
//! All defaults are written here and nowhere else. They describe the reference hammer in soft rock: a piston of 3.4 kg,
//! bars of 26 cm2, about 200 J per blow at 22 Hz. All numbers are in SI units.

use crate::quantities::air::{ATMOSPHERE, AirLaw};
pub use crate::quantities::drill::{Drill, Joint};
use crate::quantities::sections::{Body, Segment, Segments};
use serde::{Deserialize, Serialize};

/// How the bodies are modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fidelity {
    /// One unknown per body. The contact stiffness makes a collision last as long as it would with waves.
    Rigid,
    /// Bars with consistent mass, discretised by linear elements or splines.
    Elastic,
}

/// Source of the force on the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// `F_A = alpha F0`; the piston's relative mean position switches `alpha` between +1 and -1.
    Relay,
    /// `F_A` is the input `drive_force`.
    Force,
    /// `F_A = p_drive A_drive - p_return A_return`, where the two pressures are inputs.
    Pressure,
    /// As `Pressure`, but air that flows through ports sets the two pressures.
    Air,
}

impl Fidelity {
    /// Both, in the order of their values.
    pub const ALL: [Self; 2] = [Self::Rigid, Self::Elastic];
}

impl Source {
    /// All of them, in the order of their values.
    pub const ALL: [Self; 4] = [Self::Relay, Self::Force, Self::Pressure, Self::Air];

    /// True if the piston's position switches the force.
    pub(crate) fn switches(self) -> bool {
        matches!(self, Self::Relay | Self::Air)
    }
}

/// How a bit moves if it turns downward again in loaded rock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reloading {
    /// A new loading line begins at the point where the bit turns downward.
    Loading,
    /// The bit moves down along the unloading line, back to the point at which it had turned upward.
    Unloading,
}

impl Reloading {
    /// Both, in the order of their values.
    pub const ALL: [Self; 2] = [Self::Loading, Self::Unloading];
}

/// The bars' material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus `E`, Pa.
    pub youngs_modulus: f64,
    /// Density `rho`, kg/m3.
    pub density: f64,
    /// Kelvin-Voigt damping time `beta`, s: `C = beta K`.
    pub damping_time: f64,
}

/// The piston.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piston {
    /// Length `Lp` of a uniform piston, m.
    pub length: f64,
    /// Number of elements `np`: spans of the mesh over the whole body.
    pub elements: usize,
    /// Its sections; if there are none, it is uniform, of `length` and `cross_section`.
    pub segments: Segments,
    /// Uniform velocity at the start, m/s, positive downward.
    pub initial_velocity: f64,
}

/// The bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bit {
    /// Length `Lb` of a uniform bit, m.
    pub length: f64,
    /// Number of elements `nb`: spans of the mesh over the whole body.
    pub elements: usize,
    /// Its sections; if there are none, it is uniform, of `length` and `cross_section`.
    pub segments: Segments,
}

/// The semi-discretisation of elastic bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Degree of the shape functions: 1 for linear elements; above 1 for B-splines, which are smooth inside a section.
    pub degree: usize,
}

/// Which collisions count as blows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blows {
    /// Least relative mean speed at impact of a collision that counts as a blow, m/s.
    pub minimum_speed: f64,
}

/// The piston/bit interface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Penalty stiffness `KC`, N/m.
    pub stiffness: f64,
    /// Initial gap `g0`, m.
    pub initial_gap: f64,
}

/// The bit/rock law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rock {
    /// Loading stiffness `KR`, N/m.
    pub stiffness: f64,
    /// Unloading-to-loading stiffness ratio `gamma`, above 1.
    pub unloading_ratio: f64,
    /// Viscosity `CR`, N s/m.
    pub viscosity: f64,
    /// Energy barrier `WR`, J.
    pub energy_barrier: f64,
    /// Standstill speed `vs`, m/s.
    pub standstill_speed: f64,
    /// Standstill penetration `dps`, m.
    pub standstill_penetration: f64,
    /// Work to break out a unit volume of rock `E_v`, J/m3.
    pub specific_energy: f64,
    /// Uncertainty of `E_v` as a factor: the true value lies between `E_v` divided by it and `E_v` times it.
    pub specific_energy_factor: f64,
    /// How the bit moves if it turns downward again before it has left the rock.
    pub reloading: Reloading,
}

/// The hole that is drilled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hole {
    /// Diameter `D`, m.
    pub diameter: f64,
}

/// The casing around the hammer, with back head and chuck: all that moves with it along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Casing {
    /// Mass `Mc` of a rigid casing without sections, kg; with 0 there is no casing.
    pub mass: f64,
    /// Impedance `Zs` of an endless drill string above the casing, N s/m; with 0 there is no string.
    pub impedance: f64,
    /// Spans of the mesh over the whole casing, if it is elastic.
    pub elements: usize,
    /// Its sections, from which its mass follows; if there are none, the casing is rigid and has the mass `mass`.
    pub segments: Segments,
}

/// The tie of bit and casing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChuckLaw {
    /// Stiffness `ks` of shoulder and ring, N/m.
    pub stiffness: f64,
    /// Viscosity `cs` of shoulder and ring, N s/m.
    pub viscosity: f64,
    /// Travel of the bit from shoulder to ring, m.
    pub travel: f64,
    /// Travel beyond which the drive is vented, m; with 0 it is never vented.
    pub idle_travel: f64,
}

/// The driving force on the piston.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// The source of the force.
    pub source: Source,
    /// Relay amplitude `F0`, N.
    pub amplitude: f64,
    /// Relay stroke `D1`, m.
    pub stroke: f64,
    /// Area of the pressure that drives the piston down, m2.
    pub area_drive: f64,
    /// Area of the pressure that returns the piston, m2.
    pub area_return: f64,
    /// Area of the bit's upper face on which the return chamber's pressure acts, m2.
    pub anvil_area: f64,
    /// Age of an input value, in communication steps: from the instant to which it belongs to the middle of the step
    /// for which it is set.
    #[serde(default)]
    pub delay: f64,
    /// Impedance `Zd` of a transmission line at the piston, N s/m; with 0 there is no line.
    #[serde(default)]
    pub impedance: f64,
}

/// Length of a casing without sections, m. Such a casing is a point mass, so any positive number would do.
const CASING_LENGTH: f64 = 1.0;

/// All parameters of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Rigid or elastic bodies.
    pub fidelity: Fidelity,
    /// The bars' material.
    pub material: Material,
    /// Cross section `A` of uniform bodies, m2.
    pub cross_section: f64,
    /// The semi-discretisation.
    pub mesh: Mesh,
    /// The piston.
    pub piston: Piston,
    /// The bit.
    pub bit: Bit,
    /// The drill string of a top hammer.
    pub drill: Drill,
    /// The piston/bit interface.
    pub contact: Contact,
    /// The bit/rock law.
    pub rock: Rock,
    /// The hole that is drilled.
    pub hole: Hole,
    /// The casing.
    pub casing: Casing,
    /// The tie of bit and casing.
    pub chuck: ChuckLaw,
    /// The driving force.
    pub drive: Drive,
    /// Chambers, ports and air, if air drives the piston.
    #[serde(default)]
    pub air: AirLaw,
    /// Gravity `G`, m/s2.
    pub gravity: f64,
    /// Which collisions count as blows.
    pub blow: Blows,
    /// Limit of the work of one call, in approximate seconds on one core.
    pub work_limit: usize,
}

/// Start values of the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct InputValues {
    /// Feed force `FS` on the bit's shoulder, or on the casing, N.
    pub feed_force: f64,
    /// `F_A` when the source is [`Source::Force`], N.
    pub drive_force: f64,
    /// Pressure that drives the piston down, Pa.
    pub drive_pressure: f64,
    /// Pressure that returns the piston, Pa.
    pub return_pressure: f64,
    /// Pressure of the supply's air, absolute, Pa.
    pub supply_pressure: f64,
    /// Pressure into which the air exhausts, absolute, Pa.
    pub exhaust_pressure: f64,
}

impl Default for InputValues {
    fn default() -> Self {
        Self {
            feed_force: 5000.0,
            drive_force: 0.0,
            drive_pressure: 0.0,
            return_pressure: 0.0,
            supply_pressure: 1.5e6,
            exhaust_pressure: ATMOSPHERE,
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        let (length, area) = (0.168, 2.6e-3);
        let segments = Segments::none(length, area);
        Self {
            fidelity: Fidelity::Elastic,
            material: Material { youngs_modulus: 210e9, density: 7850.0, damping_time: 2e-8 },
            cross_section: area,
            mesh: Mesh { degree: 3 },
            piston: Piston { length, elements: 16, segments, initial_velocity: 0.0 },
            bit: Bit { length, elements: 16, segments },
            // A thread of 45 mm (1 3/4 in): hollow steel of 46 mm, sleeves of 66 mm, rods of 12 ft.
            drill: Drill {
                rods: 0,
                shank: Segment { length: 0.5, area: 1.8e-3 },
                rod: Segment { length: 3.66, area: 1.43e-3 },
                coupling: Segment { length: 0.21, area: 3.2e-3 },
                joint: Joint { stiffness: 0.0, slack: 5e-4 },
            },
            contact: Contact { stiffness: 1e11, initial_gap: 0.05 },
            rock: Rock {
                stiffness: 1.2e8,
                unloading_ratio: 4.0,
                viscosity: 2.5e4,
                energy_barrier: 1.2,
                standstill_speed: 1e-3,
                standstill_penetration: 1e-6,
                specific_energy: 2e8,
                // The specific energy of an unknown rock lies between 130 and 310 MJ/m3. Two drilling rates from the
                // field, with the published power of their hammers, give 182 and 245; the range extends beyond both
                // ends by about half of their difference.
                specific_energy_factor: 1.55,
                reloading: Reloading::Loading,
            },
            hole: Hole { diameter: 0.09 },
            casing: Casing {
                mass: 0.0,
                impedance: 0.0,
                elements: 20,
                segments: Segments::none(1.0, 5.1e-3),
            },
            chuck: ChuckLaw { stiffness: 1e9, viscosity: 1e4, travel: 0.03, idle_travel: 0.0 },
            drive: Drive {
                source: Source::Relay,
                amplitude: 1800.0,
                stroke: 0.05,
                area_drive: 1.5e-3,
                area_return: 1.5e-3,
                anvil_area: 0.0,
                delay: 0.0,
                impedance: 0.0,
            },
            air: AirLaw::default(),
            gravity: 9.81,
            blow: Blows { minimum_speed: 1.0 },
            work_limit: 30,
        }
    }
}

impl Parameters {
    /// True if the scene has a casing.
    pub fn has_casing(&self) -> bool {
        self.casing_mass() > 0.0
    }

    /// Casing mass: the sum over its sections, or `casing.mass`, kg; 0 if there is no casing.
    pub fn casing_mass(&self) -> f64 {
        self.mass(Body::Casing)
    }

    /// Mass of a body, kg: the sum over its sections, or `casing.mass` of a casing without sections.
    pub fn mass(&self, body: Body) -> f64 {
        match self.is_lumped(body) {
            true => self.casing.mass,
            false => self.sections(body).mass(self.material.density),
        }
    }

    /// True if a body is a point mass, as a casing without sections is.
    pub fn is_lumped(&self, body: Body) -> bool {
        body == Body::Casing && self.casing.segments.is_empty()
    }

    /// The bodies of a scene. The feed force and the drive's reaction act on the last one.
    pub fn bodies(&self) -> impl Iterator<Item = Body> {
        Body::ALL.into_iter().chain(self.has_casing().then_some(Body::Casing))
    }

    /// True if a body is elastic.
    pub fn is_elastic(&self, body: Body) -> bool {
        self.fidelity == Fidelity::Elastic && !self.is_lumped(body)
    }

    /// Number of sections that are given for a body.
    pub fn segments(&self, body: Body) -> usize {
        self.own(body).2.len()
    }

    /// Length of a body if it is uniform (m), number of its elements, and the sections that are given for it.
    pub(crate) fn own(&self, body: Body) -> (f64, usize, &[Segment]) {
        let Self { piston, bit, casing, .. } = self;
        match body {
            Body::Piston => (piston.length, piston.elements, &piston.segments),
            Body::Bit => (bit.length, bit.elements, &bit.segments),
            Body::Casing => (CASING_LENGTH, casing.elements, &casing.segments),
        }
    }

    /// Number of elements of a body's mesh.
    pub fn elements_mut(&mut self, body: Body) -> &mut usize {
        match body {
            Body::Piston => &mut self.piston.elements,
            Body::Bit => &mut self.bit.elements,
            Body::Casing => &mut self.casing.elements,
        }
    }
}

/// Most elements of a bar.
pub const MAX_ELEMENTS: usize = 400;
/// Largest wave speed of elastic bodies, m/s. In diamond it is 1.8e4.
pub const FASTEST_WAVE: f64 = 2e4;

/// Least stiffness of a loose joint, as a multiple of a rod's own `E A / L`. A softer joint lets hardly any wave
/// through. In the limit nothing would join the rods, whereas the parameter 0 means a tight joint.
pub const SOFTEST_JOINT: f64 = 1e-3;

/// Highest degree of splines.
pub const MAX_DEGREE: usize = 7;
