//! Assumptions for the numbers that a sheet does not give. Each is a number with an error, and the answer states it in
//! a sentence.
//!
//! Sizes follow from makers' tables (`sizes`). SPM (hammers of 58 to 182 mm) prints holes of 1.1 to 1.6 times the
//! outside diameter. The sleeve of Drillco's Puma 3.1 measures 74 mm outside and 64.09 mm inside.

use super::air::FEED as HELD;
use super::member::{Fluid, Kind, Point, Row};
use super::quantity::Quantity;
use super::sizes::{FEED, LOW, PISTON};
use super::{Datasheet, DatasheetError, EFFICIENCY};
use crate::numerics::display::digits;
use crate::numerics::math;
use std::f64::consts::PI;

/// Inside diameter of a sleeve over its outside diameter; and the range of the bore over the inside diameter, for a
/// hammer of the diameter [`MIDDLE`].
pub(super) const SLEEVE: f64 = 64.09 / 74.0;
const BORE: [f64; 2] = [0.85, 0.93];
/// Outside diameter (m) of hammers that are scaled copies of the presets. Other hammers differ from such copies: their
/// bore, stroke and pace contain the ratio of the diameters to these powers. Without given air or power, the hammers
/// then follow the laws of `sizes`. (`A^1.5 L^0.5 m^-0.5` of a copy is proportional to D^1.72, the printed power to
/// D^1.0.)
const MIDDLE: f64 = 0.11;
const SLENDER: [f64; 3] = [-0.14, -0.3, -0.1];
/// Energy of real hammers over that of scaled presets, and its relative error.
const EFFECTIVE: (f64, f64) = (1.15, 0.1);
/// Diameter of the hole over the outside diameter, and its relative error.
const HOLE: (f64, f64) = (1.15, 0.08);
/// Usual impact speed, m/s, and its relative error.
const SPEED: (f64, f64) = (9.5, 0.2);
/// Above this pressure the hammer is driven by a liquid, Pa.
const AIR: f64 = 40e5;

/// Pressure for which the presets' air is known, Pa.
const OF_PRESETS: f64 = 24e5;
/// Pressure of air if none is given, Pa, with its relative error; and pressure of a liquid.
const PRESSURE: (f64, f64) = (20e5, 0.35);
const OF_LIQUID: f64 = 150e5;
/// Relative error of the effectiveness of a liquid's drive.
const OF_EFFECT: f64 = 0.15;
/// Relative errors of the stroke over the presets' stroke: for air, and for liquids, of whose drives hardly anything is
/// known.
const STROKE: (f64, f64) = (0.25, 0.6);
/// Area of a port over that of the bore, and its relative error. The presets have 0.014 to 0.034.
const PORT: (f64, f64) = (0.024, 0.5);
/// Air and frequency of real hammers over those of scaled presets, each with its relative error
/// (`reports/catalogue.md`).
const SHARE: (f64, f64) = (1.05, 0.12);
const PACE: (f64, f64) = (0.95, 0.08);
/// How air, energy and frequency depend on pressure: exponents in addition to those of the presets, each with its
/// error. For air, makers' rows at two pressures give 1.09, and the presets give 1.28. No maker prints the others at
/// two pressures; their errors are a guess, which gives power the error of air.
const OVER_PRESSURE: [(f64, f64); 3] = [(-0.15, 0.17), (0.0, 0.11), (0.0, 0.1)];

impl Datasheet {
    /// The outside diameter (m), its relative error, and the name of the number from which it follows.
    pub(super) fn outer(&self) -> Option<(f64, f64, &'static str)> {
        let given = self.get(Quantity::OuterDiameter).map(|od| (od, 0.0, "outside diameter"));
        let of_hole = || Some((self.get(Quantity::Hole)? / HOLE.0, HOLE.1, "hole"));
        let of_mass = || {
            let (size, error) = PISTON.diameter(self.get(Quantity::PistonMass)?);
            Some((size, error, "piston's mass"))
        };
        let of_energy = || {
            let mass = 2.0 * self.energy()? / (SPEED.0 * SPEED.0);
            let (size, error) = PISTON.diameter(mass);
            Some((size, math::hypot(error, 2.0 * SPEED.1 / 2.56), "energy of a blow"))
        };
        given.or_else(of_hole).or_else(of_mass).or_else(of_energy)
    }

