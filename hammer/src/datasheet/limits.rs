//! Physical and practical limits of hammers, and the sentences about their violation.

use super::assume::{SLEEVE, area};
use super::drilled::Drilled;
use super::member::Fluid;
use super::quantity::Quantity;
use super::sample::{Member, Sample};
use super::{Datasheet, DatasheetError, TURN};
use crate::numerics::display::digits;
use crate::quantities::warnings::{FASTEST, buried};

/// Most blows per second of an air hammer, and of any hammer. Air hammers make 15 to 45, water hammers up to 70.
const MOST_BY_AIR: f64 = 50.0;
const MOST: f64 = 75.0;
/// Part of a hammer's length that piston and stroke may take. Valve and back head take the rest.
const ROOM: f64 = 0.7;
/// Range of the air's velocity in the hole that makers recommend, m/s.
const FLUSHING: [f64; 2] = [15.0, 30.0];
/// Density of a piston that fills its bore, kg/m3, and its largest length in bore diameters. Makers' pistons have 1.3
/// to 2.5.
const STEEL: f64 = 7850.0;
const LONGEST: f64 = 6.0;
/// Largest diameter of the hole over the outside diameter. Makers' tables have up to 1.7.
const WIDEST: f64 = 2.0;
/// Most turns of a bit per second. Makers print 25 to 60 a minute, and up to 90.
const TURNS: f64 = 2.0;
/// Range of the advance per turn of a bit, m: a factor of 2 on either side of the 10 to 19 mm that makers recommend.
const ADVANCE: [f64; 2] = [5e-3, 38e-3];
/// Largest feed over the usual feed of a hammer, which is the printed one or the one that holds the casing down.
const PRESSED: f64 = 3.0;

impl Datasheet {
    /// Sentences about impossible numbers of the sample's hammers.
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
        list.extend(self.narrow());
        list.extend(self.heavy(sample));
        list.extend(self.too_short(sample));
        list.extend(self.flushed(sample));
        list.extend(self.overfed());
        // The effectiveness follows from the given numbers if they determine it, otherwise from the fitted hammers.
        let get = |quantity| self.get(quantity);
        let given = |bore: f64| {
            let force = get(Quantity::Pressure)? * area(bore);
            Some(get(Quantity::BlowEnergy)? / (force * get(Quantity::Stroke)?))
        };
        let effect = |m: &Member| given(m.held.bore).unwrap_or(m.held.effectiveness());
        let (effectiveness, [least, _]) = sample.number(effect);
        if least > 1.0 {
            let size = more(effectiveness, 1.0);
            list.push(format!("The mean driving pressure is {size} than all of the supply's."));
        }
        list
    }

    /// Sentences about impossible results of the scene at its feed.
    pub(super) fn drilled(
        &self,
        drilled: &Result<Drilled, DatasheetError>,
        sample: &Sample,
    ) -> Vec<String> {
        let drilled = match drilled {
            Ok(drilled) => drilled,
            Err(why) => {
                return vec![format!("feed: {why}. What is told is that of a casing held down.")];
            }
        };
        let mut list = Vec::new();
        let feed = self.get(Quantity::Feed);
        if let Some(feed) = feed.filter(|_| !drilled.held()) {
            list.push(format!(
                "The feed of {} kN does not hold the casing down: the bit hangs out of its shoulder for {:.0} % of the \
                 time, and with time the hammer may come to rest or fall into another motion. Printed numbers are \
                 those of a held casing.",
                digits(1e-3 * feed),
                100.0 * drilled.open
            ));
        }
        let [rate, ..] = drilled.errors;
        if rate > 0.01 {
            list.push(format!(
                "The blows differ from each other: of {} blows the rate is known to {:.0} %.",
                drilled.blows,
                100.0 * rate
            ));
        }
        list.extend(drilled.elsewhere.clone());
        let (rate_told, turns) = (sample.number(|m| m.rate).0, self.get(Quantity::Rotation));
        list.extend(buried(drilled.rate, drilled.tip_rate, drilled.tip_rate / drilled.frequency));
        match turns {
            Some(turns) if !(ADVANCE[0]..=ADVANCE[1]).contains(&(rate_told / turns)) => {
                list.push(format!(
                    "rotation: the hole advances {:.1} mm a turn, where makers recommend 10 to 19.",
                    1e3 * rate_told / turns
                ));
            }
            None if rate_told / TURN > TURNS => list.push(format!(
                "rotation: {:.0} turns a minute would be needed for {:.1} mm of advance a turn; rigs turn bits 25 to 90 \
                 times a minute. No rig drills at this rate.",
                60.0 * rate_told / TURN,
                1e3 * TURN
            )),
            _ => {}
        }
        list
    }

    /// Sentences about a hammer that is wider than its hole, and a bore that is wider than its hammer.
    fn narrow(&self) -> Vec<String> {
        let get = |quantity| self.get(quantity);
        let mm = |x: f64| digits(1e3 * x);
        let mut list = Vec::new();
        if let (Some(outer), Some(hole)) = (get(Quantity::OuterDiameter), get(Quantity::Hole)) {
            if hole <= outer {
                list.push(format!(
                    "A hammer of {} mm is not in a hole of {} mm.",
                    mm(outer),
                    mm(hole)
                ));
            } else if hole > WIDEST * outer {
                list.push(format!(
                    "hole: {} mm is {:.1} times the hammer's {} mm, and makers have bits of up to 1.7 times.",
                    mm(hole),
                    hole / outer,
                    mm(outer)
                ));
            }
        }
        if let (Some(outer), Some(bore)) = (get(Quantity::OuterDiameter), get(Quantity::Bore))
            && bore > 1.02 * SLEEVE * outer
        {
            list.push(format!(
                "A bore of {} mm does not fit in a hammer of {} mm: the inside of its sleeve has some {} mm.",
                mm(bore),
                mm(outer),
                mm(SLEEVE * outer)
            ));
        }
        list
    }

    /// A sentence about a piston that is too heavy for its bore.
    fn heavy(&self, sample: &Sample) -> Option<String> {
        let long = |m: &Member| m.blow.mass / (STEEL * area(m.blow.bore));
        let (bores, [least, _]) = sample.number(|m| long(m) / m.blow.bore);
        (self.fluid() == Fluid::Air && least > LONGEST).then(|| {
            format!(
                "piston_mass: a solid piston of {} kg would be {} mm long in its bore of {} mm, {bores:.0} times as long \
                 as wide: makers' are 1.3 to 2.5.",
                digits(sample.number(|m| m.blow.mass).0),
                digits(1e3 * sample.number(long).0),
                digits(1e3 * sample.number(|m| m.blow.bore).0)
            )
        })
    }

    /// A sentence about a feed that is too large for such a hammer.
    fn overfed(&self) -> Option<String> {
        let (feed, [printed, held]) = (self.get(Quantity::Feed)?, self.usual_feeds()?);
        (feed > PRESSED * held).then(|| {
            let [feed, printed, held] = [feed, printed, held].map(|x| digits(1e-3 * x));
            format!(
                "feed: {feed} kN is more than rigs put on such a hammer: makers print some {printed} kN, and {held} kN \
                 hold its casing down."
            )
        })
    }

    /// A sentence about a pipe that does not fit the hole, or about air that is too slow to lift cuttings or so fast
    /// that it wears the pipe.
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

    /// A sentence about piston and stroke that do not fit into the hammer's length.
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
