//! What is assumed where a sheet says nothing: each a number with an error, told in a sentence.
//!
//! The sizes are those of makers' tables. SPM (medium-pressure hammers of 58 to 182 mm) prints pistons of
//! 5.9 to 11.4 t per cubic metre of the outside diameter cubed, holes 1.1 to 1.5 times and feeds (the
//! middle of each range) of 86 to 107 kN per metre of the outside diameter. Drillco (Puma 3.1) has a
//! sleeve of 74 mm outside and 64.09 mm inside.

use super::quantity::Quantity;
use super::{Datasheet, EFFICIENCY};
use crate::numerics::display::digits;
use crate::numerics::math;
use std::f64::consts::PI;

/// Diameter that fits in a sleeve over its outside diameter, and the part of it that is bore.
const SLEEVE: f64 = 64.09 / 74.0;
const BORE: [f64; 2] = [0.85, 0.93];
/// Mean driving pressure over the supply's on such a bore, and its error. Sandvik's hammers of 3.5 to
/// 6 inches have their published power at 35 to 45 blows a second with 0.68 to 0.84.
const EFFECTIVE: (f64, f64) = (0.75, 0.15);
/// Mass of the piston over the cube of the outside diameter, kg/m3, and its error.
const PISTON: (f64, f64) = (8000.0, 0.3);
/// Diameter of the hole over the outside diameter, and its error.
const HOLE: (f64, f64) = (1.15, 0.08);
/// Speed at which pistons strike, m/s, and its error.
const SPEED: (f64, f64) = (9.5, 0.2);
/// Feed over outside diameter, N/m.
const FEED: f64 = 94e3;
/// Above this pressure a hammer is not driven by air, Pa.
const AIR: f64 = 40e5;

/// A number that is assumed, and its standard error as a share of it.
#[derive(Clone, Debug)]
pub(super) struct Assumption {
    pub quantity: Quantity,
    pub value: f64,
    pub error: f64,
    pub text: String,
}

impl Datasheet {
    /// The outside diameter (m), its error, and what it is from.
    pub(super) fn outer(&self) -> Option<(f64, f64, &'static str)> {
        let given = self.get(Quantity::OuterDiameter).map(|od| (od, 0.0, "outside diameter"));
        let of_hole = || Some((self.get(Quantity::Hole)? / HOLE.0, HOLE.1, "hole"));
        let of_mass = || {
            let size = math::cbrt(self.get(Quantity::PistonMass)? / PISTON.0);
            Some((size, PISTON.1 / 3.0, "piston's mass"))
        };
        let of_energy = || {
            let mass = 2.0 * self.energy()? / (SPEED.0 * SPEED.0);
            let error = PISTON.1.hypot(2.0 * SPEED.1) / 3.0;
            Some((math::cbrt(mass / PISTON.0), error, "energy of a blow"))
        };
        given.or_else(of_hole).or_else(of_mass).or_else(of_energy)
    }

    /// The energy of a blow (J) that is given, or follows from a power and the frequency.
    fn energy(&self) -> Option<f64> {
        let get = |quantity| self.get(quantity);
        let of_liquid = || Some(EFFICIENCY * get(Quantity::Pressure)? * get(Quantity::Flow)?);
        let power = || get(Quantity::Power).or_else(of_liquid);
        let of_power = || Some(power()? / get(Quantity::Frequency)?);
        get(Quantity::BlowEnergy).or_else(of_power)
    }

    /// The hole (m) that suits an outside diameter (m).
    pub fn usual_hole(outer: f64) -> f64 {
        HOLE.0 * outer
    }

    /// The hole (m), and what it is assumed from if it is not given.
    pub(super) fn hole(&self) -> Option<(f64, Option<&'static str>)> {
        let usual = || self.outer().map(|(outer, _, from)| (Self::usual_hole(outer), Some(from)));
        self.get(Quantity::Hole).map(|hole| (hole, None)).or_else(usual)
    }

