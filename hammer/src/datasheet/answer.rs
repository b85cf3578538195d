//! The answer to a datasheet: numbers, sentences, and the scene of the sample's median hammer.

use super::air::AirBlow;
use super::assume::area;
use super::drilled::Drilled;
use super::member::{Blow, Fluid, LIFT, Row, low};
use super::quantity::Quantity;
use super::sample::{Member, Sample};
use super::sizes::FEED;
use super::{Comparison, Datasheet, DatasheetError, Found, Solution};
use crate::numerics::display::digits;
use crate::numerics::math;
use crate::presets::{AirHammer, DAMPING, REFERENCE_HOLE};
use crate::quantities::air::ATMOSPHERE;
use crate::quantities::parameters::{MAX_ELEMENTS, Parameters, Rock};
use crate::quantities::sections::{Body, Segment};
use crate::scene::Scene;

/// Advance of the hole per turn of the bit, m: the middle of the 10 to 19 mm that makers recommend (Epiroc).
pub const TURN: f64 = 0.0145;
/// Name of the free air that drives the piston, used if the hammer takes more than this at low pressure.
pub const THROUGH: &str = "free air through the chambers";
/// Name of the same air as it enters the compressor.
pub const SUCKED: &str = "air at the compressor's inlet";
/// Temperature of normal air, K; its pressure is 1.01325e5 Pa (DIN 1343).
const NORMAL: f64 = 273.15;
/// Most rounds that adjust the scene until its blows are those of the median hammer, and the logarithmic error at which
/// they stop.
const ROUNDS: usize = 4;
const CLOSE: f64 = 1e-2;

impl Datasheet {
    /// The answer of a sample, in the rock of a scene.
    pub(super) fn answer(
        &self,
        base: Scene,
        middle: Result<(Scene, Result<Drilled, DatasheetError>), DatasheetError>,
        sample: &Sample,
    ) -> Result<Solution, DatasheetError> {
        let found = self.found(&base, sample);
        let compared = sample.solved.iter().map(|(row, solved)| {
            let Row { quantity, pressure, given, .. } = *row;
            (*row, Comparison { quantity, pressure, given, solved: *solved })
        });
        let compared: Vec<(Row, Comparison)> = compared.collect();
        let off = compared.iter().filter(|(row, c)| math::ln(c.solved / c.given).abs() > row.error);
        let mut contradictions: Vec<String> = off.map(|(_, compared)| sentence(compared)).collect();
        contradictions.extend(self.impossible(sample));
        let mut scene = match middle {
            Ok((scene, drilled)) => {
                contradictions.extend(self.drilled(&drilled, sample));
                scene
            }
            Err(DatasheetError::Engine(error)) => return Err(error.into()),
            Err(other) => {
                contradictions.push(format!("No steady blow is found: {other}."));
                base
            }
        };
        let (energy, [least, most]) = sample.number(|m| m.specific_energy);
        let (_, [slow, fast]) = sample.number(|m| m.rate);
        let rock = &mut scene.parameters.rock;
        let mut assumed = self.assumptions();
        if self.get(Quantity::Rate).is_some() {
            contradictions.extend(of_rock(rock, energy, [least, most]));
            rock.specific_energy = energy;
            let [energy, low, high] = [energy, least, most].map(|x| digits((1e-6 * x).round()));
            assumed.push(format!(
                "The specific energy, {energy} MJ/m3 ({low} to {high}), is that with which this hammer drills at the \
                 measured rate."
            ));
        }
        // The range of the scene's rate must be that of the answer. A run of the scene has only the rock's range, so
        // this range also includes the uncertainty of the hammer.
        if slow > 0.0 {
            rock.specific_energy_factor = (fast / slow).sqrt();
        }
        Ok(Solution {
            scene,
            compared: compared.into_iter().map(|(_, compared)| compared).collect(),
            found,
            weights: sample.members.iter().map(|member| member.weight).collect(),
            assumed,
            contradictions,
        })
    }

