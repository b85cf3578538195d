//! What no hammer does, in words of the trade.

use super::Datasheet;
use super::air::AirBlow;
use super::assume::area;
use super::fit::{Fit, Unknowns};
use super::quantity::Quantity;
use super::relay::Throw;
use super::response::Response;
use crate::quantities::warnings::{FASTEST, fast, is_fast};

/// Most blows a second: air hammers do 15 to 45, water hammers up to 70.
const MOST_BY_AIR: f64 = 50.0;
const MOST: f64 = 75.0;
/// Part of a hammer's length in which piston and stroke have room; chuck, valve and back head have the rest.
const ROOM: f64 = 0.7;
/// Velocity of the air that makers ask for in the hole, m/s.
const FLUSHING: [f64; 2] = [15.0, 30.0];
/// Density of a piston that fills its bore, kg/m3.
const STEEL: f64 = 7850.0;

impl Fit<'_> {
    /// What is impossible in the hammer that was found, and in that which was asked for, a sentence each.
    pub(super) fn impossible(&self, unknowns: &Unknowns, response: &Response) -> Vec<String> {
        let throw = self.throw(unknowns, response);
        let mut list = Vec::new();
        if let Some(asked) = self.unlimited(unknowns, response) {
            let Throw { speed, energy, period, height } = asked;
            list.push(format!(
                "As given, the piston would strike at {speed:.1} m/s ({energy:.0} J, {:.0} blows a \
                 second, turning {:.0} mm above the bit): steel that strikes steel does not last \
                 beyond {FASTEST} m/s. This hammer strikes at {:.1} m/s, and gives up the rest.",
                1.0 / (period * response.delay),
                1e3 * height,
                throw.speed
            ));
        } else if is_fast(throw.speed) {
            list.push(fast(throw.speed) + ".");
        }
        let frequency = 1.0 / response.period;
        if frequency > if self.sheet.is_air() { MOST_BY_AIR } else { MOST } {
            list.push(format!(
                "{:.0} J at {frequency:.0} blows a second: no hammer down the hole strikes so often; \
                 air hammers do 15 to 45 a second, water hammers up to 70.",
                response.energy
            ));
        }
        list.extend(self.sheet.too_short(throw.height, unknowns));
        list.extend(self.sheet.flushed());
        if self.sheet.has_pressure() && unknowns.effectiveness > 1.0 {
            list.push(format!(
                "The mean driving pressure is {:.3} of the supply's: more than all of it.",
                unknowns.effectiveness
            ));
        }
        list
    }
}

impl AirBlow {
    /// What no air hammer does.
    pub(super) fn impossible(&self, sheet: &Datasheet) -> Vec<String> {
        let fast = (self.speed > FASTEST).then(|| fast(self.speed) + ".");
        fast.into_iter().chain(sheet.flushed()).collect()
    }
}

impl Datasheet {
    /// A pipe that does not fit, or air too slow to lift cuttings or so fast that it wears the pipe.
    fn flushed(&self) -> Option<String> {
        let ((hole, _), pipe) = (self.hole()?, self.get(Quantity::Pipe)?);
        if pipe >= hole {
            return Some(format!(
                "A pipe of {:.0} mm is not in a hole of {:.0} mm.",
                1e3 * pipe,
                1e3 * hole
            ));
        }
        let velocity = self.get(Quantity::AirFlow)? / (area(hole) - area(pipe));
        let [slow, fast] = FLUSHING;
        (!(slow..=fast).contains(&velocity)).then(|| {
            format!(
                "The air rises at {velocity:.0} m/s between pipe and hole: makers ask for {slow} to {fast}."
            )
        })
    }

    /// A stroke for which the hammer is too short.
    fn too_short(&self, height: f64, unknowns: &Unknowns) -> Option<String> {
        let whole = self.get(Quantity::Length)?;
        let solid = unknowns.mass / (STEEL * area(self.bore()?));
        let piston = self.get(Quantity::PistonLength).unwrap_or(solid);
        (piston + height > ROOM * whole).then(|| {
            format!(
                "The piston of some {:.0} mm turns {:.0} mm above the bit: in a hammer of {:.0} mm \
                 there is no room for both beside its other parts.",
                1e3 * piston,
                1e3 * height,
                1e3 * whole
            )
        })
    }
}