    /// The energy of a blow (J), as given or from power and frequency.
    fn energy(&self) -> Option<f64> {
        let get = |quantity| self.get(quantity);
        let of_liquid = || Some(EFFICIENCY * get(Quantity::Pressure)? * get(Quantity::Flow)?);
        let power = || get(Quantity::Power).or_else(of_liquid);
        let of_power = || Some(power()? / get(Quantity::Frequency)?);
        get(Quantity::BlowEnergy).or_else(of_power)
    }

    /// The usual diameter of the hole (m) for an outside diameter (m).
    pub fn usual_hole(outer: f64) -> f64 {
        HOLE.0 * outer
    }

    /// The diameter of the hole (m), and the name of the number from which it follows if it is not given.
    pub(super) fn hole(&self) -> Option<(f64, Option<&'static str>)> {
        let usual = || self.outer().map(|(outer, _, from)| (Self::usual_hole(outer), Some(from)));
        self.get(Quantity::Hole).map(|hole| (hole, None)).or_else(usual)
    }

    /// A liquid if the pressure is above 40 bar or a flow is given; otherwise air.
    pub(super) fn fluid(&self) -> Fluid {
        let high = self.get(Quantity::Pressure).is_some_and(|pressure| pressure >= AIR);
        if high || self.get(Quantity::Flow).is_some() { Fluid::Liquid } else { Fluid::Air }
    }

    /// Least and largest usual feed (N), if the size is known. They are those that makers print. For an air hammer, the
    /// largest is at least the feed that holds the casing down.
    pub(super) fn usual_feeds(&self) -> Option<[f64; 2]> {
        let outer = self.outer()?.0;
        let printed = FEED.of(outer);
        let pressure = self.working_pressure().unwrap_or(PRESSURE.0);
        let held = HELD * outer * outer * pressure;
        let air = self.fluid() == Fluid::Air;
        Some([printed, if air { printed.max(held) } else { printed }])
    }

    /// The prior distribution of the hammers.
    pub(super) fn kind(&self) -> Result<Kind, DatasheetError> {
        let little = |text: &str| DatasheetError::TooLittle(text.into());
        let (outer, error, _) = self.outer().ok_or_else(|| {
            little("nothing says how heavy the piston is: give piston_mass, od or hole")
        })?;
        let of_power = [
            Quantity::Pressure,
            Quantity::Power,
            Quantity::BlowEnergy,
            Quantity::ImpactSpeed,
            Quantity::AirFlow,
            Quantity::Flow,
        ];
        if self.air.is_empty() && of_power.iter().all(|quantity| self.get(*quantity).is_none()) {
            return Err(little(
                "nothing says the power of the blows: give pressure, power, blow_energy or air_flow",
            ));
        }
        let fluid = self.fluid();
        let liquid = fluid == Fluid::Liquid;
        let given = |quantity: Quantity, value: f64, error: f64| match self.get(quantity) {
            Some(value) => (value, quantity.entry().error),
            None => (value, error),
        };
        let [least, most] = BORE;
        let middle = 0.5 * (least + most);
        let of_bore = math::hypot(0.5 * (most - least) / middle, error);
        let [slender, shorter, slower] =
            SLENDER.map(
                |exponent| {
                    if liquid { 1.0 } else { math::exp(exponent * math::ln(outer / MIDDLE)) }
                },
            );
        let fits = middle * slender * SLEEVE * outer;
        // If the pressure is not the presets', the air is scaled with the same exponent as for a sheet at two
        // pressures.
        let working = self.get(Quantity::Pressure).unwrap_or(PRESSURE.0);
        let rarer = math::exp(OVER_PRESSURE[0].0 * math::ln(working / OF_PRESETS));
        let logarithms = [
            given(Quantity::Pressure, if liquid { OF_LIQUID } else { PRESSURE.0 }, PRESSURE.1),
            given(Quantity::Bore, fits, if liquid { STROKE.1 } else { of_bore }),
            given(Quantity::PistonMass, PISTON.of(outer), PISTON.error(outer, error)),
            (shorter, if liquid { STROKE.1 } else { STROKE.0 }),
            PORT,
            if liquid { (1.0, OF_EFFECT) } else { EFFECTIVE },
            if liquid { (1.0, SHARE.1) } else { (SHARE.0 * rarer, SHARE.1) },
            if liquid { (1.0, PACE.1) } else { (slower * PACE.0, PACE.1) },
        ];
        let plain = OVER_PRESSURE.into_iter().chain([LOW]);
        let unknowns = logarithms.map(|(value, error)| (math::ln(value), error)).into_iter();
        let unknowns: Vec<(f64, f64)> = unknowns.chain(plain).collect();
        let middle = Point::from_iterator(unknowns.iter().map(|(value, _)| *value));
        let wide = Point::from_iterator(unknowns.iter().map(|(_, error)| *error));
        Ok(Kind { fluid, middle, wide })
    }

