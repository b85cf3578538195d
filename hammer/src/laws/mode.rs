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
    /// SS: at rest on the unloading line, until a guard ends standstill.
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
/// | contact | piston | bit or shank | `KC` | 0 | infinite: it never pulls. `x` is the gap `g`, the guards are Q11 |
/// | chuck | casing | bit or shank | `ks` | `cs` | from the shoulder to the retaining ring |
/// | joint | shank or rod | next rod | `kj` | `beta kj` | slack of the thread; with 0 it carries push and pull |
/// | string | the ground | casing | 0 | `Zs` | 0: an endless string acts as a dashpot at all times |
///
/// For rigid bodies `KC` is in series with the bodies' own compliance
/// ([`Parameters::meeting_stiffness`](crate::Parameters::meeting_stiffness)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Tie {
    /// The piston on the bit or the shank.
    Contact,
    /// The casing on the bit or the shank: its shoulder presses on them, its retaining ring lifts them.
    Chuck,
    /// The casing on the drill string above it.
    String,
    /// A rod on the shank or rod above it; joints are counted from the shank down, from 0.
    Joint(u8),
}

/// State of a tie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TieState {
    /// The tie carries no force.
    #[default]
    Open,
    /// The tie's bodies press on each other.
    Pressed,
    /// The tie's bodies pull on each other.
    Pulled,
}

/// The states of all ties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Ties([TieState; Tie::COUNT]);

impl Tie {
    /// Largest number of ties of a scene.
    pub const COUNT: usize = 3 + MAX_RODS;

    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let joints = (0..).take(MAX_RODS).map(Self::Joint);
        [Self::Contact, Self::Chuck, Self::String].into_iter().chain(joints)
    }

    /// The ties whose forces are outputs.
    pub const REPORTED: [Self; 2] = [Self::Contact, Self::Chuck];

    /// The bodies above and below the tie; `None` above means the ground. The piston is body 0, the body that it
    /// strikes is body 1, and the rods follow; `last` is the casing, if there is one.
    pub(crate) fn ends(self, last: usize) -> (Option<usize>, usize) {
        match self {
            Self::Contact => (Some(0), 1),
            Self::Chuck => (Some(last), 1),
            Self::String => (None, last),
            Self::Joint(joint) => (Some(usize::from(joint) + 1), usize::from(joint) + 2),
        }
    }

    /// True if the tie's dashpot is proportional to its spring, as the bodies' own damping is. Real modes of the
    /// bodies that it joins then exist.
    pub(crate) fn joins_modes(self) -> bool {
        matches!(self, Self::Joint(_))
    }

    /// Index of the tie among all ties.
    pub(crate) const fn index(self) -> usize {
        match self {
            Self::Contact => 0,
            Self::Chuck => 1,
            Self::String => 2,
            Self::Joint(joint) => 3 + joint as usize,
        }
    }

    /// Writes the name of the event in which the tie enters a state; for the contact it is the paper's `Q11`.
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
    /// The states at the start of a scene without a casing: the piston is free, and all rods press on each other. Ties
    /// that a scene does not have keep these states.
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

    /// These states with another state of one tie.
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
    /// Lists the chuck, unless it is open, and the joints that do not press.
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
    /// Above the piston; its pressure drives the piston down.
    Drive,
    /// Below the piston; its pressure returns the piston.
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
    /// The mode at the start of a scene without a casing. The relay drives the piston down.
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
    /// Writes the mode in the paper's words, as in `contact closed, rock in DFC, drive downward`.
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
