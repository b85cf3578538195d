//! The discrete part of the hammer: modes, events, guards, and the rock's memory.

use crate::linear::Real;
use serde::{Deserialize, Serialize};

/// Phase of the bit/rock law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rock {
    /// Free flight.
    FF,
    /// Dissipative forward contact.
    DFC,
    /// Forward contact.
    FC,
    /// Backward contact.
    BC,
    /// Standstill.
    SS,
}

/// Most joints of a scene.
pub const MAX_JOINTS: usize = 8;

/// The side on which a joint acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// It does not act, or does not exist.
    #[default]
    Open,
    /// The upper body stands on the lower one.
    Pressed,
    /// The lower body hangs in the upper one.
    Pulled,
}

/// The discrete state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// Piston and bit touch.
    pub closed: bool,
    /// Bit/rock phase.
    pub rock: Rock,
    /// The relay drives the piston downward.
    pub down: bool,
    /// The joints, top to bottom; in a casing the chuck comes first.
    pub joints: [Side; MAX_JOINTS],
    /// The bit hangs out beyond the idle travel.
    pub vented: bool,
}

impl Mode {
    /// A mode without joints, with the relay driving.
    pub fn bare(closed: bool, rock: Rock) -> Self {
        Self { closed, rock, down: true, joints: [Side::Open; MAX_JOINTS], vented: false }
    }

    /// Index of the linear system, of eight: contact closed or open, times no rock, `KR` and `CR`, `KR`, `gamma KR`.
    pub fn system_index(self) -> usize {
        let rock = match self.rock {
            Rock::FF => 0,
            Rock::DFC => 1,
            Rock::FC => 2,
            Rock::BC | Rock::SS => 3,
        };
        4 * usize::from(self.closed) + rock
    }
}

/// The rock's memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory<T> {
    /// Foot of the loading line `ul`, m.
    pub ul: T,
    /// Foot of the unloading line `uu`, m.
    pub uu: T,
    /// Permanent gain of the last cycle `dp`, m.
    pub gain: T,
    /// Force at which the tip last turned upward, N.
    pub turned: T,
}

/// The continuous state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<T> {
    /// Nodal displacements, m.
    pub u: Vec<T>,
    /// Nodal velocities, m/s.
    pub v: Vec<T>,
    /// Viscous work of the current cycle, J.
    pub psi: T,
}

/// An event ends a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// Q11 falls: the gap closes.
    Close,
    /// Q11 rises: the gap opens.
    Open,
    /// FF to DFC.
    Q1,
    /// DFC to BC.
    Q2,
    /// DFC to FC.
    Q3,
    /// FC to BC.
    Q4,
    /// BC to FF.
    Q5,
    /// BC to SS or DFC.
    Q6,
    /// SS to DFC.
    Q7,
    /// SS to BC.
    Q8,
    /// SS to FF.
    LiftOff,
    /// Relay to -1.
    Q9,
    /// Relay to +1.
    Q10,
    /// A port opens (true) or closes: chamber (0: drive), port (0: supply).
    Port(usize, usize, bool),
    /// A port of air is fully open from here on (true) or no longer: chamber, port.
    Whole(usize, usize, bool),
    /// The piston enters (true) or leaves the end of its cylinder.
    End(bool),
    /// The bodies of a joint meet, or part.
    Joint(usize, Side),
    /// The bit passes the idle travel outward (true) or back.
    Vent(bool),
}

impl Event {
    /// Order of events at one instant: contact, joints, rock, drive.
    pub fn rank(self) -> u8 {
        match self {
            Self::Close | Self::Open => 0,
            Self::Joint(..) => 1,
            Self::Q9 | Self::Q10 | Self::Port(..) | Self::Whole(..) => 3,
            Self::Vent(_) | Self::End(_) => 3,
            _ => 2,
        }
    }
}

/// A quantity that a guard watches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `w2.u + g0`, m.
    Gap,
    /// `p = w1.u`, m.
    Tip,
    /// `p' = w1.v`, m/s.
    TipSpeed,
    /// `vr`, m.
    Relative,
    /// `psi`, J.
    Work,
    /// Distance of a joint's faces, m.
    Joint(usize),
}

/// `sign (quantity - offset)`, whose rise through zero is `event`.
#[derive(Clone, Copy, Debug)]
pub struct Guard<T> {
    /// The event.
    pub event: Event,
    /// The quantity.
    pub quantity: Quantity,
    /// `+1` or `-1`.
    pub sign: f64,
    /// Level, in the quantity's unit.
    pub offset: T,
    /// Height that a rise must exceed to count; 0 for `psi`, which never falls.
    pub height: f64,
}

impl<T: Real> Guard<T> {
    /// The guard's value if its quantity is `q`.
    pub fn value(&self, q: T) -> T {
        T::from(self.sign) * (q - self.offset)
    }
}
