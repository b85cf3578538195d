//! The air side of a hammer with [`Source::Air`](crate::Source::Air): chambers, ports and the air that is supplied.
//! The equations are in `laws/air.rs`.

use serde::{Deserialize, Serialize};

/// Pressure of the atmosphere, Pa.
pub const ATMOSPHERE: f64 = 101_325.0;

/// A chamber beside the piston.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirChamber {
    /// Volume with the piston at the end of its travel into the chamber, m3.
    pub dead_volume: f64,
    /// Relative position of the piston at which the supply begins to open, m.
    pub supply: f64,
    /// Relative position of the piston at which the exhaust begins to open, m.
    pub exhaust: f64,
}

/// The air side of a hammer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLaw {
    /// Above the piston: supplied while it is high, exhausted while it is low.
    pub drive: AirChamber,
    /// Below the piston: supplied while it is low, exhausted while it is high.
    pub returning: AirChamber,
    /// Travel `s` of the piston from impact to the end of its cylinder, m.
    pub cylinder: f64,
    /// Travel from a port's edge to where it is wholly open, m.
    pub port_height: f64,
    /// Area of a supply port, wholly open, m2.
    pub supply_area: f64,
    /// Area of an exhaust port, wholly open, m2.
    pub exhaust_area: f64,
    /// Discharge coefficient: part of a port's area that its jet fills.
    pub discharge: f64,
    /// Opening between the chambers, past the piston, m2.
    pub leakage_area: f64,
    /// Drag of the piston in its cylinder, N s/m.
    pub drag: f64,
    /// Temperature of the supply, and of air that flows in from the exhaust, K.
    pub temperature: f64,
    /// Relative error of the air in the mean over a window.
    pub error: f64,
}

impl Default for AirLaw {
    /// An example that suits the reference hammer: faces of 1.5e-3 m2, a cylinder of 70 mm.
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
