//! What no hammer can do, in words of the trade.

use super::Datasheet;
use super::assume::area;
use super::member::Fluid;
use super::quantity::Quantity;
use super::sample::Sample;
use crate::quantities::warnings::FASTEST;

/// Most blows per second of an air hammer, and of any: air hammers do 15 to 45, water hammers up to 70.
const MOST_BY_AIR: f64 = 50.0;
const MOST: f64 = 75.0;
/// Part of a hammer's length for piston and stroke. Valve and back head take the rest.
const ROOM: f64 = 0.7;
/// Range of the air's velocity in the hole that makers ask for, m/s.
const FLUSHING: [f64; 2] = [15.0, 30.0];
/// Density of a piston that fills its bore, kg/m3.
const STEEL: f64 = 7850.0;

impl Datasheet {
    /// What is impossible about the sample's hammers, a sentence each.
    pub(super) fn impossible(&self, sample: &Sample) -> Vec<String> {
        let mut list = Vec::new();
        let more = |of: f64, limit: f64| format!("{:.0} % more", 100.0 * (of / limit - 1.0));
        let speed = sample.asked_speed;
        if speed > FASTEST {
            list.push(format!(
                "As given, the piston would strike at {speed:.1} m/s, {} than the {FASTEST} m/s beyond which steel \
                 does not last. The slower ones of the hammers that the sheet allows are told.",
                more(speed, FASTEST)
            ));
        }
        let (frequency, [least, _]) = sample.number(|m| m.blow.frequency);
        let most = if self.fluid() == Fluid::Air { MOST_BY_AIR } else { MOST };
        if least > most {
            list.push(format!(
                "{frequency:.0} blows a second, {} than the {most} that the fastest hammers do: air hammers do 15 to \
                 45 a second, water hammers up to 70.",
                more(frequency, most)
            ));
        }
        list.extend(self.too_short(sample));
        list.extend(self.flushed(sample));
        let (effectiveness, [least, _]) = sample.number(|m| m.blow.effectiveness());
        if least > 1.0 {
            let size = more(effectiveness, 1.0);
            list.push(format!("The mean driving pressure is {size} than all of the supply's."));
        }
        list
    }

    /// A pipe that does not fit the hole, or air too slow to lift cuttings or so fast that it wears the pipe.
    fn flushed(&self, sample: &Sample) -> Option<String> {
        let ((hole, _), pipe) = (self.hole()?, self.get(Quantity::Pipe)?);
        if pipe >= hole {
            return Some(format!(
                "A pipe of {:.0} mm is not in a hole of {:.0} mm.",
                1e3 * pipe,
                1e3 * hole
            ));
        }
        let air = self.get(Quantity::AirFlow).unwrap_or(sample.number(|m| m.blow.flow).0);
        let velocity = air / (area(hole) - area(pipe));
        let [slow, fast] = FLUSHING;
        (!(slow..=fast).contains(&velocity)).then(|| {
            format!(
                "The air rises at {velocity:.0} m/s between pipe and hole: makers ask for {slow} to {fast}."
            )
        })
    }

    /// Piston and stroke that do not fit the hammer's length.
    fn too_short(&self, sample: &Sample) -> Option<String> {
        let whole = self.get(Quantity::Length)?;
        let height = sample.number(|m| m.blow.height).0;
        let solid = sample.number(|m| m.blow.mass / (STEEL * area(m.blow.bore))).0;
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
