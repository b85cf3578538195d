//! The first settled blows of an air hammer.

use super::DatasheetError;
use crate::presets::AirHammer;
use crate::quantities::air::ATMOSPHERE;
use crate::scene::Scene;

/// Number of blows that are skipped, and number of the following blows that are averaged. By then, a motion that
/// repeats has settled to about 1 %.
const SKIPPED: u64 = 7;
const AVERAGED: u64 = 2;
/// If a hammer has not made these blows by this time, it has stalled, s.
const LONGEST: f64 = 3.0;
/// Feed force divided by pressure and by the outside diameter squared, as in the presets of 4 and 5 inches.
pub(super) const FEED: f64 = 0.58;

/// Means of the first settled blows, accurate to about 1 % if the blows repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AirBlow {
    /// Energy of the piston at impact, J.
    pub energy: f64,
    /// Period of the blows, s.
    pub period: f64,
    /// Flow of free air, m3/s.
    pub flow: f64,
    /// Work done on the rock, J.
    pub rock_work: f64,
    /// Largest height of the piston above the bit, m.
    pub height: f64,
}

impl AirBlow {
    /// Simulates the first blows of a scene.
    ///
    /// # Errors
    /// Those of the engine; [`DatasheetError::Contradiction`] if the hammer makes too few blows.
    pub fn of(scene: &Scene) -> Result<Self, DatasheetError> {
        Self::after(scene, SKIPPED)
    }

    /// Simulates the blows of a scene, and skips the first ones.
    pub(super) fn after(scene: &Scene, skipped: u64) -> Result<Self, DatasheetError> {
        let longest = LONGEST.max(0.3 * skipped as f64);
        let mut machine = scene.machine()?;
        let (mut sum, mut counted, mut height) = ([0.0; 4], 0, 0.0f64);
        while machine.counters().blows < skipped + AVERAGED {
            machine.advance(machine.time() + 1e-3)?;
            let blows = machine.counters().blows;
            if blows >= skipped {
                height = height.max(-machine.kinematics().relative.displacement);
            }
            if let Some(b) = machine.blow().filter(|_| blows > counted.max(skipped)) {
                let values = [b.energy, b.period, b.air_flow, b.rock_work];
                sum.iter_mut().zip(values).for_each(|(sum, new)| *sum += new / AVERAGED as f64);
            }
            counted = blows;
            if machine.time() > longest {
                return Err(DatasheetError::Contradiction(format!(
                    "an air hammer of these numbers strikes {counted} times in {longest} s: it stalls"
                )));
            }
        }
        let [energy, period, flow, rock_work] = sum;
        Ok(Self { energy, period, flow, rock_work, height })
    }
}

impl AirHammer {
    /// The scene of this hammer at a supply pressure (above that of the atmosphere, Pa).
    pub fn at(&self, pressure: f64) -> Scene {
        let mut scene = self.start();
        scene.inputs.supply_pressure = pressure + ATMOSPHERE;
        scene
    }
}
