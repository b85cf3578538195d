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

/// A tie of two bodies; its law is in `tie.rs`.
///
/// | tie | upper | lower | stiffness | viscosity | travel |
/// |---|---|---|---|---|---|
/// | contact | piston | bit or shank | `KC` | 0 | none: it never pulls. `x` is the gap `g`, its guards are Q11 |
/// | chuck | casing | bit or shank | `ks` | `cs` | from its shoulder to its ring |
/// | joint | shank or rod | next rod | `kj` | `beta kj` | slack of the thread; 0: it holds both ways |
/// | string | the ground | casing | 0 | `Zs` | 0: an endless string is a dashpot |
///
/// For rigid bodies `KC` is in series with the bodies' own compliance
/// ([`Parameters::meeting_stiffness`](crate::Parameters::meeting_stiffness)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Tie {
    /// Piston on bit or shank.
    Contact,
    /// Casing on bit or shank, by its shoulder. Its retaining ring lifts them.
    Chuck,
    /// Casing on the drill string above it.
    String,
    /// Rod on rod, counted from the shank down, from 0.
    Joint(u8),
}

/// State of a tie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TieState {
    /// It carries no force.
    #[default]
    Open,
    /// Its bodies press on each other.
    Pressed,
    /// Its bodies pull on each other.
    Pulled,
}

/// The states of all ties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Ties([TieState; Tie::COUNT]);

impl Tie {
    /// Most ties of a scene.
    pub const COUNT: usize = 3 + MAX_RODS;

    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let joints = (0..).take(MAX_RODS).map(Self::Joint);
        [Self::Contact, Self::Chuck, Self::String].into_iter().chain(joints)
    }

    /// The ties whose forces are outputs.
    pub const REPORTED: [Self; 2] = [Self::Contact, Self::Chuck];

    /// The bodies above (none: the ground) and below it. The piston is body 0, what it strikes body 1, and rods
    /// follow; `last` is the casing, if there is one.
    pub(crate) fn ends(self, last: usize) -> (Option<usize>, usize) {
        match self {
            Self::Contact => (Some(0), 1),
            Self::Chuck => (Some(last), 1),
            Self::String => (None, last),
            Self::Joint(joint) => (Some(usize::from(joint) + 1), usize::from(joint) + 2),
        }
    }

    /// True if its dashpot is proportional to its spring, as the bodies' own damping is. The modes of what it joins
    /// then stay real.
    pub(crate) fn joins_modes(self) -> bool {
        matches!(self, Self::Joint(_))
    }

    /// Its index among all ties.
    pub(crate) const fn index(self) -> usize {
        match self {
            Self::Contact => 0,
            Self::Chuck => 1,
            Self::String => 2,
            Self::Joint(joint) => 3 + joint as usize,
        }
    }

    /// Writes the event of entering a state, as the paper does for the contact.
    pub(crate) fn write_event(self, to: TieState, f: &mut fmt::Formatter) -> fmt::Result {
        match (self, to) {
            (Self::Contact, _) => f.write_str("Q11"),
            (_, TieState::Open) => write!(f, "{self} opens"),
            (Self::Chuck, TieState::Pressed) => f.write_str("shoulder meets"),
            (Self::Chuck, TieState::Pulled) => f.write_str("ring meets"),
            (_, TieState::Pressed) => write!(f, "{self} presses"),
            (_, TieState::Pulled) => write!(f, "{self} pulls"),
        }
    }
}

impl fmt::Display for Tie {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Contact => f.write_str("contact"),
            Self::Chuck => f.write_str("chuck"),
            Self::String => f.write_str("string"),
            Self::Joint(joint) => write!(f, "joint {}", joint + 1),
        }
    }
}

impl Ties {
    /// The start of a scene without a casing: the piston hangs free, and all rods press. Ties that a scene lacks keep
    /// these states.
    pub const START: Self = {
        let mut states = [TieState::Pressed; Tie::COUNT];
        states[Tie::Contact.index()] = TieState::Open;
        states[Tie::Chuck.index()] = TieState::Open;
        Self(states)
    };

    /// The state of a tie.
    pub fn of(&self, tie: Tie) -> TieState {
        self.0.get(tie.index()).copied().unwrap_or_default()
    }

    /// The same states but for one tie.
    #[must_use]
    pub fn with(mut self, tie: Tie, state: TieState) -> Self {
        if let Some(slot) = self.0.get_mut(tie.index()) {
            *slot = state;
        }
        self
    }

    pub(crate) fn hold(&self, tie: Tie) -> bool {
        self.of(tie) != TieState::Open
    }
}

impl fmt::Display for Ties {
    /// Lists the ties below the contact whose state is unusual.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self.of(Tie::Chuck) {
            TieState::Open => "",
            TieState::Pressed => ", chuck on its shoulder",
            TieState::Pulled => ", chuck on its ring",
        })?;
        for tie in (0..).take(MAX_RODS).map(Tie::Joint) {
            match self.of(tie) {
                TieState::Pressed => Ok(()),
                TieState::Open => write!(f, ", {tie} open"),
                TieState::Pulled => write!(f, ", {tie} pulling"),
            }?;
        }
        Ok(())
    }
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
    /// Both chambers.
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
    /// Both ports.
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
    /// States of the ties.
    pub ties: Ties,
    /// Bit/rock law.
    pub rock: RockMode,
    /// Pressure relay.
    pub relay: Relay,
    /// True while the bit hangs out so far that the drive is vented: `F_A = 0`.
    pub vented: bool,
}

impl Mode {
    /// The start of a scene without a casing, with the relay driving.
    pub const fn starting(rock: RockMode) -> Self {
        Self { ties: Ties::START, rock, relay: Relay::Drive, vented: false }
    }

    /// The same mode with another state of one tie.
    #[must_use]
    pub fn with(self, tie: Tie, state: TieState) -> Self {
        Self { ties: self.ties.with(tie, state), ..self }
    }

    /// True while piston and bit touch.
    pub fn closed(&self) -> bool {
        self.ties.hold(Tie::Contact)
    }
}

impl fmt::Display for Mode {
    /// Written in the paper's words: `contact closed, rock in DFC, drive driving`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let contact = if self.closed() { "closed" } else { "open" };
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
        let vented = if self.vented { ", drive vented" } else { "" };
        write!(f, "contact {contact}, rock in {rock}, drive {relay}{}{vented}", self.ties)
    }
}