    /// Whether the pressure is that of air.
    pub(super) fn is_air(&self) -> bool {
        let pressure = self.get(Quantity::Pressure);
        pressure.is_some_and(|pressure| pressure < AIR) && self.get(Quantity::Flow).is_none()
    }

    /// The feed (N) where none is given and the size is.
    pub(super) fn usual_feed(&self) -> Option<f64> {
        if let Some(feed) = self.feed_of_air() {
            return Some(feed);
        }
        let outer = self.get(Quantity::OuterDiameter);
        Some(FEED * outer.or_else(|| Some(self.get(Quantity::Hole)? / HOLE.0))?)
    }

    /// The bore (m): given, or what fits.
    pub(super) fn bore(&self) -> Option<f64> {
        let fits = || Some(0.5 * (BORE[0] + BORE[1]) * SLEEVE * self.outer()?.0);
        self.get(Quantity::Bore).or_else(fits)
    }

    /// Whether the pressure acts on a bore that is known, or of a hammer driven by air.
    pub(super) fn has_pressure(&self) -> bool {
        let bore = self.get(Quantity::Bore).and(self.get(Quantity::Pressure)).is_some();
        bore || (self.is_air() && self.outer().is_some())
    }

    /// What may be assumed, what is best known first.
    pub(super) fn assumptions(&self) -> Vec<Assumption> {
        let mut list = Vec::new();
        let mut may = |quantity, value: f64, error: f64, text: String| {
            if self.get(quantity).is_none() {
                list.push(Assumption { quantity, value, error, text });
            }
        };
        if let Some((outer, error, from)) = self.outer() {
            let (value, wide) = (PISTON.0 * outer * outer * outer, PISTON.1.hypot(3.0 * error));
            let text = format!(
                "The piston has {} kg, as hammers of that {from} have, up to {:.0} %.",
                digits(value),
                100.0 * wide
            );
            may(Quantity::PistonMass, value, wide, text);
            if self.has_pressure() {
                let [least, most] = BORE;
                let middle = 0.5 * (least + most);
                let (value, own) = (middle * SLEEVE * outer, 0.5 * (most - least) / middle);
                let text = format!(
                    "The bore is {} mm, {least} to {most} of what fits in a hammer of that {from}.",
                    digits(1e3 * value)
                );
                may(Quantity::Bore, value, own.hypot(error), text);
            }
        }
        if self.has_pressure() {
            let (value, error) = EFFECTIVE;
            let text = format!(
                "The mean driving pressure is {value} of the supply's (effectiveness), up to {:.0} %.",
                100.0 * error
            );
            may(Quantity::Effectiveness, value, error, text);
        }
        let (speed, error) = SPEED;
        let text =
            format!("The piston strikes at {speed} m/s, as most do, up to {:.0} %.", 100.0 * error);
        may(Quantity::ImpactSpeed, speed, error, text);
        list
    }

    /// What is assumed of air and liquid, a sentence each.
    pub(super) fn of_fluids(&self) -> Vec<String> {
        let given = |quantity| self.get(quantity).is_some();
        let mut list = Vec::new();
        if given(Quantity::Pressure) && given(Quantity::AirFlow) && self.of_air().is_none() {
            list.push(
                "Air works at the supply's pressure: a blow takes the volume of its energy over the \
                 pressure."
                    .into(),
            );
        }
        if given(Quantity::Pressure) && given(Quantity::Flow) {
            list.push(format!(
                "Of pressure times flow the blows have {EFFICIENCY}; the rest is lost in valve and ports."
            ));
        } else if given(Quantity::Bore) && given(Quantity::Flow) {
            list.push(
                "A blow takes the bore full of fluid, from the bit to where the piston turns."
                    .into(),
            );
        }
        list
    }
}

/// Area of a bore, m2.
pub(super) fn area(bore: f64) -> f64 {
    0.25 * PI * bore * bore
}
