//! Random numbers, and common hammers.

use hammer::presets::Preset;
use hammer::{InputValues, Machine, Parameters};

/// A linear congruential generator, which is the same on every machine.
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number in (0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Bits of the last number.
    pub fn bits(&self) -> u64 {
        self.0
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Log-uniform between two numbers.
    pub fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

/// The reference hammer in rock so viscous that the bit never stands still, on 20 linear elements.
pub fn overdamped() -> Parameters {
    Preset::named("overdamped").expect("a preset").start().parameters
}

/// The reference hammer in a casing of 40 kg.
pub fn cased() -> Parameters {
    let mut p = Parameters::default();
    p.casing.mass = 40.0;
    p
}

/// A hammer at its start under this feed, N.
pub fn machine(p: &Parameters, feed: f64) -> Machine {
    let inputs = InputValues { feed_force: feed, ..InputValues::default() };
    Machine::new(p, &inputs, 0.0).expect("a scene")
}

/// Reference of the air's error, J: enthalpy taken, sum of the hammer's energies, and energy of the chambers.
pub fn air_turnover(machine: &Machine) -> f64 {
    const KAPPA: f64 = 1.4;
    let (p, now) = (machine.parameters(), machine.kinematics());
    let taken = KAPPA / (KAPPA - 1.0) * 287.05 * p.air.temperature * machine.air_mass()[0];
    let drive =
        p.air.drive.dead_volume + p.drive.area_drive * (p.air.cylinder + now.relative.displacement);
    let back = p.air.returning.dead_volume - p.drive.area_return * now.over_struck.displacement;
    let [[one, _], [other, _]] = machine.chamber_pressures();
    let held = (one * drive + other * back) / (KAPPA - 1.0);
    taken.abs() + machine.energies().turnover() + held
}

/// The suite tries one of so many; `ALTERED_EVERY=1` tries all.
pub fn one_in(many: usize) -> usize {
    std::env::var("ALTERED_EVERY").ok().and_then(|n| n.parse().ok()).unwrap_or(many)
}
