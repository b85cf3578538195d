//! Which parameters a scene may have: each in its domain, and combinations that fit each other.
//!
//! The wave of a blow, `2 Lp` long, must keep its shape on the way down a drill string. On splines of degree `d` with
//! consistent mass and spans `h`, a wave of length `w` is too fast by the share
//! `|B_2d| (k h)^(2 d) / (2 (2 d)!) = zeta(2 d) (h/w)^(2 d)`, with Bernoulli's numbers and `k = 2 pi/w`; for linear
//! elements this is the known `(k h)^2 / 24`. Along `L` the phase error is `2 pi L/w` times as much.

use crate::numerics::display::DisplayNumber;
use crate::numerics::math;
use crate::quantities::domain::ParameterError;
use crate::quantities::drill::{Drill, Joint};
use crate::quantities::parameters::{
    FASTEST_WAVE, Fidelity, MAX_DEGREE, MAX_ELEMENTS, Material, Parameters, SOFTEST_JOINT, Source,
};
use crate::quantities::sections::{Body, Segment};
use crate::quantities::table::{Change, PARAMETERS, name_of};
use std::f64::consts::TAU;

/// Largest phase error of a blow's wave along a string, rad.
const PHASE: f64 = 0.1;
/// Bound of `zeta(2 d)`: its value at `d = 1`, `pi^2 / 6`.
const ZETA: f64 = 1.645;

/// Slowest decay of a casing that is braked by a string, 1/s. With a slower one the casing would reach speeds and
/// distances whose rounding exceeds a resolution, while within a blow it is hardly braked.
const SLOWEST_STRING: f64 = 10.0;

/// Least mass of a casing, over the bit's. The lightest of tied bodies costs its modes a digit for each decade; down
/// to here, the ledger of every preset closes to 1e-10 of its turnover.
const LIGHTEST_CASING: f64 = 1e-4;