    /// All numbers that follow, with their ranges.
    pub(super) fn found(&self, scene: &Scene, sample: &Sample) -> Vec<Found> {
        let p = &scene.parameters;
        let row = |name, unit, of: &dyn Fn(&Member) -> f64| {
            let (value, range) = sample.number(of);
            let members = sample.members.iter().map(of).collect();
            Found { name, value, range, unit, members }
        };
        let mut list = vec![
            row("rate of penetration", "m/s", &|m| m.rate),
            row("blow energy", "J", &|m| m.blow.energy),
            row("frequency", "Hz", &|m| m.blow.frequency),
            row("power of the blows", "W", &|m| m.blow.power()),
            row("impact speed", "m/s", &|m| m.blow.speed()),
            row("piston mass", "kg", &|m| m.blow.mass),
            row("bore", "m", &|m| m.blow.bore),
            row("height where the piston turns", "m", &|m| m.blow.height),
            row("effectiveness: mean driving pressure over the supply's", "", &|m| {
                m.blow.effectiveness()
            }),
            row("work to the rock over blow energy", "", &|m| m.share),
            row("power to the rock", "W", &|m| m.share * m.blow.power()),
            row("specific energy", "J/m3", &|m| m.specific_energy),
            row("largest rock force", "N", &|m| m.peak),
            // Where two bars of one section meet, each takes half the speed.
            row("stress of the first wave in piston and bit", "Pa", &|m| {
                0.5 * p.material.density * p.wave_speed() * m.blow.speed()
            }),
            row("feed", "N", &|m| m.feed),
        ];
        if self.fluid() == Fluid::Air {
            list.push(row("free air", "m3/s", &|m| m.blow.flow));
            if self.working_pressure().is_some_and(|pressure| low(pressure) > 0.0) {
                list.push(row(THROUGH, "m3/s", &|m| m.blow.driving));
            }
        }
        if let Some(by) = self.sucked_in().filter(|_| self.fluid() == Fluid::Air) {
            list.push(row(SUCKED, "m3/s", &|m| by * m.blow.flow));
        }
        if self.get(Quantity::Feed).is_some() {
            list.push(row("blow energy, casing held", "J", &|m| m.held.energy));
            list.push(row("frequency, casing held", "Hz", &|m| m.held.frequency));
            list.push(row("power of the blows, casing held", "W", &|m| m.held.power()));
            if self.fluid() == Fluid::Air {
                list.push(row("free air, casing held", "m3/s", &|m| m.held.flow));
            }
        }
        list.push(match self.get(Quantity::Rotation) {
            Some(rotation) => row("advance per turn", "m", &|m| m.rate / rotation),
            None => row("rotation for 10 to 19 mm of advance per turn", "Hz", &|m| m.rate / TURN),
        });
        if let (Some((hole, _)), Some(pipe)) = (self.hole(), self.get(Quantity::Pipe)) {
            let ring = area(hole) - area(pipe);
            let given = self.get(Quantity::AirFlow);
            list.push(row("up-hole velocity of the air", "m/s", &|m| {
                given.unwrap_or(m.blow.flow) / ring
            }));
        }
        list
    }

    /// Volume of the air that a compressor takes in, over the volume of the same air at normal conditions. It depends
    /// on the altitude (International Standard Atmosphere) and the inlet temperature; `None` if neither is given.
    fn sucked_in(&self) -> Option<f64> {
        let [altitude, inlet] = [Quantity::Altitude, Quantity::Inlet].map(|q| self.get(q));
        altitude.or(inlet)?;
        let altitude = altitude.unwrap_or(0.0);
        let pressure = math::exp(5.25588 * math::ln(1.0 - 2.25577e-5 * altitude));
        Some(inlet.unwrap_or(288.15 - 6.5e-3 * altitude) / (NORMAL * pressure))
    }

