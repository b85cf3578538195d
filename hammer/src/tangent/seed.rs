//! What can be varied.

use crate::physics::inputs::Input;
use crate::physics::parameters::Parameters;

/// Declares the parameters by which one may differentiate.
macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident = $text:literal: $($at:ident).+,)*) => {
        /// A real parameter by which the motion is differentiated.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Parameter {
            $($(#[$doc])* $name,)*
        }

        impl Parameter {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its dotted name, as in the FMU.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)*
                }
            }

            /// Where it stands.
            pub fn slot(self, parameters: &mut Parameters) -> &mut f64 {
                match self {
                    $(Self::$name => &mut parameters.$($at).+,)*
                }
            }
        }
    };
}

quantities! {
    /// `E`.
    YoungsModulus = "material.youngs_modulus": material.youngs_modulus,
    /// `rho`.
    Density = "material.density": material.density,
    /// `beta`.
    DampingTime = "material.damping_time": material.damping_time,
    /// `A`.
    CrossSection = "cross_section": cross_section,
    /// `Lp`.
    PistonLength = "piston.length": piston.length,
    /// Uniform velocity at the start.
    PistonVelocity = "piston.initial_velocity": piston.initial_velocity,
    /// `Lb`.
    BitLength = "bit.length": bit.length,
    /// `KC`.
    ContactStiffness = "contact.stiffness": contact.stiffness,
    /// `g0`.
    InitialGap = "contact.initial_gap": contact.initial_gap,
    /// `KR`.
    RockStiffness = "rock.stiffness": rock.stiffness,
    /// `gamma`.
    UnloadingRatio = "rock.unloading_ratio": rock.unloading_ratio,
    /// `CR`.
    RockViscosity = "rock.viscosity": rock.viscosity,
    /// `WR`.
    EnergyBarrier = "rock.energy_barrier": rock.energy_barrier,
    /// `vs`.
    StandstillSpeed = "rock.standstill_speed": rock.standstill_speed,
    /// `dps`: it only chooses between branches, and has no derivative but at a tie.
    StandstillPenetration = "rock.standstill_penetration": rock.standstill_penetration,
    /// `F0`.
    DriveAmplitude = "drive.amplitude": drive.amplitude,
    /// `D1`.
    DriveStroke = "drive.stroke": drive.stroke,
    /// Area on which `drive_pressure` acts.
    AreaDrive = "drive.area_drive": drive.area_drive,
    /// Area on which `return_pressure` acts.
    AreaReturn = "drive.area_return": drive.area_return,
    /// `G`.
    Gravity = "gravity": gravity,
}

/// What a tangent is the derivative by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seed {
    /// A parameter.
    Parameter(Parameter),
    /// An input, from where the tangent starts on: a constant added to it (order 0), a slope
    /// (order 1), or a higher derivative there.
    Input(Input, usize),
    /// Nothing but the state at the start of the tangent.
    State,
}

impl Seed {
    /// The parameter or (constant) input of this name.
    pub fn named(name: &str) -> Option<Self> {
        let parameter = Parameter::ALL.iter().find(|p| p.name() == name);
        let input = Input::ALL.into_iter().find(|i| i.name() == name);
        parameter.map(|p| Self::Parameter(*p)).or(input.map(|i| Self::Input(i, 0)))
    }
}
