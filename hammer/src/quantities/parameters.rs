//! What a scene is made of: the parameters, their defaults and their domains.
//!
//! This file is the only home of a default number. The defaults are the
//! reference hammer: 3.4 kg piston, 26 cm2 section, about 200 J per blow, 22 Hz,
//! in soft rock. SI units throughout.

use crate::quantities::sections::{MAX_SEGMENTS, Segment};
pub use crate::quantities::domain::Domain;
use crate::quantities::domain::ParameterError;
use serde::{Deserialize, Serialize};

/// How the bodies are modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fidelity {
    /// One unknown a body; a collision lasts what waves would give it.
    Rigid,
    /// Bars with consistent mass, of linear elements or of splines.
    Elastic,
}

/// Where the force on the piston comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// `F_A = alpha F0`, `alpha` switched by the relative mean position.
    Relay,
    /// `F_A` is the input `drive_force`.
    Force,
    /// `F_A = p_drive A_drive - p_return A_return`, the pressures inputs.
    Pressure,
    /// The same, the pressures switched by the piston's position.
    Chambers,
}

impl Source {
    /// True if the piston's place switches it.
    pub(crate) fn switches(self) -> bool {
        matches!(self, Self::Relay | Self::Chambers)
    }
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
    /// Number of sections; 0: uniform, of `length` and `cross_section`.
    pub segments: usize,
    /// The sections from top to bottom; read up to `segments`.
    pub segment: [Segment; MAX_SEGMENTS],
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
    /// Number of sections; 0: uniform, of `length` and `cross_section`.
    pub segments: usize,
    /// The sections from top to bottom; read up to `segments`.
    pub segment: [Segment; MAX_SEGMENTS],
}

/// The semi-discretisation of elastic bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Degree: 1 linear elements, above B-splines, smooth inside a section.
    pub degree: usize,
}

/// Which collisions count as blows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blows {
    /// Slowest relative mean speed at impact of a blow, m/s.
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
}

/// The driving force on the piston.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Which of the sources.
    pub source: Source,
    /// Relay amplitude `F0`, N.
    pub amplitude: f64,
    /// Relay stroke `D1`, m.
    pub stroke: f64,
    /// Area on which the pressure that drives acts, m2.
    pub area_drive: f64,
    /// Area on which the pressure that returns acts, m2.
    pub area_return: f64,
}

/// A port that the piston opens and closes where it passes it, and what the chamber's pressure
/// does then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PortLaw {
    /// Mean position of the piston over the bit, `vr`, at which it turns, m.
    pub position: f64,
    /// Pressure that the chamber goes to when it opens, Pa.
    pub open_pressure: f64,
    /// Time that this takes, s; 0: at once.
    pub open_time: f64,
    /// Pressure that the chamber goes to when it closes, Pa.
    pub shut_pressure: f64,
    /// Time that this takes, s; 0: at once.
    pub shut_time: f64,
}

/// The ports of a chamber.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChamberLaw {
    /// Where gas comes in.
    pub supply: PortLaw,
    /// Where it goes out.
    pub exhaust: PortLaw,
}

/// The chambers of [`Source::Chambers`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChamberLaws {
    /// Above the piston: supplied while that is high, exhausted while it is low.
    pub drive: ChamberLaw,
    /// Below it: supplied while it is low, exhausted while it is high.
    pub returning: ChamberLaw,
}

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
    /// The piston/bit interface.
    pub contact: Contact,
    /// The bit/rock law.
    pub rock: Rock,
    /// The driving force.
    pub drive: Drive,
    /// The chambers, if they drive.
    pub chambers: ChamberLaws,
    /// Gravity `G`, m/s2.
    pub gravity: f64,
    /// Which collisions count as blows.
    pub blow: Blows,
}

