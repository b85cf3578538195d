//! Scenes drawn over the domain, and common hammers.

#![allow(dead_code, reason = "each test uses some of it")]

use hammer::presets::Preset;
use hammer::{Body, Fidelity, InputValues, Machine, Parameters, Record, Segment};

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

    /// A hammer whose bodies have two to four sections each, on at most eight spans.
    pub fn stepped(&mut self) -> Parameters {
        let mut p = self.scene();
        p.mesh.degree = 1 + (self.unit() * 3.0) as usize;
        let mut body = |segment: &mut [Segment]| {
            let count = 2 + (self.unit() * 3.0) as usize;
            for s in &mut segment[..count] {
                (s.length, s.area) = (self.between(0.04, 0.2), self.between(8e-4, 5e-3));
            }
            (count, count + (self.unit() * 5.0) as usize)
        };
        (p.piston.segments, p.piston.elements) = body(&mut p.piston.segment);
        (p.bit.segments, p.bit.elements) = body(&mut p.bit.segment);
        p
    }

    /// A hammer: unequal bodies, rock from soft to hard, rigid or of up to ten elements.
    pub fn scene(&mut self) -> Parameters {
        let fidelity = if self.unit() < 0.3 { Fidelity::Rigid } else { Fidelity::Elastic };
        let mut p = Parameters { fidelity, ..Parameters::default() };
        (p.piston.length, p.bit.length) = (self.spread(0.08, 0.6), self.spread(0.08, 0.6));
        p.piston.elements = 1 + (self.unit() * 10.0) as usize;
        p.bit.elements = 1 + (self.unit() * 10.0) as usize;
        p.mesh.degree = 1 + (self.unit() * self.unit() * 5.0) as usize;
        if self.unit() < 0.25 {
            p.piston.segments = 2;
            p.piston.segment[0].length = self.between(0.05, 0.2);
            p.piston.segment[0].area = self.between(1e-3, 4e-3);
            p.piston.segment[1].length = self.between(0.05, 0.2);
        }
        p.piston.initial_velocity = self.between(0.0, 9.0);
        p.material.damping_time = self.spread(1e-9, 1e-6);
        p.contact.stiffness = self.spread(1e10, 1e11);
        p.contact.initial_gap = self.spread(0.001, 0.05);
        p.drive.stroke = self.spread(0.02, 0.08);
        p.drive.amplitude = self.spread(800.0, 4000.0);
        p.rock.stiffness = self.spread(1e7, 1e9);
        p.rock.unloading_ratio = self.spread(1.3, 12.0);
        p.rock.viscosity = self.spread(1e3, 4e5);
        p.rock.energy_barrier = self.spread(0.1, 40.0);
        p.rock.standstill_speed = self.spread(1e-4, 1e-2);
        p.gravity = self.between(-9.81, 9.81);
        p
    }
}

/// The reference hammer in rock so viscous that the bit never stands still, on 20 linear elements.
pub fn overdamped() -> Parameters {
    Preset::named("overdamped").expect("a preset").start().0
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

/// A scene's events from rest to `end`, s. Internal forces cancel in pairs, so the momentum of all bodies (of a bare
/// hammer, whose drive pushes against an outside holder, that of what is struck) is the impulse of feed, gravity,
/// rock and string; and every energy is in the ledger. Each event makes two roundings of these sums, and a basis
/// loses up to 1e5 of them at a transition.
pub fn balanced(p: &Parameters, inputs: &InputValues, end: f64) -> Vec<Record> {
    let mut p = *p;
    p.piston.initial_velocity = 0.0;
    let mut m = Machine::new(&p, inputs, 0.0).expect("a scene");
    m.keep_journal(true);
    let start = m.kinematics().casing_position;
    m.advance(end).unwrap_or_else(|error| panic!("{error}: {p:?}"));
    let (k, sums) = (*m.kinematics(), m.impulses());
    let string = p.casing.impedance * (k.casing_position - start);
    let mut momentum = p.bit_mass() * k.bit_velocity;
    let mut fed = (inputs.feed_force + p.bit_mass() * p.gravity) * end;
    let mut given = fed + sums.contact - sums.rock;
    if p.has_casing() {
        momentum += p.casing_mass() * k.casing_velocity + p.piston_mass() * k.piston_velocity;
        fed += (p.casing_mass() + p.piston_mass()) * p.gravity * end;
        given = fed - sums.rock - string;
    }
    let scale = fed + sums.contact + sums.rock.abs() + string.abs();
    let rounding = 1e5 * f64::EPSILON * (10.0 + m.counters().events as f64) * scale;
    // The string takes the impulse of its end's motion, which for an elastic casing is not an output.
    let is_told = p.casing.impedance == 0.0 || !p.is_elastic(Body::Casing);
    let apart = (momentum - given).abs();
    assert!(!is_told || apart < rounding, "{momentum} {given} of {rounding}: {p:?}");
    let energies = m.energies();
    assert!(energies.residual.abs() < 1e-10 * energies.turnover(), "{energies:?}: {p:?}");
    m.take_journal()
}

/// Reference of the air's error, J: enthalpy taken, sum of the hammer's energies, and energy of the chambers.
pub fn air_turnover(machine: &Machine) -> f64 {
    const KAPPA: f64 = 1.4;
    let (p, now) = (machine.parameters(), machine.kinematics());
    let taken = KAPPA / (KAPPA - 1.0) * 287.05 * p.air.temperature * machine.air_mass()[0];
    let drive =
        p.air.drive.dead_volume + p.drive.area_drive * (p.air.cylinder + now.relative_position);
    let back = p.air.returning.dead_volume - p.drive.area_return * now.over_struck;
    let [[one, _], [other, _]] = machine.chamber_pressures();
    let held = (one * drive + other * back) / (KAPPA - 1.0);
    taken.abs() + machine.energies().turnover() + held
}

/// The suite tries one of so many; `ALTERED_EVERY=1` tries all.
pub fn one_in(many: usize) -> usize {
    std::env::var("ALTERED_EVERY").ok().and_then(|n| n.parse().ok()).unwrap_or(many)
}
