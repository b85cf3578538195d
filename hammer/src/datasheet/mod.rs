//! Hammers from a datasheet: a sample of them, and the range of every number.
//!
//! A sheet leaves most of a hammer open, so the answer is a sample of 240 hammers. Each hammer has its own random
//! values of the unknowns (pressure, bore, mass, stroke, ports, effectiveness, and deviations from scaled presets); the
//! draws are the same for all sheets. All hammers are then fitted to the given numbers, within the errors of such
//! numbers (`member`). Their blows follow from a table of simulated blows (`table`). Every number of the answer is the
//! sample's median with its 80 % range (`sample`). Hammers that strike faster than steel withstands are excluded. The
//! answer changes little if the sheet changes little. If a given number cannot be met, the answer says by how much the
//! hammers miss it; no other model is tried.
//!
//! The scene of the answer is the median hammer, adjusted in simulations until its blows are the sample's.
//!
//! A number that is wrong by a unit or a factor of ten is refused, with the range of real hammers. An impossible
//! combination is reported (`limits`).

mod air;
mod answer;
mod assume;
mod drilled;
mod limits;
mod member;
mod nodes;
mod quantity;
mod ratio;
mod sample;
mod sizes;
mod table;

pub use answer::{SUCKED, THROUGH, TURN};
pub use quantity::{Entry, Quantity};
pub use ratio::{COMPARED, Relation, Side, ratios};
pub use sample::spread;

use crate::error::Error;
use crate::quantities::domain::ParameterError;
use crate::scene::Scene;
use sample::Sample;
use thiserror::Error as ThisError;

/// Power of the blows over pressure times flow of a liquid.
const EFFICIENCY: f64 = 0.6;

/// The given numbers.
#[derive(Clone, Debug, Default)]
pub struct Datasheet {
    /// The given numbers in SI units, each quantity at most once.
    pub known: Vec<(Quantity, f64)>,
    /// Rows of a table: a pressure, and the free air that the hammer takes at it, in SI units.
    pub air: Vec<[f64; 2]>,
    /// The working pressure, if it differs from the sheet's, Pa.
    pub at: Option<f64>,
    /// True if the scene's rock already has the stiffness for this bit. Otherwise the rock is scaled by the hole's
    /// area.
    pub own_rock: bool,
}

/// The reason why there is no hammer.
#[derive(Clone, Debug, ThisError, PartialEq)]
#[non_exhaustive]
pub enum DatasheetError {
    /// A number outside the range of real hammers, probably in another unit.
    #[error("{0}: no hammer is known to have that; is the unit right?")]
    Absurd(#[from] ParameterError),
    /// Too few numbers are given.
    #[error("{0}")]
    TooLittle(String),
    /// The given numbers contradict each other.
    #[error("{0}")]
    Contradiction(String),
    /// The engine refuses the scene.
    #[error(transparent)]
    Engine(#[from] Error),
}

/// A given number and the sample's median.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// Its quantity.
    pub quantity: Quantity,
    /// Pressure of the table's row, Pa.
    pub pressure: Option<f64>,
    /// Given value, SI.
    pub given: f64,
    /// Median of the sample, SI.
    pub solved: f64,
}

impl Comparison {
    /// The sample's value over the given one, minus 1.
    pub fn off(&self) -> f64 {
        self.solved / self.given - 1.0
    }
}

/// A number of the answer, with its 80 % range.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// Its name.
    pub name: &'static str,
    /// Its median, SI.
    pub value: f64,
    /// Ends of the range.
    pub range: [f64; 2],
    /// SI unit; empty for a ratio.
    pub unit: &'static str,
    /// Value of each member of the sample; the weights are the [solution's](Solution::weights).
    pub members: Vec<f64>,
}

/// The answer.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solution {
    /// The scene of the median hammer. Some rounds of simulations adjust its blows to the sample's. The remaining
    /// difference, some tenths of a per cent, may change in steps if the sheet changes smoothly.
    pub scene: Scene,
    /// The given numbers, compared with the sample's.
    pub compared: Vec<Comparison>,
    /// The numbers that follow.
    pub found: Vec<Found>,
    /// Statistical weight of each member of the sample.
    pub weights: Vec<f64>,
    /// The assumptions, a sentence each.
    pub assumed: Vec<String>,
    /// The contradictions with their size, a sentence each.
    pub contradictions: Vec<String>,
}

impl Datasheet {
    /// The hammers that a sheet describes, with the rock, feed and material of a scene.
    ///
    /// # Errors
    /// A number is outside the range of real hammers; too little is given.
    pub fn solve(&self, base: &Scene) -> Result<Solution, DatasheetError> {
        let (scene, mut sample) = self.drawn(base)?;
        let middle = self.hammer(&scene, &sample);
        if let Ok((_, Ok(now))) = &middle {
            let mut then = self.get(Quantity::Rate).map(|_| now.clone());
            if let (Some(then), Some(_)) = (&mut then, self.at) {
                // The rate was measured at the sheet's pressure, not at the working pressure.
                let sheet = Self { at: None, ..self.clone() };
                let (scene, own) = sheet.drawn(base)?;
                if let Ok((_, Ok(found))) = sheet.hammer(&scene, &own) {
                    *then = found;
                }
            }
            sample.drill(now, then.as_ref());
        }
        self.answer(scene, middle, &sample)
    }

    /// The numbers that follow from the sample alone. No scene is simulated, so the share of the work that the rock
    /// gets is the usual one.
    ///
    /// # Errors
    /// Those of [`Self::solve`].
    pub fn sample(&self, base: &Scene) -> Result<Vec<Found>, DatasheetError> {
        let (scene, sample) = self.drawn(base)?;
        Ok(self.found(&scene, &sample))
    }

    fn drawn(&self, base: &Scene) -> Result<(Scene, Sample), DatasheetError> {
        for (quantity, value) in &self.known {
            quantity.check(*value)?;
        }
        let rows = self.air.iter().map(|[at, air]| (*at, *air)).chain(self.at.map(|at| (at, 1.0)));
        for (at, air) in rows {
            Quantity::Pressure.check(at)?;
            Quantity::AirFlow.check(air)?;
        }
        // Energy and mass determine a speed, which must also be in its range.
        let pair = self.get(Quantity::BlowEnergy).zip(self.get(Quantity::PistonMass));
        if let Some((energy, mass)) = pair {
            Quantity::ImpactSpeed.check((2.0 * energy / mass).sqrt())?;
        }
        let mut scene = *base;
        self.lay_rock(&mut scene);
        let sample = Sample::of(self, &scene)?;
        Ok((scene, sample))
    }

    /// The working pressure, Pa, if it is known.
    fn working_pressure(&self) -> Option<f64> {
        self.at.or(self.get(Quantity::Pressure))
    }

    fn get(&self, quantity: Quantity) -> Option<f64> {
        self.known.iter().find(|(q, _)| *q == quantity).map(|(_, value)| *value)
    }

    /// Sets the hole, the feed that holds the casing down, and the rock for this hole.
    fn lay_rock(&self, scene: &mut Scene) {
        let p = &mut scene.parameters;
        if let Some((hole, _)) = self.hole() {
            p.hole.diameter = hole;
            if !self.own_rock {
                p.rock.spread(hole);
            }
        }
        let feed = self.usual_feeds().map(|[_, held]| held);
        scene.inputs.feed_force = feed.unwrap_or(scene.inputs.feed_force);
    }
}