    /// The usual impact speed, air and power, if they are not given.
    pub(super) fn usual(&self) -> Vec<Row> {
        let (given, error) = SPEED;
        let quantity = Quantity::ImpactSpeed;
        let row = Row { quantity, given, error, pressure: None, series: 0, assumed: true };
        let speed = self.get(quantity).is_none().then_some(row);
        speed.into_iter().chain(self.usual_of_size()).collect()
    }

    /// The assumptions about a blow, one sentence each.
    pub(super) fn of_blows(&self) -> Vec<String> {
        let given = |quantity| self.get(quantity).is_some();
        let air = self.fluid() == Fluid::Air;
        let mut list = Vec::new();
        let mut say = |quantity, text: String| list.extend((!given(quantity)).then_some(text));
        let of = |error: f64| format!("{:.0} %", 100.0 * error);
        if let Some((outer, error, from)) = self.outer() {
            let (mass, wide) = (PISTON.of(outer), PISTON.error(outer, error));
            let guess = PISTON.guess(outer);
            let why = guess.unwrap_or_else(|| format!("as hammers of that {from} have"));
            let text = format!("The piston has {} kg, {why}, up to {}.", digits(mass), of(wide));
            say(Quantity::PistonMass, text);
            let slender = math::exp(SLENDER[0] * math::ln(outer / MIDDLE));
            let [least, most] = BORE.map(|share| format!("{:.2}", slender * share));
            let text = if air {
                format!("The bore is {least} to {most} of what fits in a hammer of that {from}.")
            } else {
                format!("The bore is that of an air hammer of that {from}, up to {}.", of(STROKE.1))
            };
            say(Quantity::Bore, text);
        }
        if air {
            let text = format!(
                "Faces, stroke and ports are those of the air presets, in proportion, with the stroke up to {}, \
                 the effectiveness up to {} and the air up to {} off.",
                of(STROKE.0),
                of(EFFECTIVE.1),
                of(SHARE.1)
            );
            say(Quantity::Effectiveness, text);
        }
        let (speed, error) = SPEED;
        say(
            Quantity::ImpactSpeed,
            format!("The piston strikes at {speed} m/s, as most do, up to {}.", of(error)),
        );
        let pressure = if air { PRESSURE.0 } else { OF_LIQUID };
        say(
            Quantity::Pressure,
            format!("The pressure is {:.0} bar, up to {}.", 1e-5 * pressure, of(PRESSURE.1)),
        );
        if !air {
            list.push(format!(
                "A liquid drives it at a constant pressure; of pressure times flow the blows have {EFFICIENCY}."
            ));
        }
        list
    }
}

pub(super) fn area(bore: f64) -> f64 {
    0.25 * PI * bore * bore
}
