//! A hammer and its inputs, in plain numbers. SI units.
//!
//! The oracles read nothing else, so that they need not know an engine. Whoever compares an engine with them
//! describes the common problem here.

use serde::{Deserialize, Serialize};

/// A uniform part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Length, m.
    pub length: f64,
    /// Cross section, m2.
    pub area: f64,
    /// Number of equal elements.
    pub elements: usize,
}

/// A bar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Its sections, top to bottom.
    pub sections: Vec<Section>,
    /// Uniform velocity at the start, m/s, positive downward.
    pub velocity: f64,
}

/// How the bodies are modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fidelity {
    /// One unknown each.
    Rigid,
    /// Linear elements with consistent mass.
    Elastic,
    /// B-splines of this degree, with consistent mass.
    Spline(usize),
}

impl Fidelity {
    /// Number of unknowns of a body of sections of so many elements.
    pub fn unknowns(self, sections: &[Section]) -> usize {
        let elements: usize = sections.iter().map(|section| section.elements).sum();
        match self {
            Self::Rigid => 1,
            Self::Elastic => elements + 1,
            Self::Spline(degree) => elements + sections.len() * (degree - 1) + 1,
        }
    }
}

/// The bit/rock law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RockLaw {
    /// Loading stiffness `KR`, N/m.
    pub stiffness: f64,
    /// Unloading-to-loading stiffness ratio `gamma`.
    pub ratio: f64,
    /// Viscosity `CR`, N s/m.
    pub viscosity: f64,
    /// Energy barrier `WR`, J.
    pub barrier: f64,
    /// Standstill speed `vs`, m/s.
    pub standstill_speed: f64,
    /// Standstill penetration `dps`, m.
    pub standstill_penetration: f64,
    /// True if a tip that turns down again first goes back along the unloading line.
    pub reloads: bool,
}

/// The air of two chambers; drive and return, or supply and exhaust.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLaw {
    /// `A_drive` and `A_return`, m2.
    pub areas: [f64; 2],
    /// `V_d0` and `V_r0`, m3.
    pub dead_volumes: [f64; 2],
    /// `s`, m.
    pub cylinder: f64,
    /// Relative positions at which the ports begin to open: supply and exhaust of each chamber, m.
    pub edges: [[f64; 2]; 2],
    /// Travel from there to where they are fully open, m.
    pub height: f64,
    /// Areas of a fully open supply and exhaust port, m2.
    pub ports: [f64; 2],
    /// Discharge coefficient.
    pub discharge: f64,
    /// Opening between the chambers, m2.
    pub leakage: f64,
    /// Drag of the piston in its cylinder, N s/m.
    pub drag: f64,
    /// Temperature of the air outside, K.
    pub temperature: f64,
    /// Pressures of supply and exhaust, Pa.
    pub outside: [f64; 2],
    /// Relative error of the air in the engine: an engine with this error solves a scene that differs by as much.
    pub error: f64,
    /// Relative change of the pressures that act; 0, except to show the effect of such an error.
    pub off: [f64; 2],
}

/// Where the force on the piston comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// `F_A = alpha F0`, switched over a stroke.
    Relay {
        /// `F0`, N.
        amplitude: f64,
        /// `D1`, m.
        stroke: f64,
    },
    /// `F_A` is [`Input::Force`].
    Force,
    /// `F_A = p_drive A_drive - p_return A_return`.
    Pressure {
        /// `A_drive` and `A_return`, m2.
        areas: [f64; 2],
    },
    /// The pressure drive's force, with the pressures of air that flows through ports.
    Air(AirLaw),
}

impl Drive {
    /// Amplitude (N) and stroke (m) of the relay; zeros where there is none.
    pub fn relay(&self) -> [f64; 2] {
        match *self {
            Self::Relay { amplitude, stroke } => [amplitude, stroke],
            _ => [0.0; 2],
        }
    }
}

/// The threads between the bodies below the piston, all equal: pressed where faces meet, pulled at the end of the
/// slack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// Stiffness `kc`, N/m, both ways.
    pub stiffness: f64,
    /// Slack `s`, m; 0: it holds both ways and never opens.
    pub slack: f64,
}

