//! Hammers that air drives: settled blows of one, and the ports with which it takes its air.

use super::fit::Unknowns;
use super::response::Response;
use super::{Datasheet, DatasheetError, Quantity};
use crate::numerics::math;
use crate::presets::AirHammer;
use crate::quantities::air::ATMOSPHERE;
use crate::quantities::parameters::InputValues;
use crate::quantities::sections::Segment;
use crate::scene::Scene;

/// Blows until they repeat, and of the mean after them.
const SETTLED: u64 = 12;
const MEANT: u64 = 6;
/// Longest that is looked for them, s.
const PATIENCE: f64 = 3.0;
/// How closely the air is met, and in how many rounds.
const CLOSE: f64 = 2e-3;
const ROUNDS: usize = 8;
/// Outside diameters of the hammers that the model is known of, m: 3.5 to 6 inches.
const SIZES: [f64; 2] = [0.079, 0.155];
/// Feed over outside diameter squared and pressure: what the presets of 4 and 5 inches have.
const FEED: f64 = 0.58;

/// Means of settled blows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirBlow {
    /// Energy of the piston, J.
    pub energy: f64,
    /// Period, s.
    pub period: f64,
    /// Speed of the impact, m/s.
    pub speed: f64,
    /// Free air, m3/s.
    pub flow: f64,
    /// Work given to the rock, J.
    pub rock_work: f64,
    /// Rate of penetration, m/s.
    pub rate: f64,
}

impl AirBlow {
    /// Of a scene, as soon as its blows repeat.
    ///
    /// # Errors
    /// The engine's; a hammer that does not strike so often.
    pub fn settled(scene: &Scene) -> Result<Self, DatasheetError> {
        let mut machine = scene.machine()?;
        let mut sum = [0.0; 6];
        let mut counted = 0;
        while machine.counters().blows < SETTLED + MEANT {
            machine.advance(machine.time() + 2e-3)?;
            let blows = machine.counters().blows;
            if let Some(blow) = machine.blow().filter(|_| blows > counted.max(SETTLED)) {
                let b = blow;
                let all = [b.energy, b.period, b.speed, b.air_flow, b.rock_work, b.rop];
                sum.iter_mut().zip(all).for_each(|(sum, new)| *sum += new / MEANT as f64);
            }
            counted = blows;
            if machine.time() > PATIENCE {
                return Err(DatasheetError::Contradiction(format!(
                    "an air hammer of these numbers strikes {counted} times in {PATIENCE} s: it stalls"
                )));
            }
        }
        let [energy, period, speed, flow, rock_work, rate] = sum;
        Ok(Self { energy, period, speed, flow, rock_work, rate })
    }
}

impl Datasheet {
    /// The outside diameter, if the sheet says pressure and air of a hammer in the range of the model and
    /// nothing of a blow: those numbers would be fitted by more than the ports.
    pub(super) fn of_air(&self) -> Option<f64> {
        let given = |quantity: &Quantity| self.get(*quantity).is_some();
        let of_blow = [
            Quantity::BlowEnergy,
            Quantity::Frequency,
            Quantity::ImpactSpeed,
            Quantity::Stroke,
            Quantity::Effectiveness,
            Quantity::PistonLength,
        ];
        let air = self.is_air() && given(&Quantity::AirFlow) && !of_blow.iter().any(given);
        let outer = self.outer()?.0;
        (air && (SIZES[0]..=SIZES[1]).contains(&outer)).then_some(outer)
    }

    /// The feed that holds the casing of an air hammer down, N.
    pub(super) fn feed_of_air(&self) -> Option<f64> {
        let outer = self.of_air()?;
        Some(FEED * outer * outer * self.get(Quantity::Pressure)?)
    }

    /// The hammer with its air inside, its ports fitted to the air that it takes, and its blows. Rock,
    /// hole and material are those of the scene.
    pub(super) fn with_air(
        &self,
        scene: &Scene,
        unknowns: &Unknowns,
    ) -> Option<Result<(Scene, AirBlow), DatasheetError>> {
        let (outer, pressure) = (self.of_air()?, self.get(Quantity::Pressure)?);
        let wanted = self.get(Quantity::AirFlow)?;
        let feed = self.get(Quantity::Feed).or_else(|| self.feed_of_air())?;
        let hole = scene.parameters.hole.diameter;
        let mut hammer = AirHammer::in_proportion(outer, unknowns.mass, hole, feed);
        hammer.outer = self.get(Quantity::Bore).map_or(outer, |bore| bore / AirHammer::BORE);
        let dressed = |hammer: &AirHammer| {
            let mut of_air = hammer.at(pressure);
            let (p, own) = (&mut of_air.parameters, &scene.parameters);
            (p.rock, p.hole, p.material, p.gravity) =
                (own.rock, own.hole, own.material, own.gravity);
            if let Some(mass) = self.get(Quantity::BitMass) {
                let Segment { area, .. } = p.bit.segment[0];
                p.bit.segment[0].length = mass / (p.material.density * area);
            }
            of_air
        };
        let fitted = hammer.fitted(dressed, wanted, |blow| blow.flow);
        Some(fitted.map(|(hammer, blow)| (dressed(&hammer), blow)))
    }
}

impl AirBlow {
    /// The same as of simulated blows of a relay.
    pub(super) fn response(&self, relay: &Response) -> Response {
        let share = self.rock_work / self.energy;
        Response { share, energy: self.energy, period: self.period, ..*relay }
    }
}

impl AirHammer {
    /// Its scene at a supply pressure over the atmosphere's, Pa.
    pub fn at(&self, pressure: f64) -> Scene {
        let (parameters, inputs) = self.start();
        Scene {
            parameters,
            inputs: InputValues { supply_pressure: pressure + ATMOSPHERE, ..inputs },
        }
    }

    /// The same with the supply ports with which a number of its blows is met: air (m3/s) or another
    /// that grows with the ports. `scene` is that of a hammer.
    ///
    /// # Errors
    /// Those of [`AirBlow::settled`]; a number that no ports give.
    pub fn fitted(
        mut self,
        scene: impl Fn(&Self) -> Scene,
        wanted: f64,
        number: impl Fn(&AirBlow) -> f64,
    ) -> Result<(Self, AirBlow), DatasheetError> {
        // By secants in logarithms; at first as if the number grew with the ports.
        let (mut before, mut slope): (Option<[f64; 2]>, f64) = (None, 1.0);
        for _ in 0..ROUNDS {
            let blow = AirBlow::settled(&scene(&self))?;
            let [port, found] = [math::ln(self.supply), math::ln(number(&blow))];
            let off = math::ln(wanted) - found;
            if off.abs() < CLOSE {
                return Ok((self, blow));
            }
            if let Some([old, had]) = before {
                slope = ((found - had) / (port - old)).clamp(0.2, 3.0);
            }
            before = Some([port, found]);
            self.supply *= math::exp((off / slope).clamp(-0.7, 0.7));
        }
        Err(DatasheetError::Contradiction(format!(
            "no supply ports of a hammer of {:.0} mm give that",
            1e3 * self.outer
        )))
    }
}
