//! The variables that only FMI 3.0 has: time, events, slopes of inputs, and arrays.

use hammer::Input;
use hammer::variables::{ALONG, Along, OF_BLOW};

/// Largest number of positions that a host may monitor.
pub const MAX_POSITIONS: usize = 8;
/// Largest length of an array.
pub const MAX_LENGTH: u64 = 10_000;

/// The first of these variables' value references, which are above all others.
const FIRST: u32 = 1_000_000;
const POSITIONS_FROM: u32 = FIRST + 10;
const SLOPES_FROM: u32 = FIRST + 20;
const ALONG_FROM: u32 = FIRST + 40;
const OF_BLOW_FROM: u32 = FIRST + 50;

/// A structural parameter, which is the length of certain arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// The length of arrays along a body.
    Stations,
    /// The length of arrays of blows.
    Blows,
}

impl Length {
    /// Both lengths.
    pub const ALL: [Self; 2] = [Self::Stations, Self::Blows];
    /// The default lengths, in the order of [`Self::ALL`].
    pub const START: [u64; 2] = [20, 16];

    /// Name of the parameter.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stations => "waves.stations",
            Self::Blows => "blows.capacity",
        }
    }
}

/// A variable that only FMI 3.0 has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// The independent variable.
    Time,
    /// The parameter that is true if steps end at blows.
    EventBlow,
    /// The number of positions at which steps end.
    Positions,
    /// A position at which steps end, by its index from 0.
    Position(usize),
    /// The length of certain arrays.
    Length(Length),
    /// The slope of an input.
    Slope(Input),
    /// The event of the last step: 0 for none, 1 for a blow, 2 for a passed position.
    EventKind,
    /// Number of the position that the piston passed in the last step, counted from 1; 0 if it passed none.
    EventPosition,
    /// Stress or velocity at the stations along a body, by its index in [`ALONG`].
    Along(usize),
    /// The number of blows in the last step.
    BlowCount,
    /// A figure of the last step's blows, by its index in [`OF_BLOW`].
    OfBlow(usize),
}

impl Extra {
    /// The variable with a value reference; `None` if it belongs to another variable, or to none.
    pub fn of(reference: u32) -> Option<Self> {
        Self::all().find(|extra| extra.reference() == reference)
    }

    /// All these variables, in the order of their value references.
    pub fn all() -> impl Iterator<Item = Self> {
        let single = [Self::Time, Self::EventBlow, Self::Positions];
        let lengths = Length::ALL.into_iter().map(Self::Length);
        let positions = (0..MAX_POSITIONS).map(Self::Position);
        let slopes = Input::ALL.into_iter().map(Self::Slope);
        let events = [Self::EventKind, Self::EventPosition];
        let along = (0..ALONG.len()).map(Self::Along);
        let of_blow = (0..OF_BLOW.len()).map(Self::OfBlow);
        let settable = single.into_iter().chain(lengths).chain(positions).chain(slopes);
        settable.chain(events).chain(along).chain([Self::BlowCount]).chain(of_blow)
    }

    /// True if a model description may give the variable this start value.
    pub fn may_start_with(self, value: f64) -> bool {
        let whole = |low: u64, high: u64| {
            value.fract() == 0.0 && (low as f64..=high as f64).contains(&value)
        };
        match self {
            Self::EventBlow => whole(0, 1),
            Self::Positions => whole(0, MAX_POSITIONS as u64),
            Self::Length(_) => whole(1, MAX_LENGTH),
            Self::Position(_) => value.is_finite(),
            _ => false,
        }
    }

    /// True for an array and for the length of one. Only a variant of the archive lists these, because some importers
    /// cannot read arrays.
    pub const fn is_of_arrays(self) -> bool {
        matches!(self, Self::Along(_) | Self::BlowCount | Self::OfBlow(_) | Self::Length(_))
    }

    /// True if the variable is an output.
    pub const fn is_output(self) -> bool {
        matches!(self, Self::EventKind | Self::EventPosition)
            || self.is_of_arrays() && !matches!(self, Self::Length(_))
    }

    /// The variable's value reference.
    pub fn reference(self) -> u32 {
        match self {
            Self::Time => FIRST,
            Self::EventBlow => FIRST + 1,
            Self::Positions => FIRST + 2,
            Self::Length(length) => FIRST + 3 + length as u32,
            Self::Position(index) => POSITIONS_FROM + index as u32,
            Self::Slope(input) => SLOPES_FROM + input as u32,
            Self::EventKind => FIRST + 32,
            Self::EventPosition => FIRST + 33,
            Self::Along(family) => ALONG_FROM + family as u32,
            Self::BlowCount => OF_BLOW_FROM - 1,
            Self::OfBlow(figure) => OF_BLOW_FROM + figure as u32,
        }
    }

    /// The variable's name. Variables that are numbered have the name of their kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::EventBlow => "event.blow",
            Self::Positions => "event.positions",
            Self::Position(_) => "event.position",
            Self::Length(length) => length.name(),
            Self::Slope(Input::FeedForce) => "feed_force_rate",
            Self::Slope(Input::DriveForce) => "drive_force_rate",
            Self::Slope(Input::DrivePressure) => "drive_pressure_rate",
            Self::Slope(Input::ReturnPressure) => "return_pressure_rate",
            Self::Slope(Input::SupplyPressure) => "supply_pressure_rate",
            Self::Slope(Input::ExhaustPressure) => "exhaust_pressure_rate",
            Self::EventKind => "event_kind",
            Self::EventPosition => "event_position",
            Self::Along(2) => "piston_section_velocity",
            Self::Along(3) => "bit_section_velocity",
            Self::Along(5) => "casing_section_velocity",
            Self::Along(family) => ALONG[family].name,
            Self::BlowCount => "step_blow_count",
            Self::OfBlow(figure) => OF_BLOW[figure].name,
        }
    }

    /// The variable's description.
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
            Self::Length(Length::Stations) => {
                "Number of stations along each body in the arrays of stress and velocity".into()
            }
            Self::Length(Length::Blows) => {
                format!("Number of blows in the arrays of {} and the like", OF_BLOW[0].name)
            }
            Self::Slope(input) => {
                format!(
                    "Slope of {} from the communication point on at which either was set",
                    input.name()
                )
            }
            Self::EventKind => {
                "What ended the last step, or happened in it: 0 nothing, 1 a blow, 2 a position passed"
                    .into()
            }
            Self::EventPosition => {
                "Which event.position was passed where the last step ended, or the last in it: 0 none"
                    .into()
            }
            Self::Along(family) => {
                let Along { body, nodal, .. } = ALONG[family];
                let (quantity, positive) =
                    if nodal { ("Velocity", "downward") } else { ("Axial stress", "tension") };
                format!(
                    "{quantity} along the {}, {positive} positive: at the middle of the elements that \
                     lie at stations spaced evenly over them, from the top",
                    body.name()
                )
            }
            Self::BlowCount => "Blows of the last communication step".into(),
            Self::OfBlow(figure) => format!(
                "{}: the last step's blows in their order, the last {} of them, zeros behind",
                OF_BLOW[figure].description,
                Length::Blows.name()
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reference_is_of_one_variable() {
        let references: Vec<u32> = Extra::all().map(Extra::reference).collect();
        for extra in Extra::all() {
            assert_eq!(Extra::of(extra.reference()), Some(extra));
            assert_eq!(references.iter().filter(|r| **r == extra.reference()).count(), 1);
        }
        assert_eq!(Extra::of(FIRST + 9), None);
        assert_eq!(Extra::of(0), None);
    }
}