impl Parameters {
    /// Checks every parameter against its domain, except sections and ports that are not read.
    ///
    /// # Errors
    ///
    /// The first that is outside: its name, its value and the allowed range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let mut checked = PARAMETERS.iter().filter(|row| row.is_checked(self));
        checked.try_for_each(|row| row.check(row.slot.read(self)))?;
        self.check_material()?;
        self.check_casing()?;
        self.check_cylinder()?;
        self.check_line()?;
        self.check_drill()
    }

    fn check_material(&self) -> Result<(), ParameterError> {
        let Material { youngs_modulus: value, density, .. } = self.material;
        let stiffest = FASTEST_WAVE * FASTEST_WAVE * density;
        if self.fidelity == Fidelity::Rigid || value <= stiffest {
            return Ok(());
        }
        let stiffest = DisplayNumber(stiffest);
        let allowed = format!("up to {stiffest}, for waves of {FASTEST_WAVE:e} m/s (in steel 5e3)");
        Err(ParameterError { name: name_of(|p| &mut p.material.youngs_modulus), value, allowed })
    }

    fn check_casing(&self) -> Result<(), ParameterError> {
        let chuck = &self.chuck;
        let (mass, least) = (self.casing_mass(), LIGHTEST_CASING * self.bit_mass());
        if self.has_casing() && mass < least {
            let least = format!("{least:.4e}");
            let (name, value, range) = match self.casing.segments {
                0 => (name_of(|p| &mut p.casing.mass), mass, format!("0, or at least {least}")),
                _ => {
                    let name = name_of(|p| &mut p.casing.segment[0].area);
                    let range = format!("larger, so that the casing has at least {least} kg");
                    (name, self.casing.segment[0].area, range)
                }
            };
            let allowed = format!("{range} ({LIGHTEST_CASING:e} of the bit's mass)");
            return Err(ParameterError { name, value, allowed });
        }
        if self.has_casing() && chuck.idle_travel >= chuck.travel {
            let allowed = format!("below chuck.travel, {}", DisplayNumber(chuck.travel));
            let name = name_of(|p| &mut p.chuck.idle_travel);
            return Err(ParameterError { name, value: chuck.idle_travel, allowed });
        }
        let (weakest, impedance) = (SLOWEST_STRING * self.casing_mass(), self.casing.impedance);
        if self.has_casing() && impedance != 0.0 && impedance < weakest {
            let weakest = DisplayNumber(weakest);
            let allowed = format!("0, or at least {weakest} (the casing's mass times 10 per s)");
            let name = name_of(|p| &mut p.casing.impedance);
            return Err(ParameterError { name, value: impedance, allowed });
        }
        Ok(())
    }

    /// Checks that both chambers have a positive volume at the piston's start.
    fn check_cylinder(&self) -> Result<(), ParameterError> {
        let (air, drive) = (&self.air, &self.drive);
        let most = air.cylinder + air.drive.dead_volume / drive.area_drive;
        if drive.source != Source::Air || self.contact.initial_gap < most {
            return Ok(());
        }
        let allowed = format!(
            "below {}, where the drive chamber has no volume left (air.cylinder, air.drive.dead_volume)",
            DisplayNumber(most)
        );
        let name = name_of(|p| &mut p.contact.initial_gap);
        Err(ParameterError { name, value: self.contact.initial_gap, allowed })
    }

    /// The largest impedance of a line at the piston, N s/m. With it the line brakes the piston and the body that the
    /// drive pushes against within the time in which a wave crosses the piston. A force that is distributed like the
    /// mass cannot represent faster braking.
    pub fn most_impedance(&self) -> f64 {
        let struck = match self.drill.loose() {
            0 => self.bit_mass(),
            _ => {
                let shank = self.drill.sections().filter(|(body, _)| *body == 0);
                let volume: f64 = shank.map(|(_, part)| part.length * part.area).sum();
                self.material.density * volume
            }
        };
        let frame = if self.has_casing() { self.casing_mass() } else { struck };
        let transit = self.sections(Body::Piston).length() / self.wave_speed();
        1.0 / (transit * (1.0 / self.piston_mass() + 1.0 / frame))
    }

    /// Checks that a line is not combined with air, and that it is slower than waves.
    fn check_line(&self) -> Result<(), ParameterError> {
        let (value, most) = (self.drive.impedance, self.most_impedance());
        let allowed = match self.drive.source {
            _ if value == 0.0 => return Ok(()),
            Source::Air => {
                "0 where air drives the piston (drive.source), whose drag is air.drag".into()
            }
            _ if value <= most => return Ok(()),
            _ => format!(
                "at most {}, with which the line brakes as fast as a wave passes the piston",
                DisplayNumber(most)
            ),
        };
        Err(ParameterError { name: name_of(|p| &mut p.drive.impedance), value, allowed })
    }

    /// These parameters, with the tunable ones of `wanted`.
    ///
    /// # Errors
    /// A parameter out of its domain, or a fixed one that differs.
    pub(crate) fn retuned(&self, wanted: &Self) -> Result<Self, ParameterError> {
        let mut tuned = *self;
        for row in PARAMETERS.iter() {
            let [before, value] = [self, wanted].map(|p| row.slot.read(p));
            if row.change == Change::Tunable {
                row.check(value)?;
                row.slot.write(&mut tuned, value);
            } else if value != before {
                let allowed = format!("{}: it is fixed once the scene runs", DisplayNumber(before));
                return Err(ParameterError { name: row.name, value, allowed });
            }
        }
        Ok(tuned)
    }

    /// Checks that sleeves fit their rods, and that bodies and mesh carry a wave down the string.
    ///
    /// # Errors
    /// A parameter out of its domain.
    fn check_drill(&self) -> Result<(), ParameterError> {
        let Drill { rods, shank, rod, coupling, joint } = self.drill;
        if rods == 0 {
            return Ok(());
        }
        let most = rod.length.min(2.0 * shank.length);
        if coupling.length >= most {
            let value = coupling.length;
            let allowed =
                format!("below {}, the rod's length and twice the shank's", DisplayNumber(most));
            return Err(ParameterError {
                name: name_of(|p| &mut p.drill.coupling.length),
                value,
                allowed,
            });
        }
        if self.fidelity == Fidelity::Rigid {
            let allowed = "0 with rigid bodies, which carry no wave".into();
            let name = name_of(|p| &mut p.drill.rods);
            return Err(ParameterError { name, value: rods as f64, allowed });
        }
        let Joint { stiffness: value, .. } = joint;
        let softest = SOFTEST_JOINT * self.material.youngs_modulus * rod.area / rod.length;
        let allowed = match self.drill.loose() {
            0 => None,
            _ if value < softest => Some(format!(
                "0, or at least {} ({SOFTEST_JOINT} of a rod's own stiffness)",
                DisplayNumber(softest)
            )),
            _ => None,
        };
        if let Some(allowed) = allowed {
            let name = name_of(|p| &mut p.drill.joint.stiffness);
            return Err(ParameterError { name, value, allowed });
        }
        self.check_string_mesh()
    }

    /// Length of the wave of a blow, m.
    pub(crate) fn blow_wave(&self) -> f64 {
        2.0 * self.sections(Body::Piston).length()
    }

    /// Longest span of splines of this degree on which the wave of a blow keeps its shape along the string, m.
    pub(crate) fn longest_string_span(&self, degree: usize) -> f64 {
        let waves = self.sections(Body::Bit).length() / self.blow_wave();
        self.blow_wave() * math::pow(PHASE / (TAU * ZETA * waves), 0.5 / degree as f64)
    }

    fn check_string_mesh(&self) -> Result<(), ParameterError> {
        let (sections, degree) = (self.sections(Body::Bit), self.mesh.degree);
        let (length, wave) = (sections.length(), self.blow_wave());
        let longest = self.longest_string_span(degree);
        let spans = sections.spans(self.spans(Body::Bit)).into_iter();
        let carries = |(s, spans): (&Segment, usize)| s.length <= longest * spans as f64;
        if sections.as_slice().iter().zip(spans).all(carries) {
            return Ok(());
        }
        let needed: f64 = sections.as_slice().iter().map(|s| (s.length / longest).ceil()).sum();
        let (name, value, bound) = if needed <= MAX_ELEMENTS as f64 {
            (name_of(|p| &mut p.bit.elements), self.bit.elements, format!("at least {needed}"))
        } else if degree < MAX_DEGREE {
            (name_of(|p| &mut p.mesh.degree), degree, format!("above {degree}"))
        } else {
            (name_of(|p| &mut p.drill.rods), self.drill.rods, "fewer".into())
        };
        let allowed = format!(
            "{bound}, so that a wave of {} m keeps its shape along a string of {} m",
            DisplayNumber(wave),
            DisplayNumber(length)
        );
        Err(ParameterError { name, value: value as f64, allowed })
    }
}
