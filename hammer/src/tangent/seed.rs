//! What can be varied.

use crate::quantities::inputs::Input;
use crate::quantities::parameters::Parameters;
use crate::quantities::sections::Body;

/// Sections of a body, from top to bottom.
macro_rules! places {
    ($($name:ident = $k:literal,)*) => {
        /// Which section of a body, from top to bottom.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[expect(missing_docs, reason = "they are counted")]
        pub enum Ordinal {
            $($name = $k - 1,)*
        }

        impl Ordinal {
            fn text(self, body: Body, dimension: Dimension) -> &'static str {
                match (self, body, dimension) {
                    $(
                        (Self::$name, Body::Piston, Dimension::Length) => concat!("piston.segment[", $k, "].length"),
                        (Self::$name, Body::Piston, Dimension::Area) => concat!("piston.segment[", $k, "].area"),
                        (Self::$name, Body::Bit, Dimension::Length) => concat!("bit.segment[", $k, "].length"),
                        (Self::$name, Body::Bit, Dimension::Area) => concat!("bit.segment[", $k, "].area"),
                    )*
                }
            }
        }
    };
}

places! {
    First = 1,
    Second = 2,
    Third = 3,
    Fourth = 4,
    Fifth = 5,
    Sixth = 6,
    Seventh = 7,
    Eighth = 8,
}

/// A dimension of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// m.
    Length,
    /// m2.
    Area,
}

/// Declares the parameters by which one may differentiate.
macro_rules! quantities {
    (
        $($(#[$doc:meta])* $name:ident = $text:literal: $($at:ident).+,)*
        ; sections: $($body:ident $place:ident,)*
    ) => {
        /// A real parameter by which the motion is differentiated.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Parameter {
            $($(#[$doc])* $name,)*
            /// Length or area of a body's section; read where the body has that many.
            Section(Body, Ordinal, Dimension),
        }

        impl Parameter {
            /// All of them.
            pub const ALL: &[Self] = &[
                $(Self::$name,)*
                $(
                    Self::Section(Body::$body, Ordinal::$place, Dimension::Length),
                    Self::Section(Body::$body, Ordinal::$place, Dimension::Area),
                )*
            ];

            /// Its dotted name, as in the FMU.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)*
                    Self::Section(body, place, dimension) => place.text(body, dimension),
                }
            }

            /// Where it stands.
            pub fn slot(self, parameters: &mut Parameters) -> &mut f64 {
                let (body, place, dimension) = match self {
                    $(Self::$name => return &mut parameters.$($at).+,)*
                    Self::Section(body, place, dimension) => (body, place, dimension),
                };
                let list = match body {
                    Body::Piston => &mut parameters.piston.segment,
                    Body::Bit => &mut parameters.bit.segment,
                };
                let segment = &mut list[place as usize];
                match dimension {
                    Dimension::Length => &mut segment.length,
                    Dimension::Area => &mut segment.area,
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
    ; sections:
    Piston First, Piston Second, Piston Third, Piston Fourth,
    Piston Fifth, Piston Sixth, Piston Seventh, Piston Eighth,
    Bit First, Bit Second, Bit Third, Bit Fourth,
    Bit Fifth, Bit Sixth, Bit Seventh, Bit Eighth,
}

impl Parameter {
    /// True if a scene reads it: a body with sections of its own reads neither its length nor the
    /// common cross section, and of sections as many as it has.
    pub fn is_read(self, parameters: &Parameters) -> bool {
        let sections = |body: Body| match body {
            Body::Piston => parameters.piston.segments,
            Body::Bit => parameters.bit.segments,
        };
        match self {
            Self::PistonLength => sections(Body::Piston) == 0,
            Self::BitLength => sections(Body::Bit) == 0,
            Self::CrossSection => Body::ALL.into_iter().any(|body| sections(body) == 0),
            Self::Section(body, place, _) => (place as usize) < sections(body),
            _ => true,
        }
    }
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
