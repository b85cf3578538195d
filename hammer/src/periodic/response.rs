//! What a cycle gives.

use crate::energy::ledger::Energies;
use crate::energy::peaks::Peaks;

/// A blow of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strike {
    /// Instant of impact after the section, s.
    pub time: f64,
    /// Relative mean speed at impact, m/s.
    pub speed: f64,
    /// Energy of impact, J.
    pub energy: f64,
    /// Mean speed at which the piston leaves the bit upward, when it last does, m/s.
    pub rebound: f64,
}

/// What a cycle gives; of derivatives, and of their errors, the same in the unit of each over that
/// of the argument.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// s.
    pub period: f64,
    /// Gain of the tip in a period, m.
    pub advance: f64,
    /// `advance / period`, m/s.
    pub tip_rate: f64,
    /// Rate of penetration of the hole, by specific energy, m/s.
    pub rop: f64,
    /// Works and losses of a period, J; what is stored comes back to what it was.
    pub energies: Energies,
    /// Largest contact and rock force, N.
    pub peaks: Peaks,
    /// Blows, their times from the section on.
    pub strikes: Vec<Strike>,
}

/// Numbers besides the blows'.
const SINGLE: usize = 19;

impl Response {
    /// In one list.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        let Peaks([rock, contact, other]) = self.peaks;
        let mut list = vec![self.period, self.advance, self.tip_rate, contact, rock];
        list.extend(self.energies.values());
        list.extend([other, self.rop]);
        list.extend(self.strikes.iter().flat_map(|s| [s.time, s.speed, s.energy, s.rebound]));
        list
    }

    /// How many numbers there are.
    pub(crate) fn len(&self) -> usize {
        SINGLE + 4 * self.strikes.len()
    }

    /// From such a list.
    pub(crate) fn of_numbers(list: &[f64]) -> Self {
        let x = |k: usize| list.get(k).copied().unwrap_or(f64::NAN);
        let strikes = list.get(SINGLE..).unwrap_or_default().chunks_exact(4);
        let strike = |s: &[f64]| Strike { time: s[0], speed: s[1], energy: s[2], rebound: s[3] };
        Self {
            period: x(0),
            advance: x(1),
            tip_rate: x(2),
            rop: x(18),
            peaks: Peaks([x(4), x(3), x(17)]),
            energies: std::array::from_fn(|k| x(5 + k)).into(),
            strikes: strikes.map(strike).collect(),
        }
    }
}
