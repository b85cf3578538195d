//! The numbers that a datasheet may give: their names, units, ranges and errors.

use crate::quantities::domain::{Domain, ParameterError};

/// Name, unit, range and error of a number that a datasheet may give.
pub struct Entry {
    quantity: Quantity,
    /// Name, used as an argument.
    pub name: &'static str,
    /// SI unit; `1` for a ratio.
    pub unit: &'static str,
    /// Unit that is usual in the trade, and its size in the SI unit.
    pub field: (&'static str, f64),
    /// Least and largest value of real hammers, SI.
    pub range: [f64; 2],
    /// Relative standard error of the number in a datasheet; infinite if hammers are not fitted to it.
    pub error: f64,
    /// Its meaning.
    pub meaning: &'static str,
}

macro_rules! list {
    ($($quantity:ident, $name:literal, $unit:literal, $field:expr, $range:expr, $error:expr, $meaning:literal;)+) => {
        /// A number of a datasheet.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Quantity {
            $(#[doc = $meaning] $quantity,)+
        }

        const TABLE: &[Entry] = &[$(Entry {
            quantity: Quantity::$quantity,
            name: $name,
            unit: $unit,
            field: $field,
            range: $range,
            error: $error,
            meaning: $meaning,
        },)+];
    };
}

// Ranges are those of the smallest and the largest hammers, with a margin. (Pistons strike at some 10 m/s, and steel
// yields beyond 25.) Errors are the scatter of makers' numbers.
#[rustfmt::skip]
list! {
    Pressure, "pressure", "Pa", ("bar", 1e5), [1e4, 1e8], 0.05, "Supply pressure over that of the exhaust";
    Bore, "bore", "m", ("mm", 1e-3), [5e-3, 1.0], 0.01, "Diameter on which the pressure acts";
    Stroke, "stroke", "m", ("mm", 1e-3), [1e-3, 1.0], 0.05, "From the bit to where the piston turns";
    PistonMass, "piston_mass", "kg", ("kg", 1.0), [0.05, 2000.0], 0.01, "Mass of the piston";
    BlowEnergy, "blow_energy", "J", ("J", 1.0), [0.5, 5e4], 0.05, "Energy of the piston just before it meets the bit";
    Frequency, "frequency", "Hz", ("1/min", 1.0 / 60.0), [0.5, 500.0], 0.02, "Blows per time";
    ImpactSpeed, "impact_speed", "m/s", ("m/s", 1.0), [0.5, 25.0], 0.05, "Speed of the piston just before it meets the bit";
    Power, "power", "W", ("kW", 1e3), [10.0, 1e6], 0.05, "Blow energy times frequency";
    AirFlow, "air_flow", "m3/s", ("m3/min", 1.0 / 60.0), [1e-4, 5.0], 0.15, "Volume of free air per time";
    Flow, "flow", "m3/s", ("l/min", 1e-3 / 60.0), [1e-6, 0.1], 0.25, "Volume of oil or water per time: with the pressure, the power that it brings";
    Rate, "rop", "m/s", ("m/h", 1.0 / 3600.0), [1e-6, 0.2], 0.1, "Measured rate of penetration";
    Effectiveness, "effectiveness", "1", ("1", 1.0), [1e-3, 1.0], 0.02, "Mean driving pressure over the supply's";
    PistonLength, "piston_length", "m", ("mm", 1e-3), [0.01, 5.0], f64::INFINITY, "Length of the piston; as slender as the scene's if not given";
    BitMass, "bit_mass", "kg", ("kg", 1.0), [0.05, 2000.0], f64::INFINITY, "Mass of the bit; as long as the piston if not given";
    OuterDiameter, "od", "m", ("mm", 1e-3), [0.02, 2.0], f64::INFINITY, "Outside diameter of the hammer: says which bore, piston and feed fit";
    Length, "length", "m", ("mm", 1e-3), [0.1, 10.0], f64::INFINITY, "Length of the hammer, in which the piston must have room for its stroke";
    Hole, "hole", "m", ("mm", 1e-3), [0.02, 2.0], f64::INFINITY, "Diameter of the hole: the rock's stiffness, viscosity and barrier grow with its area";
    Feed, "feed", "N", ("kN", 1e3), [1.0, 1e6], f64::INFINITY, "Feed force";
    Pipe, "pipe", "m", ("mm", 1e-3), [0.01, 2.0], f64::INFINITY, "Outside diameter of the drill pipe, past which the flushing air rises";
    Rotation, "rotation", "Hz", ("1/min", 1.0 / 60.0), [0.01, 10.0], f64::INFINITY, "Turns of the bit per time";
    Altitude, "altitude", "m", ("m", 1.0), [-500.0, 6000.0], f64::INFINITY, "Altitude of the compressor: the free air that it must suck in there";
    Inlet, "inlet", "K", ("K", 1.0), [220.0, 330.0], f64::INFINITY, "Temperature of the air that the compressor sucks in";
    DampingRatio, "damping_ratio", "1", ("1", 1.0), [0.0, 0.5], f64::INFINITY, "Damping ratio of the piston's first elastic mode";
}

impl Quantity {
    /// All quantities.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.quantity)
    }

    /// True if it is a property of a blow, not of the hammer.
    pub(super) fn of_blow(self) -> bool {
        let of_hammer = [Self::Pressure, Self::Bore, Self::PistonMass, Self::Rate];
        self.entry().error.is_finite() && !of_hammer.contains(&self)
    }

    /// The quantity's entry.
    pub fn entry(self) -> &'static Entry {
        &TABLE[self as usize]
    }

    /// Name, used as an argument.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// Refuses a number outside the range of real hammers.
    ///
    /// # Errors
    /// The number is not in the range of real hammers.
    pub fn check(self, value: f64) -> Result<(), ParameterError> {
        let Entry { name, unit, range: [low, high], .. } = *self.entry();
        Domain::Between(low, high).check(name, value, unit.trim_start_matches('1'))
    }
}
