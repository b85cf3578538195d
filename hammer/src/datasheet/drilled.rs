//! The long-run means of the answer's scene, at its feed. The numbers of the answer are read from these.

use super::DatasheetError;
use crate::error::Error;
use crate::laws::event::Event;
use crate::laws::mode::{Tie, TieState};
use crate::machine::{Machine, Observer};
use crate::means::{Averages, Kind, Steady, Wanted, steady};
use crate::quantities::parameters::Source;
use crate::scene::Scene;

/// Number of blows of a first simulation, and of a second one if the errors are still too large. The first is enough if
/// the casing is held down. A hammer whose drive is vented now and then needs some hundreds of blows.
const BLOWS: [usize; 2] = [160, 600];
/// Largest relative standard errors: of the rates, and of energy, period and air.
const OF_RATE: f64 = 0.03;
const OF_BLOW: f64 = 0.05;
/// If a hammer makes no blow for this time, it has stalled, s.
const LONGEST: f64 = 3.0;
/// The casing is held down if the shoulder of its chuck is open for less than this share of the time. The time is that
/// from the blow [`BEGUN`] to the blow [`ENDED`].
const HELD: f64 = 0.9;
const BEGUN: u64 = 8;
const ENDED: u64 = 24;

/// Means of a scene's blows in the long run, with their relative standard errors. The bodies are elastic if the scene's
/// are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drilled {
    /// Energy of the piston, J; blows per time, Hz; free air through the chambers, m3/s.
    pub energy: f64,
    pub frequency: f64,
    pub flow: f64,
    /// Work given to the rock over the piston's energy.
    pub share: f64,
    /// Rate of penetration of the hole, and the rate at which the bit's tip goes in, m/s.
    pub rate: f64,
    pub tip_rate: f64,
    /// Largest force on the rock in a blow, N.
    pub peak: f64,
    /// Relative errors of the rate, the energy, the period and the air.
    pub errors: [f64; 4],
    pub blows: usize,
    /// Share of the time in which the shoulder of the chuck is open.
    pub open: f64,
    /// A warning if the hammer settles into another motion from another start.
    pub elsewhere: Option<String>,
}

impl Drilled {
    /// Simulates a scene until its means are known. If a feed was given (`fed`), it also checks whether the casing is
    /// held down and whether another start leads to another motion. The assumed feed always holds the casing down.
    ///
    /// # Errors
    /// Those of the engine; the hammer stalls.
    pub fn of(scene: &Scene, fed: bool) -> Result<Self, DatasheetError> {
        let mut found = Self::means(scene, BLOWS[0], fed)?;
        if !found.reached {
            found = Self::means(scene, BLOWS[1], fed)?;
        }
        if found.kind == Kind::Stalled {
            let feed = 1e-3 * scene.inputs.feed_force;
            return Err(DatasheetError::Contradiction(format!(
                "with a feed of {feed:.1} kN the hammer strikes no blow for {LONGEST} s: it stalls"
            )));
        }
        let mean = |name| found.mean.get(name);
        let error = |name| found.error.get(name) / mean(name).abs();
        let flow = if mean("air_flow") > 0.0 { error("air_flow") } else { 0.0 };
        Ok(Self {
            energy: mean("blow_energy"),
            frequency: mean("blow_frequency"),
            flow: mean("air_flow"),
            share: (mean("energy_rock_dissipated") + mean("energy_viscous")) / mean("blow_energy"),
            rate: mean("rop"),
            tip_rate: mean("tip_rate"),
            peak: mean("rock_force_peak"),
            errors: [error("rop"), error("blow_energy"), error("period"), flow],
            blows: found.blows,
            open: if fed { Shoulder::open(scene)? } else { 0.0 },
            elsewhere: found.depends_on_its_start(),
        })
    }

    fn means(scene: &Scene, blows: usize, second: bool) -> Result<Steady, Error> {
        let air = scene.parameters.drive.source == Source::Air;
        let wanted = Averages::names().map(|name| match name {
            "rop" | "tip_rate" => OF_RATE,
            "blow_energy" | "period" => OF_BLOW,
            "air_flow" if air => OF_BLOW,
            _ => f64::INFINITY,
        });
        let mut error = Averages::default();
        error.0.iter_mut().zip(wanted).for_each(|(error, wanted)| *error = wanted);
        let wanted = Wanted { error, blows, limit: LONGEST, second, ..Wanted::default() };
        steady(scene, &wanted, &mut |_, _| true)
    }

    /// True if the feed holds the casing down.
    pub fn held(&self) -> bool {
        self.open < HELD
    }
}

/// How long the shoulder of the chuck is open.
#[derive(Default)]
struct Shoulder {
    last: f64,
    was_open: bool,
    open: f64,
}

impl Shoulder {
    /// Measures over some settled blows; 0 without a casing.
    fn open(scene: &Scene) -> Result<f64, Error> {
        if !scene.parameters.has_casing() {
            return Ok(0.0);
        }
        let (mut machine, mut way) = (scene.machine()?, Self::default());
        let mut begun = None;
        while machine.counters().blows < ENDED && machine.time() < LONGEST {
            machine.advance_observed(machine.time() + 1e-3, &mut way)?;
            if begun.is_none() && machine.counters().blows >= BEGUN {
                way.note(&machine, machine.time());
                (begun, way.open) = (Some(machine.time()), 0.0);
            }
        }
        way.note(&machine, machine.time());
        Ok(begun.map_or(1.0, |begun| way.open / (machine.time() - begun)))
    }

    fn note(&mut self, machine: &Machine, now: f64) {
        self.open += if self.was_open { now - self.last } else { 0.0 };
        self.was_open = machine.mode().ties.of(Tie::Chuck) != TieState::Pressed;
        self.last = now;
    }
}

impl Observer for Shoulder {
    fn after(&mut self, machine: &Machine, _: Event) -> bool {
        self.note(machine, machine.motion().milestone().time.value());
        false
    }
}
