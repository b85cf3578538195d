//! The same scene with every number changed by a few units in the last place. The change of the result is what double
//! precision cannot know.

use crate::law::State;
use crate::linear::Real;
use crate::record;
use crate::scene::{Action, Drive, RockLaw, Scene, Schedule};

/// Largest relative change, `2^-50`: four units in the last place.
pub const RELATIVE: f64 = 1.0 / 1_125_899_906_842_624.0;

/// Relative change of an instant of retuning. Retuning at an event may come before or after it; both are right.
pub const INSTANT: f64 = 1.0 / 17_592_186_044_416.0;

/// An instant is at an event if it is within this many times the relative change, the event's own uncertainty, or the
/// distance of simultaneous events. It is then moved beyond the event, by twice as much: to where the event may be in
/// a scene that is changed by rounding.
const AT: f64 = 32.0;

/// An event at which a script may retune.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Its time, s.
    pub at: f64,
    /// Its uncertainty, the difference between perturbed runs, s.
    pub known: f64,
}

/// A stream of random changes (Marsaglia's xorshift).
struct Changes(u64);

impl Changes {
    fn of(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// A number from -1 to 1.
    fn part(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        // The upper 53 bits.
        2.0 * ((self.0 >> 11) as f64 / (1u64 << 53) as f64) - 1.0
    }

    fn factor(&mut self) -> f64 {
        1.0 + RELATIVE * self.part()
    }

    fn off(&mut self, x: &mut f64) {
        *x *= self.factor();
    }

    fn law(&mut self, law: &mut RockLaw) {
        let speeds = [&mut law.standstill_speed, &mut law.standstill_penetration];
        let line = [&mut law.stiffness, &mut law.viscosity, &mut law.barrier];
        speeds.into_iter().chain(line).for_each(|x| self.off(x));
        // A ratio above 1 stays above it.
        let mut above = law.ratio - 1.0;
        self.off(&mut law.ratio);
        self.off(&mut above);
        law.ratio = law.ratio.max(1.0 + above.abs());
    }
}

/// Random numbers from -1 to 1.
pub fn parts(seed: u64) -> impl Iterator<Item = f64> {
    let mut changes = Changes::of(seed);
    std::iter::from_fn(move || Some(changes.part()))
}

/// Changes all numbers of the moving nodes of a state.
pub fn round<T: Real>(state: &mut State<T>, seed: u64) {
    let mut changes = Changes::of(seed);
    let nodes = state.u.iter_mut().zip(&mut state.v);
    for (u, v) in nodes.filter(|(_, v)| **v != T::default()) {
        *u = *u * T::from(changes.factor());
        *v = *v * T::from(changes.factor());
    }
}

/// A scene and its script with every number changed. Instants of inputs stay. Retuning comes earlier for an odd
/// `seed` and later for an even one, or on the other side of one of the `events` if it is at that.
pub fn perturbed(
    scene: &Scene,
    schedule: &Schedule,
    seed: u64,
    events: &[Near],
) -> (Scene, Schedule) {
    let mut changes = Changes::of(seed);
    let (mut scene, mut schedule) = (scene.clone(), schedule.clone());
    let material = [&mut scene.youngs_modulus, &mut scene.density, &mut scene.damping_time];
    let meeting = [&mut scene.contact_stiffness, &mut scene.gap, &mut scene.gravity];
    material.into_iter().chain(meeting).for_each(|x| changes.off(x));
    scene.inputs.iter_mut().for_each(|x| changes.off(x));
    for body in &mut scene.bodies {
        changes.off(&mut body.velocity);
        for section in &mut body.sections {
            changes.off(&mut section.length);
            changes.off(&mut section.area);
        }
    }
    changes.law(&mut scene.rock);
    if scene.bodies.len() > 2 {
        changes.off(&mut scene.coupling.stiffness);
        changes.off(&mut scene.coupling.slack);
    }
    if let Some(casing) = &mut scene.casing {
        let body = [&mut casing.mass, &mut casing.impedance];
        let tie = [&mut casing.stiffness, &mut casing.viscosity];
        let places = [&mut casing.travel, &mut casing.idle_travel];
        body.into_iter().chain(tie).chain(places).for_each(|x| changes.off(x));
        for section in &mut casing.sections {
            changes.off(&mut section.length);
            changes.off(&mut section.area);
        }
    }
    changes.off(&mut scene.anvil_area);
    changes.off(&mut scene.impedance);
    match &mut scene.drive {
        Drive::Relay { amplitude, stroke } => [amplitude, stroke].map(|x| changes.off(x)),
        Drive::Pressure { areas } => areas.each_mut().map(|x| changes.off(x)),
        Drive::Air(law) => {
            let error = law.error.max(RELATIVE);
            law.off = [(); 2].map(|()| error * changes.part());
            let volumes = law.dead_volumes.iter_mut().chain([&mut law.cylinder, &mut law.height]);
            let openings = law.ports.iter_mut().chain([&mut law.discharge, &mut law.leakage]);
            let outside = law.outside.iter_mut().chain([&mut law.temperature, &mut law.drag]);
            let edges = law.edges.as_flattened_mut().iter_mut().chain(&mut law.areas);
            let all = volumes.chain(openings).chain(outside).chain(edges);
            all.for_each(|x| *x *= 1.0 + error * changes.part());
            [(); 2]
        }
        Drive::Force => [(); 2],
    };
    let side = if seed % 2 == 1 { -1.0 } else { 1.0 };
    for (time, action) in &mut schedule {
        match action {
            Action::Set(_, derivatives) => derivatives.iter_mut().for_each(|x| changes.off(x)),
            Action::Retune(law, amplitude) => {
                let least = INSTANT * *time;
                let beyond = events.iter().filter_map(|event| {
                    let (apart, off) = ((event.at - *time).abs(), AT * least.max(event.known));
                    (apart <= off.max(record::INSTANT)).then_some(2.0 * (apart + off))
                });
                let beyond = beyond.fold(least, f64::max);
                *time += side * beyond;
                changes.law(law);
                amplitude.iter_mut().for_each(|x| changes.off(x));
            }
        }
    }
    (scene, schedule)
}
