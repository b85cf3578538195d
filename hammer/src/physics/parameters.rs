//! What a scene is made of: the parameters, their defaults and their domains.
//!
//! This file is the only home of a default number. The defaults are the
//! reference hammer: 3.4 kg piston, 26 cm2 section, about 200 J a blow, 22 Hz,
//! in soft rock. SI units throughout.

use crate::error::ParameterError;
use serde::{Deserialize, Serialize};

/// How the bodies are modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fidelity {
    /// One unknown a body; a collision lasts what waves would give it.
    Rigid,
    /// Linear bar elements with consistent mass.
    Elastic,
}

/// Where the force on the piston comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// `F_A = alpha F0`, `alpha` switched by the relative mean position.
    Relay,
    /// `F_A` is the input `drive_force`.
    Force,
    /// `F_A = p_drive A_drive - p_return A_return`.
    Pressure,
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
    /// Length `Lp`, m.
    pub length: f64,
    /// Number of elements `np`.
    pub elements: usize,
    /// Uniform velocity at the start, m/s, positive downward.
    pub initial_velocity: f64,
}

/// The bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bit {
    /// Length `Lb`, m.
    pub length: f64,
    /// Number of elements `nb`.
    pub elements: usize,
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
    /// Which of the three sources.
    pub source: Source,
    /// Relay amplitude `F0`, N.
    pub amplitude: f64,
    /// Relay stroke `D1`, m.
    pub stroke: f64,
    /// Area on which `drive_pressure` acts, m2.
    pub area_drive: f64,
    /// Area on which `return_pressure` acts, m2.
    pub area_return: f64,
}

/// All parameters of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Rigid or elastic bodies.
    pub fidelity: Fidelity,
    /// The bars' material.
    pub material: Material,
    /// Cross section `A` of both bodies, m2.
    pub cross_section: f64,
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
    /// Gravity `G`, m/s2.
    pub gravity: f64,
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
        Self {
            fidelity: Fidelity::Elastic,
            material: Material { youngs_modulus: 210e9, density: 7850.0, damping_time: 2e-8 },
            cross_section: 2.6e-3,
            piston: Piston { length: 0.168, elements: 20, initial_velocity: 0.0 },
            bit: Bit { length: 0.168, elements: 20 },
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
            gravity: 9.81,
        }
    }
}

