//! Variables of FMI 3.0 that FMI 2.0 has no word for: time, events, clocks, slopes, arrays.
//!
//! Also compiled into `build.rs`.

use crate::waves::FAMILIES;
use hammer::Input;

/// Most positions that a host may want to hear of.
pub const MAX_POSITIONS: usize = 8;
/// Most stations along a body.
pub const MAX_STATIONS: u64 = 10_000;
/// Stations along a body unless the host says otherwise.
pub const STATIONS: u64 = 20;

/// Value references, above all others.
const FIRST: u32 = 1_000_000;
const POSITIONS_FROM: u32 = FIRST + 10;
const SLOPES_FROM: u32 = FIRST + 20;
const CLOCKS_FROM: u32 = FIRST + 30;
const ARRAYS_FROM: u32 = FIRST + 40;

/// What ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// At each blow.
    Blow,
    /// Where the piston passes a position.
    Position,
}

impl Clock {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Blow, Self::Position];

    /// Name of the variable.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Blow => "blow",
            Self::Position => "position",
        }
    }
}

/// Outputs that change at blows alone, and are clocked by them.
pub const OF_BLOWS: [&str; 7] = [
    "blow_time",
    "blow_speed",
    "blow_energy",
    "blow_period",
    "blow_penetration",
    "rop",
    "rop_mean",
];

/// One of these variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// The independent variable.
    Time,
    /// Whether steps end at blows.
    EventBlow,
    /// How many positions there are.
    Positions,
    /// A position, by its index from 0.
    Position(usize),
    /// Stations along a body, in each array.
    Stations,
    /// The slope of an input.
    Slope(Input),
    /// A clock.
    Clock(Clock),
    /// A family of waves, at the stations.
    Array(usize),
}

impl Extra {
    /// The variable of a value reference; `None` if it is none of these.
    pub fn of(reference: u32) -> Option<Self> {
        Self::all().find(|extra| extra.reference() == reference)
    }

    /// All of them, in the order of their value references.
    pub fn all() -> impl Iterator<Item = Self> {
        let alone = [Self::Time, Self::EventBlow, Self::Positions, Self::Stations];
        let positions = (0..MAX_POSITIONS).map(Self::Position);
        let slopes = Input::ALL.into_iter().map(Self::Slope);
        let clocks = Clock::ALL.into_iter().map(Self::Clock);
        let arrays = (0..FAMILIES.len()).map(Self::Array);
        alone.into_iter().chain(positions).chain(slopes).chain(clocks).chain(arrays)
    }

    /// Its value reference.
    pub fn reference(self) -> u32 {
        match self {
            Self::Time => FIRST,
            Self::EventBlow => FIRST + 1,
            Self::Positions => FIRST + 2,
            Self::Stations => FIRST + 3,
            Self::Position(index) => POSITIONS_FROM + index as u32,
            Self::Slope(input) => SLOPES_FROM + input as u32,
            Self::Clock(clock) => CLOCKS_FROM + clock as u32,
            Self::Array(family) => ARRAYS_FROM + family as u32,
        }
    }

    /// Its name where it is one by itself, or of its kind.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::EventBlow => "event.blow",
            Self::Positions => "event.positions",
            Self::Position(_) => "event.position",
            Self::Stations => "waves.stations",
            Self::Slope(Input::FeedForce) => "feed_force_rate",
            Self::Slope(Input::DriveForce) => "drive_force_rate",
            Self::Slope(Input::DrivePressure) => "drive_pressure_rate",
            Self::Slope(Input::ReturnPressure) => "return_pressure_rate",
            Self::Clock(clock) => clock.name(),
            Self::Array(0) => "piston_stress",
            Self::Array(1) => "bit_stress",
            Self::Array(2) => "piston_section_velocity",
            Self::Array(_) => "bit_section_velocity",
        }
    }

    /// What it is.
    pub fn description(self) -> String {
        match self {
            Self::Time => "Time".into(),
            Self::EventBlow => {
                "Steps end at blows, for hosts with event mode and early return".into()
            }
            Self::Positions => {
                "Number of positions of the piston over the bit at which steps end, \
                                for hosts with event mode and early return"
                    .into()
            }
            Self::Position(_) => {
                "Value of relative_position at whose passage, either way, a step ends".into()
            }
            Self::Stations => {
                "Number of stations along each body in the arrays of stress and velocity".into()
            }
            Self::Slope(input) => {
                format!(
                    "Slope of {} from the communication point on at which either was set",
                    input.name()
                )
            }
            Self::Clock(Clock::Blow) => "Ticks at each blow".into(),
            Self::Clock(Clock::Position) => {
                "Ticks where relative_position passes an event.position".into()
            }
            Self::Array(family) => {
                let (of, body) =
                    if family < 2 { ("Axial stress", "tension") } else { ("Velocity", "downward") };
                format!(
                    "{of} along the {}, {body} positive: at the middle of the elements that lie \
                     at stations spaced evenly over them, from the top",
                    if family % 2 == 0 { "piston" } else { "bit" }
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reference_is_of_one_variable() {
        let all: Vec<u32> = Extra::all().map(Extra::reference).collect();
        for extra in Extra::all() {
            assert_eq!(Extra::of(extra.reference()), Some(extra));
            assert_eq!(all.iter().filter(|r| **r == extra.reference()).count(), 1);
        }
        assert_eq!(Extra::of(FIRST + 9), None);
        assert_eq!(Extra::of(0), None);
    }
}
