//! The chambers in the series of a window.

use super::stream::Gains;
use crate::laws::air::KAPPA;
use std::array::from_fn;

/// First coefficients of both chambers, and what they scale. All later coefficients of pressure, volume, mass and `R T`
/// are divided by the first one, which is then 1 and needs no multiplication.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chambers {
    pub(super) pressure: [f64; 2],
    pub(super) volume: [f64; 2],
    /// The sum of the flows out of the chamber.
    pub(super) outflow: [f64; 2],
    pub(super) over_mass: [f64; 2],
    /// `R T`, and the pressure times the volume.
    pub(super) heat: [f64; 2],
    pub(super) energy: [f64; 2],
    /// Relative volume per metre of the piston's position, 1/m.
    pub(super) grows: [f64; 2],
    /// Relative rates of the pressure per flow into the chamber and out of it, at the temperatures outside and inside,
    /// 1/kg.
    pub(super) filled: [f64; 2],
    pub(super) emptied: [f64; 2],
    /// The forces on drive area and return area, N, and these areas, m2.
    pub(super) thrust: [f64; 2],
    pub(super) areas: [f64; 2],
}

/// What one coefficient of the series leaves to the next.
#[derive(Clone, Copy)]
pub(super) struct Last {
    pub(super) forces: [f64; 2],
    /// What the masses of both chambers gain, kg/s.
    pub(super) flows: [f64; 2],
    /// Relative rates of the pressures by what flows, 1/s.
    pub(super) warmed: [f64; 2],
    /// The flow from the supply, kg/s.
    pub(super) fed: f64,
}

/// The last coefficients of both chambers.
#[derive(Clone, Copy)]
pub(super) struct Moved {
    /// The piston's position `x`.
    pub(super) place: f64,
    pub(super) volumes: [f64; 2],
    pub(super) pressures: [f64; 2],
    pub(super) masses: [f64; 2],
}

impl Chambers {
    /// Chambers with these areas, masses, volumes and pressures, where `R T` is `warm` outside.
    pub(super) fn new(
        areas: [f64; 2],
        warm: f64,
        (mass, volume, pressure): ([f64; 2], [f64; 2], [f64; 2]),
    ) -> Self {
        let [over_volume, over_mass] = [volume, mass].map(|of| of.map(|of| 1.0 / of));
        let energy: [f64; 2] = from_fn(|i| pressure[i] * volume[i]);
        Self {
            pressure,
            volume,
            outflow: [0.0; 2],
            over_mass,
            heat: from_fn(|i| energy[i] * over_mass[i]),
            energy,
            grows: [areas[0] * over_volume[0], -areas[1] * over_volume[1]],
            filled: energy.map(|energy| KAPPA * warm / energy),
            emptied: over_mass.map(|over| KAPPA * over),
            thrust: from_fn(|i| pressure[i] * areas[i]),
            areas,
        }
    }

    /// What a coefficient of the flows and forces leaves to the next one.
    #[inline(always)]
    pub(super) fn gained(&self, gains: &Gains, forces: [f64; 2]) -> Last {
        let [a, b, c, d] = gains.flows;
        let (taken, lost, carried) = ([a, b], [c, d], gains.carried);
        Last {
            forces,
            flows: from_fn(|i| taken[i] - lost[i]),
            warmed: from_fn(|i| {
                self.filled[i] * taken[i] - self.emptied[i] * (lost[i] + carried[i])
            }),
            fed: gains.fed,
        }
    }
}
