//! How the numbers of makers' hammers depend on their size: laws fitted to printed rows, and the range of these rows.
//!
//! Hammers of different size are not scaled copies of each other. `D` is the outside diameter, and `p` the pressure
//! above the exhaust's:
//!
//! ```text
//! piston     8.0 kg (D / 100 mm)^2.56                              11 hammers of four makers, 58 to 525 mm
//! free air   9.8 m3/min (D / 110 mm)^1.18 (p / 14 bar)^1.09        28 rows of three makers, 67 to 210 mm, 10 to 35 bar
//! power      27.8 kW (D / 110 mm)^1.0 (p / 24 bar)^1.35            6 hammers of one maker, 85 to 210 mm, at 24 bar
//! feed       88 N per mm of D                                      10 hammers of one maker, 58 to 182 mm
//! ```
//!
//! Exponents and scatter are fitted to `reports/makers.csv`; for the piston, also to rows that are not in this file.
//! How the power depends on pressure is a guess, from the exponents of air and of the energy of a blow. Outside the
//! range of its rows a law is a guess: its error grows by [`BEYOND`] for each factor of e, and the answer says so.

use super::Datasheet;
use super::member::{Fluid, Row, low};
use super::quantity::Quantity;
use crate::numerics::math;

/// Growth of the logarithmic error for each factor of e outside the range of a law's rows.
const BEYOND: f64 = 0.3;

/// A law of size: its value at a reference diameter `at` (m), the exponent of the diameter, the relative error, and the
/// range of diameters in its rows, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    value: f64,
    at: f64,
    exponent: f64,
    error: f64,
    rows: [f64; 2],
}

pub(super) const PISTON: Law =
    Law { value: 8.0, at: 0.1, exponent: 2.56, error: 0.18, rows: [0.058, 0.525] };
const AIR: Law =
    Law { value: 9.8 / 60.0, at: 0.11, exponent: 1.18, error: 0.2, rows: [0.067, 0.21] };
const POWER: Law = Law { value: 27.8e3, at: 0.11, exponent: 1.0, error: 0.17, rows: [0.085, 0.21] };
pub(super) const FEED: Law =
    Law { value: 8.8e3, at: 0.1, exponent: 1.0, error: 0.2, rows: [0.058, 0.182] };

/// Reference pressure of the law of air, exponent, and range of pressures in its rows, Pa; then the same for power.
const OF_AIR: (f64, f64, [f64; 2]) = (14e5, 1.09, [10e5, 35e5]);
const OF_POWER: (f64, f64, [f64; 2]) = (24e5, 1.35, [24e5, 24e5]);
/// Logarithm of the factor of the air at low pressure, and its error.
pub(super) const LOW: (f64, f64) = (0.5, 0.27);

/// How far a number lies outside a range, as a logarithm.
fn beyond(x: f64, [least, most]: [f64; 2]) -> f64 {
    math::ln(least / x).max(math::ln(x / most)).max(0.0)
}

impl Law {
    /// The law's value at a diameter, m.
    pub fn of(&self, outer: f64) -> f64 {
        self.value * math::exp(self.exponent * math::ln(outer / self.at))
    }

    /// The law's relative error at a diameter that has the relative error `off` itself.
    pub fn error(&self, outer: f64, off: f64) -> f64 {
        math::length(&[self.error, self.exponent * off, BEYOND * beyond(outer, self.rows)])
    }

    /// The diameter at which the law has a value, with its relative error.
    pub fn diameter(&self, value: f64) -> (f64, f64) {
        let size = self.at * math::exp(math::ln(value / self.value) / self.exponent);
        (size, self.error(size, 0.0) / self.exponent)
    }

    /// A sentence about the range of the law's rows, if the diameter lies outside.
    pub fn guess(&self, outer: f64) -> Option<String> {
        let [least, most] = self.rows.map(|side| 1e3 * side);
        (beyond(outer, self.rows) > 1e-9).then(|| {
            format!(
                "a guess: no table here has a hammer of {:.0} mm, only such of {least:.0} to {most:.0}",
                1e3 * outer
            )
        })
    }
}

impl Datasheet {
    /// Air and power of makers' hammers of this size at this pressure, if no given number determines them.
    pub(super) fn usual_of_size(&self) -> Vec<Row> {
        let said = |list: &[Quantity]| list.iter().any(|q| self.get(*q).is_some());
        let (Some(pressure), Some((outer, off, _))) = (self.get(Quantity::Pressure), self.outer())
        else {
            return Vec::new();
        };
        let dimensions = [Quantity::Bore, Quantity::Stroke, Quantity::Effectiveness];
        if self.fluid() != Fluid::Air || said(&dimensions) {
            return Vec::new();
        }
        let row = |quantity, law: Law, (at, exponent, rows): (f64, f64, [f64; 2]), low| {
            let over = exponent * math::ln(pressure / at) + low * LOW.0;
            let given = law.of(outer) * math::exp(over);
            let far = BEYOND * beyond(pressure, rows);
            let error = math::length(&[law.error(outer, off), far, low * LOW.1]);
            Row { quantity, given, error, pressure: None, series: 0, assumed: true }
        };
        let air = self.air.is_empty() && !said(&[Quantity::AirFlow]);
        let blows = said(&[Quantity::BlowEnergy]) && said(&[Quantity::Frequency]);
        let power = !(said(&[Quantity::Power]) || blows);
        let air = air.then(|| row(Quantity::AirFlow, AIR, OF_AIR, low(pressure)));
        air.into_iter().chain(power.then(|| row(Quantity::Power, POWER, OF_POWER, 0.0))).collect()
    }
}
