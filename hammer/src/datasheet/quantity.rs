//! What a datasheet may give.

use crate::quantities::domain::{Domain, ParameterError};

/// A number of a datasheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Supply pressure over that of the exhaust.
    Pressure,
    /// Diameter on which the pressure acts.
    Bore,
    /// From the bit to where the piston turns.
    Stroke,
    /// Mass of the piston.
    PistonMass,
    /// Energy of the piston just before it meets the bit.
    BlowEnergy,
    /// Blows per time.
    Frequency,
    /// Speed of the piston just before it meets the bit.
    ImpactSpeed,
    /// Volume of free air per time.
    AirFlow,
    /// Volume of oil or water per time.
    OilFlow,
    /// Rate of penetration.
    Rate,
}

/// Name, unit, range of real hammers, and relative error of what a datasheet says.
struct Row(Quantity, &'static str, &'static str, [f64; 2], f64);

/// Ranges are those of the smallest and the largest hammers with room to spare; steel strikes steel
/// at some 10 m/s, and yields beyond 25. Errors are what makers' numbers scatter by.
#[rustfmt::skip]
const TABLE: [Row; 10] = [
    Row(Quantity::Pressure, "pressure", "Pa", [1e4, 1e8], 0.05),
    Row(Quantity::Bore, "bore", "m", [5e-3, 1.0], 0.01),
    Row(Quantity::Stroke, "stroke", "m", [1e-3, 1.0], 0.05),
    Row(Quantity::PistonMass, "piston_mass", "kg", [0.05, 2000.0], 0.01),
    Row(Quantity::BlowEnergy, "blow_energy", "J", [0.5, 5e4], 0.05),
    Row(Quantity::Frequency, "frequency", "Hz", [0.5, 500.0], 0.02),
    Row(Quantity::ImpactSpeed, "impact_speed", "m/s", [0.5, 25.0], 0.05),
    Row(Quantity::AirFlow, "air_flow", "m3/s", [1e-4, 5.0], 0.3),
    Row(Quantity::OilFlow, "oil_flow", "m3/s", [1e-6, 0.1], 0.15),
    Row(Quantity::Rate, "rop", "m/s", [1e-6, 0.2], 0.1),
];

impl Quantity {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.0)
    }

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// Name, as an argument.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        self.row().2
    }

    /// Standard error of what a datasheet says, over the number.
    pub fn error(self) -> f64 {
        self.row().4
    }

    /// Refuses what no hammer has.
    pub(crate) fn check(self, value: f64) -> Result<(), ParameterError> {
        let [low, high] = self.row().3;
        Domain::Between(low, high).check(self.name(), value, self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_where_their_numbers_say() {
        assert!(Quantity::all().enumerate().all(|(k, quantity)| quantity as usize == k));
    }
}