/// The parameters that may change while a scene runs; the state is kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tunables {
    /// Loading stiffness `KR`, N/m.
    pub rock_stiffness: f64,
    /// Unloading-to-loading stiffness ratio `gamma`, above 1.
    pub rock_unloading_ratio: f64,
    /// Viscosity `CR`, N s/m.
    pub rock_viscosity: f64,
    /// Energy barrier `WR`, J.
    pub rock_energy_barrier: f64,
    /// Relay amplitude `F0`, N.
    pub drive_amplitude: f64,
}

/// Values of the four inputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputValues {
    /// Feed force `FS` on the bit's shoulder, N.
    pub feed_force: f64,
    /// `F_A` when the source is [`Source::Force`], N.
    pub drive_force: f64,
    /// Pressure that drives the piston down, Pa.
    pub drive_pressure: f64,
    /// Pressure that returns the piston, Pa.
    pub return_pressure: f64,
}

impl Default for InputValues {
    fn default() -> Self {
        Self { feed_force: 5000.0, drive_force: 0.0, drive_pressure: 0.0, return_pressure: 0.0 }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        let (length, area) = (0.168, 2.6e-3);
        // Eight of them are the uniform body.
        let segment = [Segment { length: length / MAX_SEGMENTS as f64, area }; MAX_SEGMENTS];
        Self {
            fidelity: Fidelity::Elastic,
            material: Material { youngs_modulus: 210e9, density: 7850.0, damping_time: 2e-8 },
            cross_section: area,
            mesh: Mesh { degree: 1 },
            piston: Piston { length, elements: 20, segments: 0, segment, initial_velocity: 0.0 },
            bit: Bit { length, elements: 20, segments: 0, segment },
            contact: Contact { stiffness: 1e11, initial_gap: 0.05 },
            rock: Rock {
                stiffness: 1.2e8,
                unloading_ratio: 4.0,
                viscosity: 1.7e5,
                energy_barrier: 4.0,
                standstill_speed: 1e-3,
                standstill_penetration: 1e-6,
            },
            drive: Drive {
                source: Source::Relay,
                amplitude: 1800.0,
                stroke: 0.05,
                area_drive: 1.5e-3,
                area_return: 1.5e-3,
            },
            // Those of `dth_hammer.models.pneumatic`, by `examples/chambers.py`.
            chambers: ChamberLaws {
                drive: ChamberLaw {
                    supply: PortLaw {
                        position: -0.032,
                        open_pressure: 14.4e5,
                        open_time: 3.9e-3,
                        shut_pressure: 8.2e5,
                        shut_time: 1.9e-3,
                    },
                    exhaust: PortLaw {
                        position: -0.018,
                        open_pressure: 1e5,
                        open_time: 7.8e-3,
                        shut_pressure: 9.8e5,
                        shut_time: 14.4e-3,
                    },
                },
                returning: ChamberLaw {
                    supply: PortLaw {
                        position: -0.013,
                        open_pressure: 13.3e5,
                        open_time: 2.4e-3,
                        shut_pressure: 5.8e5,
                        shut_time: 5.1e-3,
                    },
                    exhaust: PortLaw {
                        position: -0.037,
                        open_pressure: 1.1e5,
                        open_time: 3.9e-3,
                        shut_pressure: 3.1e5,
                        shut_time: 11e-3,
                    },
                },
            },
            gravity: 9.81,
            blow: Blows { minimum_speed: 1.0 },
        }
    }
}

impl Parameters {
    /// The tunable ones among them.
    pub fn tunables(&self) -> Tunables {
        Tunables {
            rock_stiffness: self.rock.stiffness,
            rock_unloading_ratio: self.rock.unloading_ratio,
            rock_viscosity: self.rock.viscosity,
            rock_energy_barrier: self.rock.energy_barrier,
            drive_amplitude: self.drive.amplitude,
        }
    }

    /// The same with other tunables.
    #[must_use]
    pub fn with(mut self, tunables: &Tunables) -> Self {
        self.rock.stiffness = tunables.rock_stiffness;
        self.rock.unloading_ratio = tunables.rock_unloading_ratio;
        self.rock.viscosity = tunables.rock_viscosity;
        self.rock.energy_barrier = tunables.rock_energy_barrier;
        self.drive.amplitude = tunables.drive_amplitude;
        self
    }

