//! Events, and the guards that detect them.
//!
//! A [`Guard`] is a quantity of the motion that triggers an [`Event`] where it passes a level in
//! one direction. Each law lists its own guards, in `tie.rs`, `rock.rs`, `drive.rs` and `air.rs`.

use crate::laws::mode::{Chamber, Port, Relay, Tie, TieState};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The events of the rock law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RockEvent {
    /// Q1: the bit reaches the rock.
    Touch,
    /// Q2: the tip's velocity falls through 0 in DFC.
    DissipativeTurn,
    /// Q3: the viscous work reaches the barrier.
    Barrier,
    /// Q4: the tip's velocity falls through 0 in FC.
    Turn,
    /// Q5: the tip leaves the rock.
    LiftOff,
    /// Q6: the tip's velocity rises through 0 in BC.
    Return,
    /// Q7: the tip's velocity rises through `vs` in SS.
    Restart,
    /// Q8: the tip's velocity falls through `-vs` in SS.
    Retreat,
    /// The tip is lifted off the rock in SS.
    StandstillLiftOff,
}

/// An event that ends a mode. Simultaneous events are handled in the order: contact, other
/// ties, rock, drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A tie enters this state: its bodies part or meet. For the contact this is Q11.
    Tie(Tie, TieState),
    /// Q1 to Q8: the rock law changes its mode.
    Rock(RockEvent),
    /// Q9 and Q10: the relay switches to this direction.
    Relay(Relay),
    /// The piston passes a port of a chamber.
    Port {
        /// The chamber.
        chamber: Chamber,
        /// The port.
        port: Port,
        /// True if it opens, false if it closes.
        opens: bool,
    },
    /// The piston passes the position where a port of an air chamber is fully open.
    Opening {
        /// The chamber.
        chamber: Chamber,
        /// The port.
        port: Port,
        /// True if it is fully open from here on, false if it narrows.
        full: bool,
    },
    /// Venting of the drive begins (true) or ends (false). The drive is vented while the bit hangs out.
    Vent(bool),
    /// The piston enters (true) or leaves (false) the end of an air hammer's cylinder.
    End(bool),
}

impl Event {
    /// Q11 when the piston meets what it strikes.
    pub const CLOSING: Self = Self::Tie(Tie::Contact, TieState::Pressed);
    /// Q11 when the piston leaves what it strikes.
    pub const OPENING: Self = Self::Tie(Tie::Contact, TieState::Open);

    /// True if this is Q11.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Tie(Tie::Contact, _))
    }

    /// Position in the order of simultaneous events.
    pub(crate) fn rank(self) -> u8 {
        match self {
            Self::Tie(Tie::Contact, _) => 0,
            Self::Tie(..) => 1,
            Self::Rock(_) => 2,
            Self::Relay(_)
            | Self::Port { .. }
            | Self::Opening { .. }
            | Self::Vent(_)
            | Self::End(_) => 3,
        }
    }
}

/// Writes the name of the event in the paper, `Q1` to `Q11`, or a few words for an event that the paper does not have.
impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Port { chamber, port, opens } => {
                let verb = if *opens { "opens" } else { "closes" };
                return write!(f, "{chamber} {port} {verb}");
            }
            Self::Opening { chamber, port, full } => {
                let verb = if *full { "is wholly open" } else { "narrows" };
                return write!(f, "{chamber} {port} {verb}");
            }
            Self::Tie(tie, to) => return tie.write_event(*to, f),
            Self::Vent(true) => "drive vents",
            Self::Vent(false) => "drive acts again",
            Self::End(true) => "piston enters the cylinder's end",
            Self::End(false) => "piston leaves the cylinder's end",
            Self::Relay(Relay::Return) => "Q9",
            Self::Relay(Relay::Drive) => "Q10",
            Self::Rock(event) => match event {
                RockEvent::Touch => "Q1",
                RockEvent::DissipativeTurn => "Q2",
                RockEvent::Barrier => "Q3",
                RockEvent::Turn => "Q4",
                RockEvent::LiftOff => "Q5",
                RockEvent::Return => "Q6",
                RockEvent::Restart => "Q7",
                RockEvent::Retreat => "Q8",
                RockEvent::StandstillLiftOff => "lift",
            },
        })
    }
}

/// A set of bodies of a hammer. They are numbered from the piston (0) down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Bodies(u16);

impl Bodies {
    /// The piston.
    pub const PISTON: Self = Self::one(0);
    /// The body that the piston strikes: the bit or the shank.
    pub const STRUCK: Self = Self::one(1);

    /// The set of one body.
    pub const fn one(place: usize) -> Self {
        Self(1 << place)
    }

    /// The set of the first `count` bodies.
    pub fn first(count: usize) -> Self {
        (0..count).map(Self::one).fold(Self::default(), Self::and)
    }

    /// The union of two sets.
    #[must_use]
    pub fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// The bodies of this set that are not in the other.
    #[must_use]
    pub fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// True if the sets intersect.
    pub fn meet(self, others: Self) -> bool {
        self.0 & others.0 != 0
    }

    /// True if this set is a subset of the other.
    pub fn within(self, others: Self) -> bool {
        self.without(others) == Self::default()
    }

    /// True if the set contains the body with this number.
    pub fn have(self, place: usize) -> bool {
        self.meet(Self::one(place))
    }
}

/// A displacement of the bodies: a weighted sum of nodal displacements `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Displacement {
    /// `p = w1.u`: the bit/rock interface.
    Tip,
    /// `x` of a tie: the displacement of the lower body's upper face relative to the upper body's lower face. For the
    /// contact it is the gap `g = w2.u + g0`.
    Tie(Tie),
    /// `vr`: the mean displacement of the piston minus that of the body that takes the drive's reaction, minus `g0`.
    Relative,
    /// `y`: the mean displacement of the piston minus that of the body that it strikes, minus `g0`.
    OverStruck,
    /// Displacement of the upper face of a body.
    Top(usize),
    /// Mean displacement of a set of bodies.
    Mean(Bodies),
}

impl Displacement {
    /// Mean displacement of the piston.
    pub const PISTON: Self = Self::Mean(Bodies::PISTON);
    /// Mean displacement of the body that the piston strikes.
    pub const STRUCK: Self = Self::Mean(Bodies::STRUCK);
}

/// The direction in which a guard passes its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From below.
    Rising,
    /// From above.
    Falling,
}

impl Direction {
    /// The opposite direction.
    pub(crate) fn reverse(self) -> Self {
        match self {
            Self::Rising => Self::Falling,
            Self::Falling => Self::Rising,
        }
    }

    /// +1 or -1: the factor that turns this guard into a rising one.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// The direction in which the piston's relative position moves when it opens a port.
pub(crate) fn opening(chamber: Chamber, port: Port) -> Direction {
    if (chamber == Chamber::Drive) == (port == Port::Exhaust) {
        Direction::Rising
    } else {
        Direction::Falling
    }
}

/// A guard: it triggers `event` where a displacement or its rate passes `level` in `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    /// The displacement.
    pub displacement: Displacement,
    /// 0 for the displacement itself, 1 for its rate.
    pub order: usize,
    /// The direction.
    pub direction: Direction,
    /// The level, m or m/s.
    pub level: f64,
    /// The event.
    pub event: Event,
}
