//! What bit and rock make of a throw: the mean response of simulated blows.

use super::DatasheetError;
use super::relay::Relay;
use crate::periodic::{Averages, Kind, Wanted, steady};
use crate::scene::Scene;

/// Blows that a mean is of, at most.
const BLOWS: usize = 500;
/// And fewest.
const FEWEST: usize = 60;
/// Periods without a blow after which a hammer has stopped.
const PATIENCE: f64 = 20.0;

/// What the closed form of the relay does not know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// Share of the blow's energy with which the piston is thrown back; below 0 where the bit takes more.
    pub returned: f64,
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
    pub const GUESS: Self =
        Self { returned: 0.16, delay: 1.0, share: 0.8, energy: 0.0, period: 0.0 };

    /// That of a scene with this relay, and whether its blows are as the present one says, up to `close`;
    /// if not, half way there.
    pub fn next(
        &self,
        scene: &Scene,
        relay: &Relay,
        close: f64,
    ) -> Result<(Self, bool), DatasheetError> {
        let guess = relay.throw(self.returned).ok_or_else(|| {
            let Relay { force, mass, .. } = relay;
            DatasheetError::Contradiction(format!("{force:.1} N cannot lift a piston of {mass} kg"))
        })?;
        let period = guess.period * self.delay;
        // Means, of one simulation: a cycle need not be solved for.
        let wanted = Wanted {
            error: Averages::of_rates(close),
            blows: BLOWS,
            fewest: FEWEST,
            limit: PATIENCE * period,
            returns: 0,
            members: 1,
            ..Wanted::default()
        };
        let means = steady(scene, &wanted, &mut |_, _| true)?;
        if means.kind == Kind::Stalled {
            return Err(DatasheetError::Contradiction(
                "the hammer stalls: it is too weak for the blows that are asked of it".into(),
            ));
        }
        let mean = |name| means.mean.get(name);
        let [energy, period] = [mean("blow_energy"), mean("period")];
        let share = (mean("energy_rock_dissipated") + mean("energy_viscous")) / energy;
        let returned = relay.returned(energy);
        let delay = relay.throw(returned).map_or(1.0, |throw| period / throw.period);
        let off = [energy / guess.energy, period / (guess.period * self.delay)];
        let close = off.iter().all(|ratio| (ratio - 1.0).abs() < close);
        let returned = if close { returned } else { 0.5 * (self.returned + returned) };
        Ok((Self { returned, delay, share, energy, period }, close))
    }
}