    fn assumptions(&self) -> Vec<String> {
        let given = |quantity| self.get(quantity).is_some();
        let mut list = self.of_blows();
        let mut say = |if_so: bool, text: String| list.extend(if_so.then_some(text));
        if self.fluid() == Fluid::Air {
            let place = match self.sucked_in() {
                Some(by) => format!(" The compressor's inlet takes {by:.3} times as much."),
                None => " By ISO 1217 (20 degC, 1 bar) it is 1.087 times as much; altitude= and inlet= give that of a \
                         compressor's place."
                    .into(),
            };
            say(true, format!("Free air is normal air: of 0 degC and 1.013 bar.{place}"));
            if let Some(pressure) = self.working_pressure() {
                let bar = |x: f64| digits((1e-3 * x).round() * 1e-2);
                let (gauge, absolute) = (bar(pressure), bar(pressure + ATMOSPHERE));
                say(
                    true,
                    format!(
                        "The pressure, {gauge} bar, is over the exhaust's; the scene has its absolute supply pressure, \
                         {absolute} bar."
                    ),
                );
                if low(pressure) > 0.0 {
                    say(
                        true,
                        "At 6 bar and below makers print 1.65 times the air that drives the piston, falling to 1 at 10 \
                         bar: a guess from seven rows, to 27 %."
                            .into(),
                    );
                }
            }
        }
        say(!given(Quantity::BitMass), "The bit is as long and as heavy as the piston.".into());
        say(true, "Piston and bit have one section, constant along them.".into());
        if let (None, Some([_, feed])) = (self.get(Quantity::Feed), self.usual_feeds()) {
            say(
                true,
                format!(
                    "The feed is {} kN, {}.",
                    digits(1e-3 * feed),
                    self.outer().and_then(|(outer, ..)| FEED.guess(outer)).unwrap_or_else(|| {
                        "which holds the casing of that size down at that pressure".into()
                    })
                ),
            );
        }
        say(
            !given(Quantity::DampingRatio),
            format!("The damping ratio of the piston's first elastic mode is {DAMPING}."),
        );
        if let Some((hole, from)) = self.hole() {
            let share = (hole / REFERENCE_HOLE) * (hole / REFERENCE_HOLE);
            if let Some(from) = from {
                let hole = digits(1e3 * hole);
                say(true, format!("The hole is {hole} mm wide, usual for that {from}."));
            }
            say(
                !self.own_rock,
                format!(
                    "The rock's stiffness, viscosity and barrier are those meant for a bit of {} mm, times {}: in \
                     proportion to the hole's area; its hardness is known up to a factor of 1.75.",
                    1e3 * REFERENCE_HOLE,
                    digits(share)
                ),
            );
        }
        list
    }

    /// The scene of the median hammer in the rock of `base`, and its long-run means. The scene is adjusted until its
    /// blows are the sample's, under the feed that holds the casing down. Then it gets the feed of the sheet.
    pub(super) fn hammer(
        &self,
        base: &Scene,
        sample: &Sample,
    ) -> Result<(Scene, Result<Drilled, DatasheetError>), DatasheetError> {
        let [energy, frequency] =
            [sample.number(|m| m.held.energy).0, sample.number(|m| m.held.frequency).0];
        let mut hammer = sample.hammer;
        let mut round = 0;
        loop {
            let mut scene = self.dressed(base, &hammer)?;
            let blow = AirBlow::of(&scene)?;
            let [more, faster] = [energy / blow.energy, frequency * blow.period].map(math::ln);
            if round == ROUNDS || more.abs().max(faster.abs()) < CLOSE {
                let feed = self.get(Quantity::Feed);
                scene.inputs.feed_force = feed.unwrap_or(scene.inputs.feed_force);
                return Ok((scene, Drilled::of(&scene, feed.is_some())));
            }
            // Energy is proportional to area times stroke, and the square of the frequency to area over stroke.
            let by = |x: f64| math::exp((0.5 * x).clamp(-0.3, 0.3));
            hammer.bore *= by(0.5 * (more + 2.0 * faster));
            hammer.height *= by(more - 2.0 * faster);
            round += 1;
        }
    }

