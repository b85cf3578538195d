//! What a fit has found, in numbers and sentences.

use super::air::AirBlow;
use super::assume::{Assumption, area};
use super::fit::{Fit, Unknowns};
use super::quantity::Quantity;
use super::response::Response;
use super::{Comparison, Found, Solution};
use crate::numerics::display::digits;
use crate::numerics::math;
use crate::presets::{AirHammer, DAMPING, REFERENCE_HOLE};
use crate::scene::Scene;

/// Advance of the hole per turn of the bit that makers recommend (Epiroc), m: named where it is told.
const ADVANCE: [f64; 2] = [0.010, 0.019];
/// What is off by more than this part is told; of an air hammer, by what its model is off itself.
const TOLD: f64 = 0.01;
const TOLD_OF_AIR: f64 = 0.16;
/// Numbers of a relay: air has others, or none.
const OF_RELAY: [&str; 4] = [
    "driving force",
    "height where the piston turns",
    "rebound of the piston over its impact speed",
    "effectiveness: mean driving pressure over the supply's",
];

impl Fit<'_> {
    /// The answer, where the last simulation agrees with the fit.
    pub(super) fn answer(
        &self,
        unknowns: &Unknowns,
        response: &Response,
        mut scene: Scene,
        air: Option<&AirBlow>,
    ) -> Solution {
        if let Some(measured) = self.sheet.get(Quantity::Rate) {
            let Response { energy, period, share, .. } = *response;
            let rate = self.rate(energy, period, share);
            let rock = &mut scene.parameters.rock;
            rock.specific_energy *= rate / measured;
            rock.specific_energy_factor = 1.0 + Quantity::Rate.error();
        }
        let stated = self.sheet.known.iter();
        let compared: Vec<Comparison> = stated
            .filter_map(|(quantity, given)| {
                let solved = match quantity {
                    Quantity::AirFlow if air.is_some() => air.map(|blow| blow.flow),
                    Quantity::BlowEnergy => Some(response.energy),
                    Quantity::Frequency => Some(1.0 / response.period),
                    Quantity::Power => Some(response.energy / response.period),
                    _ => self.value(*quantity, unknowns, response),
                };
                solved.map(|solved| Comparison { quantity: *quantity, given: *given, solved })
            })
            .collect();
        let tolerance = if air.is_some() { TOLD_OF_AIR } else { TOLD };
        let off = compared.iter().filter(|compared| compared.off().abs() > tolerance);
        let mut contradictions: Vec<String> = off.map(sentence).collect();
        contradictions.extend(match air {
            Some(blow) => blow.impossible(self.sheet),
            None => self.impossible(unknowns, response),
        });
        let mut found = self.found(unknowns, response, &scene);
        let mut assumed = self.assumptions();
        if let Some(blow) = air {
            found.retain(|row| !OF_RELAY.contains(&row.name));
            let value = blow.flow;
            found.push(Found { name: "free air", value, range: [value; 2], unit: "m3/s" });
            assumed.push(AirHammer::ASSUMED.into());
        }
        Solution { scene, compared, found, assumed, contradictions }
    }

    /// What follows, with the range of what is not determined.
    fn found(&self, unknowns: &Unknowns, response: &Response, scene: &Scene) -> Vec<Found> {
        let Response { energy, period, share, returned, .. } = *response;
        let throw = self.throw(unknowns, response);
        let error = |of| self.error(of, unknowns, response);
        let between = |name, value: f64, error: f64, unit| {
            let factor = math::exp(error);
            Found { name, value, range: [value / factor, value * factor], unit }
        };
        let ranged = |name, value, of, unit| between(name, value, error(of), unit);
        let plain = |name, value, unit| Found { name, value, range: [value; 2], unit };
        let mut list = vec![
            ranged("blow energy", energy, Quantity::BlowEnergy, "J"),
            ranged("frequency", 1.0 / period, Quantity::Frequency, "Hz"),
            ranged("power of the blows", energy / period, Quantity::Power, "W"),
            ranged(
                "impact speed",
                (2.0 * energy / unknowns.mass).sqrt(),
                Quantity::ImpactSpeed,
                "m/s",
            ),
            ranged("piston mass", unknowns.mass, Quantity::PistonMass, "kg"),
            plain("driving force", unknowns.force, "N"),
            ranged("height where the piston turns", throw.height, Quantity::Stroke, "m"),
            plain("rebound of the piston over its impact speed", returned.max(0.0).sqrt(), ""),
            plain("work to the rock over blow energy", share, ""),
            ranged("power to the rock", share * energy / period, Quantity::Power, "W"),
        ];
        if self.sheet.has_pressure() {
            let name = "effectiveness: mean driving pressure over the supply's";
            list.push(ranged(name, unknowns.effectiveness, Quantity::Effectiveness, ""));
            list.push(ranged("bore", unknowns.bore, Quantity::Bore, "m"));
        }
        let rock = &scene.parameters.rock;
        list.push(self.turning(self.rate(energy, period, share)));
        list.extend(self.flushing());
        list.push(match self.sheet.get(Quantity::Rate) {
            None => {
                let of_rock = math::ln(rock.specific_energy_factor);
                let wide = of_rock.hypot(error(Quantity::Power));
                between("rate of penetration", self.rate(energy, period, share), wide, "m/s")
            }
            Some(_) => {
                let wide = math::ln(rock.specific_energy_factor).hypot(error(Quantity::Power));
                between("specific energy from the rate", rock.specific_energy, wide, "J/m3")
            }
        });
        list
    }

    /// Rate over rotation: the advance per turn, or the rotation that gives the usual one.
    fn turning(&self, rate: f64) -> Found {
        let [least, most] = ADVANCE;
        match self.sheet.get(Quantity::Rotation) {
            Some(rotation) => {
                let value = rate / rotation;
                Found { name: "advance per turn", value, range: [value; 2], unit: "m" }
            }
            None => Found {
                name: "rotation for 10 to 19 mm of advance per turn",
                value: rate / (0.5 * (least + most)),
                range: [rate / most, rate / least],
                unit: "Hz",
            },
        }
    }

    /// Velocity of the free air that rises between hole and pipe.
    fn flushing(&self) -> Option<Found> {
        let flow = self.sheet.get(Quantity::AirFlow)?;
        let ((hole, _), pipe) = (self.sheet.hole()?, self.sheet.get(Quantity::Pipe)?);
        let value = flow / (area(hole) - area(pipe));
        Some(Found { name: "up-hole velocity of the air", value, range: [value; 2], unit: "m/s" })
    }

    fn assumptions(&self) -> Vec<String> {
        let sheet = self.sheet;
        let given = |quantity| sheet.get(quantity).is_some();
        let mut list = Vec::new();
        let mut say = |if_so: bool, text: String| {
            if if_so {
                list.push(text);
            }
        };
        let of_air = sheet.of_air().is_some();
        let slender = !given(Quantity::PistonLength) && !of_air;
        say(slender, "The piston is as slender as the reference hammer's.".into());
        say(!given(Quantity::BitMass), "The bit is as long and as heavy as the piston.".into());
        say(true, "Piston and bit have one section, constant along them.".into());
        // Of the throw of a relay, which an air hammer does not have.
        let relay_too = |row: &&Assumption| {
            !of_air || !matches!(row.quantity, Quantity::Effectiveness | Quantity::ImpactSpeed)
        };
        for text in self
            .assumed
            .iter()
            .filter(relay_too)
            .map(|row| row.text.clone())
            .chain(sheet.of_fluids())
        {
            say(true, text);
        }
        if let (None, Some(feed)) = (sheet.get(Quantity::Feed), sheet.usual_feed()) {
            let text = format!("The feed is {} kN, usual for that size.", digits(1e-3 * feed));
            say(true, text);
        }
        say(
            !given(Quantity::DampingRatio),
            format!("The damping ratio of the piston's first elastic mode is {DAMPING}."),
        );
        if let Some((hole, Some(from))) = sheet.hole() {
            let text =
                format!("The hole is {} mm wide, usual for that {from}.", digits(1e3 * hole));
            say(true, text);
        }
        let bit = 1e3 * REFERENCE_HOLE;
        match sheet.hole() {
            _ if sheet.own_rock => {}
            None => say(true, format!("The rock is that under a bit of {bit} mm.")),
            Some((hole, _)) => {
                let share = (hole / REFERENCE_HOLE) * (hole / REFERENCE_HOLE);
                say(
                    true,
                    format!(
                        "The rock's stiffness, viscosity and barrier are those meant for a bit of \
                         {bit} mm, times {}: in proportion to the hole's area.",
                        digits(share)
                    ),
                );
            }
        }
        let used = [Quantity::AirFlow, Quantity::Flow];
        let unused = !sheet.has_pressure() && !used.iter().any(|flow| given(*flow));
        for quantity in [Quantity::Pressure, Quantity::Bore] {
            say(
                given(quantity) && unused,
                format!(
                    "{} is not used: it says nothing without the other of pressure and bore.",
                    quantity.name()
                ),
            );
        }
        list
    }
}

/// A contradiction in words.
fn sentence(compared: &Comparison) -> String {
    let Comparison { quantity, given, solved } = *compared;
    let ((unit, size), name) = (quantity.field_unit(), quantity.name());
    let off = 100.0 * compared.off();
    let [given, solved] = [given / size, solved / size];
    let (size, side) = (off.abs(), if off > 0.0 { "more" } else { "less" });
    let [given, solved] = [given, solved].map(digits);
    format!(
        "{name}: {given} {unit} given, {solved} {unit} of the hammer that fits all best: \
         {size:.1} % {side}."
    )
}
