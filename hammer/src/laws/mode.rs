//! The discrete state of the hybrid automaton.

use crate::quantities::sections::MAX_RODS;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Mode of the bit/rock law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum RockMode {
    /// FF: the bit is off the rock.
    FreeFlight,
    /// DFC: loading, elastic and viscous.
    DissipativeForward,
    /// FC: loading, elastic.
    Forward,
    /// BC: unloading.
    Backward,
    /// SS: on the unloading line, until standstill ends.
    Standstill,
}

/// Direction of the pressure relay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Relay {
    /// `alpha = +1`: the piston is driven down.
    Drive,
    /// `alpha = -1`: the piston is returned.
    Return,
}

impl Relay {
    /// `alpha`.
    pub fn sign(self) -> f64 {
        match self {
            Self::Drive => 1.0,
            Self::Return => -1.0,
        }
    }

    /// The other direction.
    pub(crate) fn turned(self) -> Self {
        match self {
            Self::Drive => Self::Return,
            Self::Return => Self::Drive,
        }
    }
}

/// The tie of bit and casing in the chuck.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Chuck {
    /// The bit hangs free in its travel; also where there is no casing.
    #[default]
    Open,
    /// The casing's shoulder presses on the bit.
    Shoulder,
    /// The retaining ring holds the bit.
    Ring,
}

/// The ties of a drill string's loose joints, from the shank down; all others are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Joints(pub [Chuck; MAX_RODS]);

impl Joints {
    /// The rods press on each other everywhere.
    pub const CLOSED: Self = Self([Chuck::Shoulder; MAX_RODS]);
}

/// A chamber of gas beside the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Chamber {
    /// Above the piston: it drives it down.
    Drive,
    /// Below: it returns it.
    Return,
}

impl Chamber {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Drive, Self::Return];
}

impl fmt::Display for Chamber {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Drive => "drive",
            Self::Return => "return",
        })
    }
}

/// A port of a chamber, opened and closed by the piston.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Port {
    /// Gas comes in.
    Supply,
    /// Gas goes out.
    Exhaust,
}

impl Port {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Supply, Self::Exhaust];
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Supply => "supply",
            Self::Exhaust => "exhaust",
        })
    }
}

/// The whole discrete state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mode {
    /// Piston/bit contact closed.
    pub closed: bool,
    /// Bit/rock law.
    pub rock: RockMode,
    /// Pressure relay.
    pub relay: Relay,
    /// Tie of bit and casing.
    pub chuck: Chuck,
    /// True while the bit hangs out so far that the drive is vented: `F_A = 0`.
    pub vented: bool,
    /// Ties of the rods.
    pub joints: Joints,
}

impl Mode {
    /// At the start of a scene, with the contact open and the relay driving.
    pub const fn starting(rock: RockMode, chuck: Chuck) -> Self {
        let joints = Joints::CLOSED;
        Self { closed: false, rock, relay: Relay::Drive, chuck, vented: false, joints }
    }
}

impl fmt::Display for Mode {
    /// In the words of the paper: `contact closed, rock in DFC, drive driving`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let contact = if self.closed { "closed" } else { "open" };
        let rock = match self.rock {
            RockMode::FreeFlight => "FF",
            RockMode::DissipativeForward => "DFC",
            RockMode::Forward => "FC",
            RockMode::Backward => "BC",
            RockMode::Standstill => "SS",
        };
        let relay = match self.relay {
            Relay::Drive => "downward",
            Relay::Return => "upward",
        };
        write!(f, "contact {contact}, rock in {rock}, drive {relay}")?;
        f.write_str(match self.chuck {
            Chuck::Open => "",
            Chuck::Shoulder => ", chuck on its shoulder",
            Chuck::Ring => ", chuck on its ring",
        })?;
        f.write_str(if self.vented { ", drive vented" } else { "" })?;
        for (tie, joint) in self.joints.0.iter().zip(1..) {
            match tie {
                Chuck::Shoulder => Ok(()),
                Chuck::Open => write!(f, ", joint {joint} open"),
                Chuck::Ring => write!(f, ", joint {joint} pulling"),
            }?;
        }
        Ok(())
    }
}
