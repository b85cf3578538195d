//! Events, and the guards that detect them.
//!
//! A [`Guard`] is a quantity of the motion that triggers an [`Event`] where it passes a level in
//! one direction. Each law lists its own guards, in `contact.rs`, `chuck.rs`, `rock.rs` and
//! `drive.rs`.

use crate::laws::mode::{Chamber, Chuck, Port, Relay};
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
    /// Q6: the tip's velocity rises through 0.
    Return,
    /// Q7: the tip's velocity rises through `vs`.
    Restart,
    /// Q8: the tip's velocity falls through `-vs`.
    Retreat,
    /// The tip is lifted off the rock out of standstill.
    StandstillLiftOff,
}

/// An event that ends a mode. Simultaneous events are handled in the order: contact, chuck, rock,
/// drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// Q11: the contact closes or opens.
    Contact,
    /// Q1 to Q8: the rock law changes its mode.
    Rock(RockEvent),
    /// Q9 and Q10: the relay turns to this direction.
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
    /// The piston passes where a port of an air chamber is wholly open.
    Opening {
        /// The chamber.
        chamber: Chamber,
        /// The port.
        port: Port,
        /// True if it is wholly open from here on, false if it narrows.
        full: bool,
    },
    /// A chamber's pressure reaches its level.
    Level(Chamber),
    /// Bit and casing part, or meet on the shoulder or the ring.
    Chuck(Chuck),
    /// The bit hangs out so far that the drive is vented, or no longer.
    Vent(bool),
    /// Two rods part, or meet at their faces (shoulder) or in the thread (ring).
    Joint {
        /// From the shank down, from 0.
        joint: u8,
        /// The tie from now on.
        to: Chuck,
    },
}

impl Event {
    /// Order among simultaneous events.
    pub(crate) fn rank(self) -> u8 {
        match self {
            Self::Contact => 0,
            Self::Chuck(_) | Self::Joint { .. } => 1,
            Self::Rock(_) => 2,
            Self::Relay(_)
            | Self::Port { .. }
            | Self::Opening { .. }
            | Self::Level(_)
            | Self::Vent(_) => 3,
        }
    }
}

/// The event function's name in the paper, `Q1` to `Q11`; `lift` for lift-off, which the paper
/// lacks; words for events of chambers.
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
            Self::Level(chamber) => return write!(f, "{chamber} level"),
            Self::Joint { joint, to } => {
                let verb = match to {
                    Chuck::Open => "opens",
                    Chuck::Shoulder => "presses",
                    Chuck::Ring => "pulls",
                };
                return write!(f, "joint {} {verb}", joint + 1);
            }
            Self::Contact => "Q11",
            Self::Chuck(Chuck::Open) => "chuck opens",
            Self::Chuck(Chuck::Shoulder) => "shoulder meets",
            Self::Chuck(Chuck::Ring) => "ring meets",
            Self::Vent(true) => "drive vents",
            Self::Vent(false) => "drive acts again",
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

/// A displacement functional of the bodies, a weighted sum of nodal displacements `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Displacement {
    /// `p = w1.u`: the bit/rock interface.
    Tip,
    /// `g = w2.u + g0`: the gap between the bodies.
    Gap,
    /// `vr`: the piston's mean displacement less that of the body it strikes, less `g0`.
    Relative,
    /// Displacement of the upper face that the piston strikes.
    BitTop,
    /// Mean displacement of bit and drill string.
    BitMean,
    /// Mean displacement of the piston.
    PistonMean,
    /// `x`: the bit's upper face relative to the casing's lower end.
    Chuck,
    /// Mean displacement of the casing.
    Casing,
    /// Displacement of its upper end, on which feed and drill string act.
    CasingTop,
    /// The piston's mean displacement less the casing's, less `g0`.
    InCasing,
    /// `x` of a loose joint: the lower rod's upper face relative to the upper rod's lower face.
    Joint(u8),
}

/// The quantity of a guard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A displacement, m.
    Displacement(Displacement),
    /// Its rate, m/s.
    Velocity(Displacement),
}

impl Quantity {
    /// The displacement, and the order of its derivative.
    pub(crate) fn parts(self) -> (Displacement, usize) {
        match self {
            Self::Displacement(d) => (d, 0),
            Self::Velocity(d) => (d, 1),
        }
    }
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

    /// +1 or -1: the factor that turns the guard into a rising one.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// Triggers `event` where `quantity` passes `level` in `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    /// The quantity.
    pub quantity: Quantity,
    /// The direction.
    pub direction: Direction,
    /// The level, m or m/s.
    pub level: f64,
    /// The event.
    pub event: Event,
}
