//! The parameters of an air hammer ([`Source::Air`](crate::Source::Air)): chambers, ports and supplied air. The
//! equations are in `laws/air.rs`.

use serde::{Deserialize, Serialize};

/// Pressure of the atmosphere, Pa.
pub const ATMOSPHERE: f64 = 101_325.0;

/// A chamber beside the piston.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirChamber {
    /// Volume with the piston at the end of its travel into the chamber, m3.
    pub dead_volume: f64,
    /// Position of the piston relative to what it strikes at which the supply port begins to open, m; negative above.
    pub supply: f64,
    /// Position of the piston relative to what it strikes at which the exhaust port begins to open, m.
    pub exhaust: f64,
}

/// Chambers, ports and air of an air hammer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLaw {
    /// The chamber above the piston: open to the supply while the piston is high, to the exhaust while it is low.
    pub drive: AirChamber,
    /// The chamber below the piston: open to the supply while the piston is low, to the exhaust while it is high.
    pub returning: AirChamber,
    /// Travel `s` of the piston from impact to the end of its cylinder, m.
    pub cylinder: f64,
    /// Travel of the piston from where a port begins to open to where it is fully open, m.
    pub port_height: f64,
    /// Area of a fully open supply port, m2.
    pub supply_area: f64,
    /// Area of a fully open exhaust port, m2.
    pub exhaust_area: f64,
    /// Discharge coefficient: the share of a port's area that its jet fills.
    pub discharge: f64,
    /// Area through which air leaks past the piston from one chamber to the other, m2.
    pub leakage_area: f64,
    /// Drag of the piston in its cylinder, N s/m.
    pub drag: f64,
    /// Temperature of the supplied air, and of air that flows back in from the exhaust, K.
    pub temperature: f64,
    /// Allowed relative error of the gas in each window of its integration.
    pub error: f64,
}

impl Default for AirLaw {
    /// An example that fits the reference hammer: piston faces of 1.5e-3 m2 and a cylinder of 70 mm.
    fn default() -> Self {
        Self {
            drive: AirChamber { dead_volume: 6e-5, supply: -0.030, exhaust: -0.020 },
            returning: AirChamber { dead_volume: 5e-5, supply: -0.015, exhaust: -0.035 },
            cylinder: 0.07,
            port_height: 4e-3,
            supply_area: 6.25e-5,
            exhaust_area: 1.5e-4,
            discharge: 0.8,
            leakage_area: 0.0,
            drag: 0.0,
            temperature: 300.0,
            error: 1e-6,
        }
    }
}