    /// The scene of a hammer. Its `height` is the stroke over the presets' stroke; its `flow` is the area of a port.
    fn dressed(&self, base: &Scene, hammer: &Blow) -> Result<Scene, DatasheetError> {
        let own = base.parameters;
        let length = self.get(Quantity::PistonLength);
        let mut scene = match self.fluid() {
            Fluid::Air => {
                let outer = self.outer().map_or(hammer.bore, |(outer, ..)| outer);
                let (hole, feed) = (own.hole.diameter, base.inputs.feed_force);
                let mut air = AirHammer::in_proportion(outer, hammer.mass, hole, feed);
                air.outer = hammer.bore / (AirHammer::BORE * AirHammer::DRIVE.sqrt());
                (air.supply, air.stroke) = (hammer.flow, hammer.height);
                air.at(hammer.pressure)
            }
            Fluid::Liquid => {
                let mut scene = *base;
                let p = &mut scene.parameters;
                p.drive.amplitude = hammer.pressure * area(hammer.bore);
                p.drive.stroke = LIFT * hammer.height;
                p.contact.initial_gap = p.drive.stroke;
                let slender = own.piston.length * math::cbrt(hammer.mass / own.piston_mass());
                let length = length.unwrap_or(slender);
                let section = hammer.mass / (p.material.density * length);
                p.contact.stiffness *= section / p.cross_section;
                p.piston.segments.set_count(0);
                p.bit.segments.set_count(0);
                (p.piston.length, p.bit.length, p.cross_section) = (length, length, section);
                let spans = own.piston.elements as f64 * length / own.piston.length;
                let spans = (spans.round() as usize).clamp(1, MAX_ELEMENTS);
                (p.piston.elements, p.bit.elements) = (spans, spans);
                scene
            }
        };
        let p: &mut Parameters = &mut scene.parameters;
        (p.rock, p.hole, p.gravity, p.fidelity) = (own.rock, own.hole, own.gravity, own.fidelity);
        let density = p.material.density;
        if let (Some(length), Fluid::Air) = (length, self.fluid()) {
            p.piston.segments.set(&[Segment { length, area: hammer.mass / (density * length) }]);
        }
        if let Some(mass) = self.get(Quantity::BitMass) {
            let section = p.sections(Body::Bit);
            let by = mass / section.mass(density);
            // If there are sections, the length of the uniform bit is not used and stays.
            *p.bit.segments.first_mut().map_or(&mut p.bit.length, |first| &mut first.length) *= by;
        }
        let damping = p.damping_time_of(self.get(Quantity::DampingRatio).unwrap_or(DAMPING));
        p.material.damping_time = damping.unwrap_or(p.material.damping_time);
        p.validate().map_err(crate::error::Error::from)?;
        Ok(scene)
    }
}

/// A sentence about a measured rate, if the specific energies that it implies lie outside the range of this rock.
fn of_rock(rock: &Rock, energy: f64, [low, high]: [f64; 2]) -> Option<String> {
    let factor = rock.specific_energy_factor;
    let [least, most] = [rock.specific_energy / factor, rock.specific_energy * factor];
    (low > most || high < least).then(|| {
        let all = [energy, low, high, least, most].map(|x| digits((1e-6 * x).round()));
        let [energy, low, high, least, most] = all;
        format!(
            "rop: the measured rate gives a specific energy of {energy} MJ/m3 ({low} to {high}), where this rock has \
             {least} to {most}."
        )
    })
}

/// A sentence about a given number that the hammers cannot meet.
fn sentence(compared: &Comparison) -> String {
    let Comparison { quantity, pressure, given, solved } = *compared;
    let ((unit, size), name) = (quantity.entry().field, quantity.name());
    let off = 100.0 * compared.off();
    let [given, solved] = [given / size, solved / size].map(digits);
    let (size, side) = (off.abs(), if off > 0.0 { "more" } else { "less" });
    let at = pressure.map(|at| format!(" at {} bar", digits(1e-5 * at))).unwrap_or_default();
    format!(
        "{name}{at}: {given} {unit} given, {solved} {unit} of the hammers that fit all best: {size:.1} % {side}."
    )
}
