//! Checks of a scene's parameters: each must be in its domain, and together they must be consistent.
//!
//! The wave of a blow, which is `2 Lp` long, must keep its shape on its way down a drill string.
//! On splines of degree `d` with consistent mass and spans of length `h`, a wave of length `w` is too fast by the
//! relative error `|B_2d| (k h)^(2 d) / (2 (2 d)!) = zeta(2 d) (h/w)^(2 d)`, with Bernoulli's numbers and `k = 2 pi/w`.
//! For linear elements this is the well-known `(k h)^2 / 24`.
//! Along a string of length `L` the phase error is `2 pi L/w` times this error.

use crate::numerics::display::DisplayNumber;
use crate::numerics::math;
use crate::quantities::domain::ParameterError;
use crate::quantities::drill::Drill;
use crate::quantities::parameters::{
    FASTEST_WAVE, Fidelity, MAX_DEGREE, MAX_ELEMENTS, Material, Parameters, SOFTEST_JOINT, Source,
};
use crate::quantities::sections::{Body, Segment};
use crate::quantities::table::{PARAMETERS, name_of};
use std::f64::consts::TAU;

/// Largest phase error of a blow's wave along a string, rad.
const PHASE: f64 = 0.1;
/// Upper bound of `zeta(2 d)`: its value `pi^2 / 6` at `d = 1`.
const ZETA: f64 = 1.645;

/// Slowest decay of the velocity of a casing that a string brakes, 1/s. With a slower decay a blow would hardly brake
/// the casing, and in time it would reach speeds and distances whose rounding exceeds the resolution of guards.
const SLOWEST_STRING: f64 = 10.0;

/// Least mass of a casing, as a share of the bit's. If a light body is tied to a heavy one, the modes lose a digit for
/// each decade of the mass ratio. Down to this limit, the ledger of every preset closes to 1e-10 of its turnover.
const LIGHTEST_CASING: f64 = 1e-4;

/// The error that refuses the `value` of the parameter with this accessor.
fn refuse<T>(
    field: fn(&mut Parameters) -> &mut T,
    value: f64,
    allowed: String,
) -> Result<(), ParameterError> {
    Err(ParameterError { name: name_of(field), value, allowed })
}