    /// Checks every parameter that is read against its domain.
    ///
    /// # Errors
    /// The first offender: its name, its value and the allowed range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for rule in RULES.iter().filter(|rule| (rule.applies)(self)) {
            let value = (rule.value)(self);
            if !rule.domain.contains(value) {
                return Err(ParameterError {
                    name: rule.name,
                    value,
                    allowed: rule.domain.describe(),
                });
            }
        }
        Ok(())
    }
}

/// A parameter's name, its domain and where it stands.
pub struct Rule {
    /// Dotted name, as in the FMU.
    pub name: &'static str,
    /// Allowed values.
    pub domain: Domain,
    /// Reads it.
    pub value: fn(&Parameters) -> f64,
    /// False if the scene does not read it: sections beyond the number of them.
    pub applies: fn(&Parameters) -> bool,
}

const fn rule(name: &'static str, domain: Domain, value: fn(&Parameters) -> f64) -> Rule {
    Rule { name, domain, value, applies: |_| true }
}

/// The rule of a body's section `k`, from 1.
macro_rules! section {
    ($body:ident, $k:literal, $field:ident) => {
        Rule {
            name: concat!(stringify!($body), ".segment[", $k, "].", stringify!($field)),
            domain: Domain::Above(0.0),
            value: |p| p.$body.segment[$k - 1].$field,
            applies: |p| $k <= p.$body.segments,
        }
    };
}

/// The rule of a number of a chamber's port.
macro_rules! port {
    ($chamber:ident, $name:literal, $port:ident, $field:ident, $domain:expr) => {
        Rule {
            name: concat!("chambers.", $name, ".", stringify!($port), ".", stringify!($field)),
            domain: $domain,
            value: |p| p.chambers.$chamber.$port.$field,
            applies: |p| matches!(p.drive.source, Source::Chambers),
        }
    };
}

/// Largest number of elements per bar may have.
pub const MAX_ELEMENTS: usize = 400;

/// Highest degree of splines.
pub const MAX_DEGREE: usize = 7;

