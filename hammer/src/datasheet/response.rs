//! What bit and rock make of a throw: the mean response of simulated blows.

use super::DatasheetError;
use super::relay::Relay;
use crate::machine::Machine;
use crate::machine::blows::Blow;
use crate::sensitivity::Scene;

/// Blows that are simulated before, and those that means are of.
const SETTLED: usize = 30;
const COUNTED: usize = 60;
/// Steps without a blow after which a hammer has stopped.
const PATIENCE: usize = 20;

/// What the closed form of the relay does not know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// Speed at which the piston is thrown back, over its impact speed.
    pub rebound: f64,
    /// Period over that of the closed form: a blow takes its time.
    pub delay: f64,
    /// Work given to the rock over the energy of the blow.
    pub share: f64,
    /// Mean energy of a blow, J.
    pub energy: f64,
    /// Mean period, s.
    pub period: f64,
}

impl Response {
    /// Before any blow was simulated.
    pub const GUESS: Self = Self { rebound: 0.4, delay: 1.0, share: 0.8, energy: 0.0, period: 0.0 };

    /// That of a scene with this relay, and whether its blows are as the present one says, up to `close`;
    /// if not, half way there.
    pub fn next(
        &self,
        scene: &Scene,
        relay: &Relay,
        close: f64,
    ) -> Result<(Self, bool), DatasheetError> {
        let guess = relay.throw(self.rebound).ok_or_else(|| {
            let Relay { force, mass, .. } = relay;
            DatasheetError::Contradiction(format!("{force:.1} N do not lift a piston of {mass} kg"))
        })?;
        let blows = blows(scene, guess.period * self.delay)?;
        let sum = |of: fn(&Blow) -> f64| blows.iter().map(of).sum::<f64>();
        let (energy, count) = (sum(|blow| blow.energy), blows.len() as f64);
        let share = sum(|blow| blow.rock_work) / energy;
        let [energy, period] = [energy / count, sum(|blow| blow.period) / count];
        let rebound = relay.rebound(energy);
        let delay = relay.throw(rebound).map_or(1.0, |throw| period / throw.period);
        let off = [energy / guess.energy, period / (guess.period * self.delay)];
        let close = off.iter().all(|ratio| (ratio - 1.0).abs() < close);
        let rebound = if close { rebound } else { 0.5 * (self.rebound + rebound) };
        Ok((Self { rebound, delay, share, energy, period }, close))
    }
}

/// Blows after the first ones, in steps of about a period.
fn blows(scene: &Scene, period: f64) -> Result<Vec<Blow>, DatasheetError> {
    let mut machine: Machine = scene.machine()?;
    machine.keep_rock_work(true);
    let (mut list, mut still) = (Vec::new(), 0);
    while list.len() < SETTLED + COUNTED {
        machine.advance(machine.time() + period)?;
        still = if machine.step_blows().is_empty() { still + 1 } else { 0 };
        if still > PATIENCE || machine.stalled() {
            let count = list.len();
            return Err(DatasheetError::Contradiction(format!(
                "the hammer stops after {count} blows: it is weaker than what is asked of it"
            )));
        }
        list.extend(machine.step_blows());
    }
    Ok(list.split_off(SETTLED))
}
