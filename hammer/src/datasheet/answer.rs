//! What a fit has found, in numbers and sentences.

use super::fit::{EFFECTIVE, Fit, Unknowns};
use super::quantity::Quantity;
use super::response::Response;
use super::{Comparison, OWN_BIT, Solution};
use crate::numerics::display::DisplayNumber;
use crate::presets::DAMPING;
use crate::sensitivity::Scene;

/// What is off by more than this part is told.
const TOLD: f64 = 0.01;

impl Fit<'_> {
    /// The answer, where the last simulation agrees with the fit.
    pub(super) fn answer(
        &self,
        unknowns: &Unknowns,
        response: &Response,
        mut scene: Scene,
    ) -> Solution {
        if let Some(measured) = self.sheet.get(Quantity::Rate) {
            let Response { energy, period, share, .. } = *response;
            let rate = self.rate(energy, period, share);
            scene.parameters.rock.specific_energy *= rate / measured;
        }
        let known = self.sheet.known.iter();
        let compared: Vec<Comparison> = known
            .filter_map(|(quantity, given)| {
                let solved = match quantity {
                    Quantity::BlowEnergy => Some(response.energy),
                    Quantity::Frequency => Some(1.0 / response.period),
                    Quantity::Power => Some(response.energy / response.period),
                    _ => self.value(*quantity, unknowns, response),
                };
                solved.map(|solved| Comparison { quantity: *quantity, given: *given, solved })
            })
            .collect();
        let off = compared.iter().filter(|compared| compared.off().abs() > TOLD);
        let mut contradictions: Vec<String> = off.map(sentence).collect();
        if self.has_pressure() && unknowns.effectiveness > 1.0 {
            contradictions.push(format!(
                "The mean driving pressure is {:.3} of the supply's: more than all of it.",
                unknowns.effectiveness
            ));
        }
        let found = self.found(unknowns, response, &scene);
        Solution { scene, compared, found, assumed: self.assumptions(), contradictions }
    }

    fn found(
        &self,
        unknowns: &Unknowns,
        response: &Response,
        scene: &Scene,
    ) -> Vec<(&'static str, f64, &'static str)> {
        let Response { energy, period, share, rebound, .. } = *response;
        let throw = self.throw(unknowns, response);
        let mut list = vec![
            ("blow energy", energy, "J"),
            ("frequency", 1.0 / period, "Hz"),
            ("power of the blows", energy / period, "W"),
            ("impact speed", (2.0 * energy / unknowns.mass).sqrt(), "m/s"),
            ("piston mass", unknowns.mass, "kg"),
            ("driving force", unknowns.force, "N"),
            ("height where the piston turns", throw.height, "m"),
            ("rebound of the piston over its impact speed", rebound, ""),
            ("work to the rock over blow energy", share, ""),
            ("power to the rock", share * energy / period, "W"),
        ];
        if self.has_pressure() {
            let name = "effectiveness: mean driving pressure over the supply's";
            list.push((name, unknowns.effectiveness, ""));
        }
        list.push(match self.sheet.get(Quantity::Rate) {
            None => ("rate of penetration", self.rate(energy, period, share), "m/s"),
            Some(_) => {
                let energy = scene.parameters.rock.specific_energy;
                ("specific energy from the rate", energy, "J/m3")
            }
        });
        list
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
        let slender = !given(Quantity::PistonLength);
        say(slender, "The piston is as slender as the reference hammer's.".into());
        say(!given(Quantity::BitMass), "The bit is as long and as heavy as the piston.".into());
        say(true, "Piston and bit have one section, constant along them.".into());
        say(
            self.assumed,
            format!("The mean driving pressure is {EFFECTIVE} of the supply's (effectiveness)."),
        );
        say(
            given(Quantity::AirFlow) && given(Quantity::Pressure),
            "Air works at the supply's pressure: a blow takes the volume of its energy over the \
             pressure."
                .into(),
        );
        say(
            given(Quantity::OilFlow) && self.area().is_some(),
            "A blow takes the bore full of fluid, from the bit to where the piston turns.".into(),
        );
        say(
            !given(Quantity::DampingRatio),
            format!("The damping ratio of the piston's first elastic mode is {DAMPING}."),
        );
        match sheet.get(Quantity::BitDiameter) {
            _ if sheet.own_rock => {}
            None => {
                let bit = 1e3 * OWN_BIT;
                say(true, format!("The rock is that under a bit of {bit} mm."));
            }
            Some(hole) => {
                let (bit, share) = (1e3 * OWN_BIT, (hole / OWN_BIT) * (hole / OWN_BIT));
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
        for (quantity, flow) in
            [(Quantity::Pressure, Quantity::AirFlow), (Quantity::Bore, Quantity::OilFlow)]
        {
            say(
                given(quantity) && !self.has_pressure() && !given(flow),
                format!(
                    "{} is not used: it says nothing without the other of pressure and bore.",
                    quantity.name()
                ),
            );
        }
        list
    }
}

/// A number to four digits.
fn digits(number: f64) -> DisplayNumber {
    DisplayNumber(format!("{number:.3e}").parse().unwrap_or(number))
}

/// A contradiction in words.
fn sentence(compared: &Comparison) -> String {
    let Comparison { quantity, given, solved } = *compared;
    let (name, unit, off) = (quantity.name(), quantity.unit(), 100.0 * compared.off());
    let (size, side) = (off.abs(), if off > 0.0 { "more" } else { "less" });
    let [given, solved] = [given, solved].map(digits);
    format!(
        "{name}: {given} {unit} given, {solved} {unit} of the hammer that fits all best: \
         {size:.1} % {side}."
    )
}