/// The domain of every numeric parameter.
#[rustfmt::skip]
pub const RULES: &[Rule] = &[
    rule("material.youngs_modulus", Domain::Above(0.0), |p| p.material.youngs_modulus),
    rule("material.density", Domain::Above(0.0), |p| p.material.density),
    rule("material.damping_time", Domain::AtLeast(0.0), |p| p.material.damping_time),
    rule("cross_section", Domain::Above(0.0), |p| p.cross_section),
    rule("mesh.degree", Domain::Between(1.0, MAX_DEGREE as f64), |p| p.mesh.degree as f64),
    rule("piston.length", Domain::Above(0.0), |p| p.piston.length),
    rule("piston.elements", Domain::Between(1.0, MAX_ELEMENTS as f64), |p| p.piston.elements as f64),
    rule("piston.segments", Domain::Between(0.0, MAX_SEGMENTS as f64), |p| p.piston.segments as f64),
    section!(piston, 1, length), section!(piston, 1, area),
    section!(piston, 2, length), section!(piston, 2, area),
    section!(piston, 3, length), section!(piston, 3, area),
    section!(piston, 4, length), section!(piston, 4, area),
    section!(piston, 5, length), section!(piston, 5, area),
    section!(piston, 6, length), section!(piston, 6, area),
    section!(piston, 7, length), section!(piston, 7, area),
    section!(piston, 8, length), section!(piston, 8, area),
    rule("piston.initial_velocity", Domain::Any, |p| p.piston.initial_velocity),
    rule("bit.length", Domain::Above(0.0), |p| p.bit.length),
    rule("bit.elements", Domain::Between(1.0, MAX_ELEMENTS as f64), |p| p.bit.elements as f64),
    rule("bit.segments", Domain::Between(0.0, MAX_SEGMENTS as f64), |p| p.bit.segments as f64),
    section!(bit, 1, length), section!(bit, 1, area),
    section!(bit, 2, length), section!(bit, 2, area),
    section!(bit, 3, length), section!(bit, 3, area),
    section!(bit, 4, length), section!(bit, 4, area),
    section!(bit, 5, length), section!(bit, 5, area),
    section!(bit, 6, length), section!(bit, 6, area),
    section!(bit, 7, length), section!(bit, 7, area),
    section!(bit, 8, length), section!(bit, 8, area),
    rule("contact.stiffness", Domain::Above(0.0), |p| p.contact.stiffness),
    rule("contact.initial_gap", Domain::AtLeast(0.0), |p| p.contact.initial_gap),
    rule("rock.stiffness", Domain::Above(0.0), |p| p.rock.stiffness),
    rule("rock.unloading_ratio", Domain::Above(1.0), |p| p.rock.unloading_ratio),
    rule("rock.viscosity", Domain::AtLeast(0.0), |p| p.rock.viscosity),
    rule("rock.energy_barrier", Domain::AtLeast(0.0), |p| p.rock.energy_barrier),
    rule("rock.standstill_speed", Domain::AtLeast(0.0), |p| p.rock.standstill_speed),
    rule("rock.standstill_penetration", Domain::AtLeast(0.0), |p| p.rock.standstill_penetration),
    rule("drive.amplitude", Domain::AtLeast(0.0), |p| p.drive.amplitude),
    rule("drive.stroke", Domain::Above(0.0), |p| p.drive.stroke),
    rule("drive.area_drive", Domain::AtLeast(0.0), |p| p.drive.area_drive),
    rule("drive.area_return", Domain::AtLeast(0.0), |p| p.drive.area_return),
    port!(drive, "drive", supply, position, Domain::Any),
    port!(drive, "drive", supply, open_pressure, Domain::AtLeast(0.0)), port!(drive, "drive", supply, open_time, Domain::AtLeast(0.0)),
    port!(drive, "drive", supply, shut_pressure, Domain::AtLeast(0.0)), port!(drive, "drive", supply, shut_time, Domain::AtLeast(0.0)),
    port!(drive, "drive", exhaust, position, Domain::Any),
    port!(drive, "drive", exhaust, open_pressure, Domain::AtLeast(0.0)), port!(drive, "drive", exhaust, open_time, Domain::AtLeast(0.0)),
    port!(drive, "drive", exhaust, shut_pressure, Domain::AtLeast(0.0)), port!(drive, "drive", exhaust, shut_time, Domain::AtLeast(0.0)),
    port!(returning, "return", supply, position, Domain::Any),
    port!(returning, "return", supply, open_pressure, Domain::AtLeast(0.0)), port!(returning, "return", supply, open_time, Domain::AtLeast(0.0)),
    port!(returning, "return", supply, shut_pressure, Domain::AtLeast(0.0)), port!(returning, "return", supply, shut_time, Domain::AtLeast(0.0)),
    port!(returning, "return", exhaust, position, Domain::Any),
    port!(returning, "return", exhaust, open_pressure, Domain::AtLeast(0.0)), port!(returning, "return", exhaust, open_time, Domain::AtLeast(0.0)),
    port!(returning, "return", exhaust, shut_pressure, Domain::AtLeast(0.0)), port!(returning, "return", exhaust, shut_time, Domain::AtLeast(0.0)),
    rule("gravity", Domain::Any, |p| p.gravity),
    rule("blow.minimum_speed", Domain::AtLeast(0.0), |p| p.blow.minimum_speed),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantities::sections::Body;

    #[test]
    fn eight_default_sections_are_the_uniform_body() {
        let uniform = Parameters::default();
        let mut cut = uniform;
        (cut.piston.segments, cut.bit.segments) = (8, 8);
        for body in Body::ALL {
            // Eight products and sums, each rounded.
            let close = |a: f64, b: f64| (a - b).abs() <= 16.0 * f64::EPSILON * b;
            assert!(close(cut.sections(body).length(), uniform.sections(body).length()));
            assert!(close(cut.sections(body).mass(7850.0), uniform.sections(body).mass(7850.0)));
        }
    }
}