/// The six timescales of the model (6), in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timescales {
    /// Wave transit of the piston, `Lp/c0`.
    pub piston_transit: f64,
    /// Wave transit of the bit, `Lb/c0`.
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

    /// Wave speed `c0 = sqrt(E/rho)`, m/s.
    pub fn wave_speed(&self) -> f64 {
        (self.material.youngs_modulus / self.material.density).sqrt()
    }

    /// Impedance `Z = A sqrt(E rho)`, N s/m.
    pub fn impedance(&self) -> f64 {
        self.cross_section * (self.material.youngs_modulus * self.material.density).sqrt()
    }

    /// Piston mass `rho A Lp`, kg.
    pub fn piston_mass(&self) -> f64 {
        self.material.density * self.cross_section * self.piston.length
    }

    /// Bit mass `rho A Lb`, kg.
    pub fn bit_mass(&self) -> f64 {
        self.material.density * self.cross_section * self.bit.length
    }

    /// Stiffness through which the bodies meet, N/m: the penalty `KC`, and for
    /// rigid bodies in series with it the bars' own compliance
    /// `k = pi^2 E A Lmax / (4 (Lp + Lb) Lmin)`.
    pub fn meeting_stiffness(&self) -> f64 {
        match self.fidelity {
            Fidelity::Elastic => self.contact.stiffness,
            Fidelity::Rigid => {
                let (lp, lb) = (self.piston.length, self.bit.length);
                let pi2 = std::f64::consts::PI * std::f64::consts::PI;
                let k = pi2 * self.material.youngs_modulus * self.cross_section * lp.max(lb)
                    / (4.0 * (lp + lb) * lp.min(lb));
                1.0 / (1.0 / self.contact.stiffness + 1.0 / k)
            }
        }
    }

    /// Length that the motion scales with, m: the longer of `g0` and `D1`.
    pub fn travel(&self) -> f64 {
        self.contact.initial_gap.max(self.drive.stroke)
    }

    /// What counts as crossed: a displacement guard beyond the first (m), a velocity guard
    /// beyond the second (m/s). Parts of the [travel](Self::travel), so that a scene twice
    /// as large moves twice as far, bit for bit: 1e-14 m and 1e-9 m/s for the reference.
    pub fn resolutions(&self) -> [f64; 2] {
        [DISPLACEMENT_RESOLUTION * self.travel(), VELOCITY_RESOLUTION * self.travel()]
    }

    /// The timescales (6).
    pub fn timescales(&self) -> Timescales {
        let (mp, mb) = (self.piston_mass(), self.bit_mass());
        let (drive, rock) = (&self.drive, &self.rock);
        Timescales {
            piston_transit: self.piston.length / self.wave_speed(),
            bit_transit: self.bit.length / self.wave_speed(),
            pressure: (mp * drive.stroke / drive.amplitude).sqrt(),
            drilling: (mb / rock.stiffness).sqrt(),
            barrier: rock.energy_barrier / (drive.amplitude * drive.stroke) * mp / rock.viscosity,
            contact: (mp / self.contact.stiffness).sqrt(),
        }
    }

    /// Checks every parameter against its domain.
    ///
    /// # Errors
    /// The first offender: its name, its value and the allowed range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for rule in RULES {
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

/// The values a real parameter may take; finite in any case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// Any finite number.
    Any,
    /// At least this.
    AtLeast(f64),
    /// Strictly above this.
    Above(f64),
    /// Between the two, both included.
    Between(f64, f64),
}

impl Domain {
    /// True if `value` is finite and allowed.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::AtLeast(low) => value >= low,
                Self::Above(low) => value > low,
                Self::Between(low, high) => (low..=high).contains(&value),
            }
    }

    /// The domain in words, for messages.
    pub fn describe(self) -> String {
        match self {
            Self::Any => "a finite number".into(),
            Self::AtLeast(low) => format!("a finite number of at least {low}"),
            Self::Above(low) => format!("a finite number above {low}"),
            Self::Between(low, high) => format!("{low} to {high}"),
        }
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
}

const fn rule(name: &'static str, domain: Domain, value: fn(&Parameters) -> f64) -> Rule {
    Rule { name, domain, value }
}

/// Resolution of displacement guards over the travel.
const DISPLACEMENT_RESOLUTION: f64 = 2e-13;
/// Resolution of velocity guards over the travel, 1/s.
const VELOCITY_RESOLUTION: f64 = 2e-8;

/// Largest number of elements a bar may have.
pub const MAX_ELEMENTS: usize = 400;

/// The domain of every numeric parameter.
pub const RULES: &[Rule] = &[
    rule("material.youngs_modulus", Domain::Above(0.0), |p| p.material.youngs_modulus),
    rule("material.density", Domain::Above(0.0), |p| p.material.density),
    rule("material.damping_time", Domain::AtLeast(0.0), |p| p.material.damping_time),
    rule("cross_section", Domain::Above(0.0), |p| p.cross_section),
    rule("piston.length", Domain::Above(0.0), |p| p.piston.length),
    rule("piston.elements", Domain::Between(1.0, MAX_ELEMENTS as f64), |p| {
        p.piston.elements as f64
    }),
    rule("piston.initial_velocity", Domain::Any, |p| p.piston.initial_velocity),
    rule("bit.length", Domain::Above(0.0), |p| p.bit.length),
    rule("bit.elements", Domain::Between(1.0, MAX_ELEMENTS as f64), |p| p.bit.elements as f64),
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
    rule("gravity", Domain::Any, |p| p.gravity),
];