impl Parameters {
    /// Checks every parameter against its domain, except sections and ports that the scene does not read.
    ///
    /// # Errors
    ///
    /// The first parameter outside its domain: its name, its value and the allowed range.
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
        refuse(|p| &mut p.material.youngs_modulus, value, allowed)
    }

    fn check_casing(&self) -> Result<(), ParameterError> {
        if !self.has_casing() {
            return Ok(());
        }
        let (chuck, mass) = (&self.chuck, self.casing_mass());
        let least = LIGHTEST_CASING * self.bit_mass();
        if mass < least {
            let part = format!("({LIGHTEST_CASING:e} of the bit's mass)");
            if self.casing.segments.is_empty() {
                let allowed = format!("0, or at least {least:.4e} {part}");
                return refuse(|p| &mut p.casing.mass, mass, allowed);
            }
            let allowed = format!("larger, so that the casing has at least {least:.4e} kg {part}");
            return refuse(
                |p| &mut p.casing.segments.stored_mut(0).area,
                self.casing.segments[0].area,
                allowed,
            );
        }
        if chuck.idle_travel >= chuck.travel {
            let allowed = format!("below chuck.travel, {}", DisplayNumber(chuck.travel));
            return refuse(|p| &mut p.chuck.idle_travel, chuck.idle_travel, allowed);
        }
        let (weakest, impedance) = (SLOWEST_STRING * mass, self.casing.impedance);
        if impedance != 0.0 && impedance < weakest {
            let weakest = DisplayNumber(weakest);
            let allowed = format!("0, or at least {weakest} (the casing's mass times 10 per s)");
            return refuse(|p| &mut p.casing.impedance, impedance, allowed);
        }
        Ok(())
    }

    /// Checks that both chambers have a positive volume where the piston starts.
    fn check_cylinder(&self) -> Result<(), ParameterError> {
        let (air, drive) = (&self.air, &self.drive);
        let no_volume = air.cylinder + air.drive.dead_volume / drive.area_drive;
        if drive.source != Source::Air || self.contact.initial_gap < no_volume {
            return Ok(());
        }
        let allowed = format!(
            "below {}, where the drive chamber has no volume left (air.cylinder, air.drive.dead_volume)",
            DisplayNumber(no_volume)
        );
        refuse(|p| &mut p.contact.initial_gap, self.contact.initial_gap, allowed)
    }

    /// The largest allowed impedance of a line at the piston, N s/m. With this impedance, the line brakes the piston,
    /// relative to the body that takes the drive's reaction, in the time in which a wave crosses the piston. The force
    /// of the drive is distributed like the mass, and so cannot represent faster braking.
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

    /// Checks that a line is not combined with air, and that its braking takes longer than a wave takes to cross the
    /// piston.
    fn check_line(&self) -> Result<(), ParameterError> {
        let (value, largest) = (self.drive.impedance, self.most_impedance());
        let allowed = match self.drive.source {
            _ if value == 0.0 => return Ok(()),
            Source::Air => {
                "0 where air drives the piston (drive.source), whose drag is air.drag".into()
            }
            _ if value <= largest => return Ok(()),
            _ => format!(
                "at most {}, with which the line brakes as fast as a wave passes the piston",
                DisplayNumber(largest)
            ),
        };
        refuse(|p| &mut p.drive.impedance, value, allowed)
    }

    /// These parameters, with the values of the tunable ones taken from `target`.
    ///
    /// # Errors
    /// A parameter is out of its domain, or a fixed parameter differs.
    pub(crate) fn retuned(&self, target: &Self) -> Result<Self, ParameterError> {
        let mut tuned = *self;
        for row in PARAMETERS.iter() {
            let [before, value] = [self, target].map(|p| row.slot.read(p));
            if row.tunable {
                row.check(value)?;
                row.slot.write(&mut tuned, value);
            } else if value != before {
                let allowed = format!("{}: it is fixed once the scene runs", DisplayNumber(before));
                return Err(ParameterError { name: row.name, value, allowed });
            }
        }
        Ok(tuned)
    }

    /// Checks that sleeves fit their rods, and that bodies and mesh can carry a wave down the string.
    ///
    /// # Errors
    /// A parameter is out of its domain.
    fn check_drill(&self) -> Result<(), ParameterError> {
        let Drill { rods, shank, rod, coupling, joint } = self.drill;
        if rods == 0 {
            return Ok(());
        }
        let limit = rod.length.min(2.0 * shank.length);
        if coupling.length >= limit {
            let allowed =
                format!("below {}, the rod's length and twice the shank's", DisplayNumber(limit));
            return refuse(|p| &mut p.drill.coupling.length, coupling.length, allowed);
        }
        if self.fidelity == Fidelity::Rigid {
            let allowed = "0 with rigid bodies, which carry no wave".into();
            return refuse(|p| &mut p.drill.rods, rods as f64, allowed);
        }
        let softest = SOFTEST_JOINT * self.material.youngs_modulus * rod.area / rod.length;
        if self.drill.loose() > 0 && joint.stiffness < softest {
            let softest = DisplayNumber(softest);
            let allowed =
                format!("0, or at least {softest} ({SOFTEST_JOINT} of a rod's own stiffness)");
            return refuse(|p| &mut p.drill.joint.stiffness, joint.stiffness, allowed);
        }
        self.check_string_mesh()
    }

    /// Length of the wave that a blow sends, m: twice that of the piston.
    pub(crate) fn blow_wave(&self) -> f64 {
        2.0 * self.sections(Body::Piston).length()
    }

    /// Longest span of splines of this degree with which the wave of a blow keeps its shape along the string, m.
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
        let [wave, length] = [wave, length].map(DisplayNumber);
        let why =
            format!("so that a wave of {wave} m keeps its shape along a string of {length} m");
        if needed <= MAX_ELEMENTS as f64 {
            let allowed = format!("at least {needed}, {why}");
            refuse(|p| &mut p.bit.elements, self.bit.elements as f64, allowed)
        } else if degree < MAX_DEGREE {
            refuse(|p| &mut p.mesh.degree, degree as f64, format!("above {degree}, {why}"))
        } else {
            refuse(|p| &mut p.drill.rods, self.drill.rods as f64, format!("fewer, {why}"))
        }
    }
}