/// A casing, the chuck in which it carries the bit, and the drill string above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Casing {
    /// Mass `Mc` of a rigid casing without sections, kg.
    pub mass: f64,
    /// Its sections, top to bottom: none of a rigid casing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<Section>,
    /// Impedance `Zs` of an endless drill string, N s/m.
    pub impedance: f64,
    /// Stiffness `ks` of shoulder and ring, N/m.
    pub stiffness: f64,
    /// Viscosity `cs` of shoulder and ring, N s/m.
    pub viscosity: f64,
    /// Travel of the bit from shoulder to ring, m.
    pub travel: f64,
    /// Travel at which the drive is vented, m; 0: never.
    pub idle_travel: f64,
}

/// An input. Its number is its place in arrays of six.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Input {
    /// `FS`, N.
    Feed,
    /// `F_A` of [`Drive::Force`], N.
    Force,
    /// Pressure that drives the piston down, Pa.
    DrivePressure,
    /// Pressure that returns it, Pa.
    ReturnPressure,
    /// Pressure of the supply of air, Pa.
    Supply,
    /// Pressure of its exhaust, Pa.
    Exhaust,
}

/// Everything at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Rigid or elastic bodies.
    pub fidelity: Fidelity,
    /// Young's modulus `E`, Pa.
    pub youngs_modulus: f64,
    /// Density `rho`, kg/m3.
    pub density: f64,
    /// Kelvin-Voigt damping time `beta`, s.
    pub damping_time: f64,
    /// The piston, and below it the bit, or a drill string that ends in it, top to bottom.
    pub bodies: Vec<Body>,
    /// What joins the bodies of a drill string; not read where there is a bit alone.
    pub coupling: Coupling,
    /// Stiffness through which they meet, N/m.
    pub contact_stiffness: f64,
    /// Initial gap `g0`, m.
    pub gap: f64,
    /// The bit/rock law.
    pub rock: RockLaw,
    /// The driving force.
    pub drive: Drive,
    /// Area of the struck body on which the return chamber presses, m2.
    pub anvil_area: f64,
    /// Impedance `Zd` of a line at the piston, N s/m.
    pub impedance: f64,
    /// Gravity `G`, m/s2.
    pub gravity: f64,
    /// Values of the inputs at the start, by [`Input`]; those of air are in its law.
    pub inputs: [f64; 4],
    /// The casing, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub casing: Option<Casing>,
    /// Height that a displacement (m) and a velocity (m/s) must exceed for a crossing to count. It is part of the
    /// problem, since a graze has no answer without it.
    pub resolutions: [f64; 2],
}

impl Scene {
    /// The inputs at the start, as rows of coefficients by [`Input`].
    pub fn rows<T: From<f64>>(&self) -> [Vec<T>; 6] {
        let [supply, exhaust] = match self.drive {
            Drive::Air(law) => law.outside,
            _ => [0.0; 2],
        };
        let [feed, force, drive, back] = self.inputs;
        [feed, force, drive, back, supply, exhaust].map(|value| vec![T::from(value)])
    }
}

/// Something that a host may do at an instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// From now on the input is a polynomial with this value and these derivatives.
    Set(Input, Vec<f64>),
    /// From now on the rock has another law, and the relay another amplitude. Positions and memory stay.
    Retune(RockLaw, Option<f64>),
}

/// Actions at their instants, s, ascending.
pub type Schedule = Vec<(f64, Action)>;

/// Stiffness of two uniform rigid bars in series with `penalty`, N/m, with `k = pi^2 E A Lmax / (4 (Lp + Lb) Lmin)`,
/// so that a collision lasts as long as waves make it.
pub fn rigid_meeting(penalty: f64, stretch: f64, [piston, bit]: [f64; 2]) -> f64 {
    let square = std::f64::consts::PI.powi(2);
    let bars = square * stretch * piston.max(bit) / (4.0 * (piston + bit) * piston.min(bit));
    1.0 / (1.0 / penalty + 1.0 / bars)
}
