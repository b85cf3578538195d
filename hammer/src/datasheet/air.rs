//! Settled blows of a hammer that air drives.

use super::DatasheetError;
use crate::presets::AirHammer;
use crate::quantities::air::ATMOSPHERE;
use crate::quantities::parameters::InputValues;
use crate::scene::Scene;

/// Blows until they repeat, and of the mean after them.
const SETTLED: u64 = 12;
const MEANT: u64 = 6;
/// The same where a hundredth is enough.
const SOON: [u64; 2] = [7, 2];
/// Longest that is looked for them, s.
const PATIENCE: f64 = 3.0;
/// Feed over outside diameter squared and pressure: what the presets of 4 and 5 inches have.
pub(super) const FEED: f64 = 0.58;

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
        Ok(Self::of(scene, false)?.0)
    }

    /// The same, with how high the piston turns above the bit (m); sooner where a hundredth is enough.
    pub(super) fn of(scene: &Scene, soon: bool) -> Result<(Self, f64), DatasheetError> {
        let mut machine = scene.machine()?;
        let [settled, meant] = if soon { SOON } else { [SETTLED, MEANT] };
        let (mut sum, mut counted, mut height) = ([0.0; 6], 0, 0.0f64);
        while machine.counters().blows < settled + meant {
            machine.advance(machine.time() + 1e-3)?;
            let blows = machine.counters().blows;
            if blows >= settled {
                height = height.max(-machine.kinematics().relative_position);
            }
            if let Some(blow) = machine.blow().filter(|_| blows > counted.max(settled)) {
                let b = blow;
                let all = [b.energy, b.period, b.speed, b.air_flow, b.rock_work, b.rop];
                sum.iter_mut().zip(all).for_each(|(sum, new)| *sum += new / meant as f64);
            }
            counted = blows;
            if machine.time() > PATIENCE {
                return Err(DatasheetError::Contradiction(format!(
                    "an air hammer of these numbers strikes {counted} times in {PATIENCE} s: it stalls"
                )));
            }
        }
        let [energy, period, speed, flow, rock_work, rate] = sum;
        Ok((Self { energy, period, speed, flow, rock_work, rate }, height))
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
}
