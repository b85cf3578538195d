//! Hammers from what a datasheet says: a sample of them, and the range of every number.
//!
//! A sheet leaves most of a hammer open. So it is answered by a sample: of what is unknown (pressure, bore, mass,
//! stroke, ports, effectiveness, and the errors of hammers in proportion to the presets) each member has other
//! numbers, drawn once for all sheets; all are moved to what is given, up to the errors of such numbers (`member`).
//! What members do follows from one table of simulated blows (`table`). Of every number the middle is told and the
//! range of 80 % of the members (`sample`). Where steel would not stand the speed, members are cut out. So an answer
//! changes by little where a sheet changes by little; what is given and cannot be met is told with how much it is
//! off, and nothing is dropped for another model.
//!
//! The scene that is handed out is the middle hammer, simulated, and moved until its blows are the told ones.
//!
//! A number that is off by a unit or a factor of ten is refused, with the range of real hammers. What no hammer
//! does is told (`limits`).

mod air;
mod answer;
mod assume;
mod limits;
mod member;
mod quantity;
mod sample;
mod table;

pub use air::AirBlow;
pub use answer::TURN;
pub use quantity::Quantity;
pub use sample::spread;

use crate::error::Error;
use crate::quantities::domain::ParameterError;
use crate::scene::Scene;
use sample::Sample;
use thiserror::Error as ThisError;

/// Power of the blows over pressure times flow of a liquid.
const EFFICIENCY: f64 = 0.6;

/// What is known of a hammer.
#[derive(Clone, Debug, Default)]
pub struct Datasheet {
    /// What the sheet gives, in SI units, each at most once.
    pub known: Vec<(Quantity, f64)>,
    /// Rows of a table: pressures and the free air that is taken there, SI.
    pub air: Vec<[f64; 2]>,
    /// The pressure that is worked at, if it is not the sheet's, Pa.
    pub at: Option<f64>,
    /// The scene's rock is that under this bit: it is not scaled by the hole's area.
    pub own_rock: bool,
}

/// Why there is no hammer.
#[derive(Clone, Debug, ThisError, PartialEq)]
pub enum DatasheetError {
    /// A number that no hammer has: likely another unit.
    #[error("{0}: no hammer is known to have that; is the unit right?")]
    Absurd(#[from] ParameterError),
    /// Too little is known.
    #[error("{0}")]
    TooLittle(String),
    /// What is known cannot be had at once.
    #[error("{0}")]
    Contradiction(String),
    /// The engine refuses the hammer.
    #[error(transparent)]
    Engine(#[from] Error),
}

/// A number that was given, and what the hammers make of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Which.
    pub quantity: Quantity,
    /// Of a row of a table: its pressure, Pa.
    pub pressure: Option<f64>,
    /// As given, SI.
    pub given: f64,
    /// Of the hammers, SI.
    pub solved: f64,
}

impl Comparison {
    /// How far the hammers are off, over what was given.
    pub fn off(&self) -> f64 {
        self.solved / self.given - 1.0
    }
}

/// A number that follows, and the range of 80 % of the hammers that the sheet allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What it is.
    pub name: &'static str,
    /// Its middle, SI.
    pub value: f64,
    /// From the least to the largest; both the value of what has none.
    pub range: [f64; 2],
    /// SI unit; empty of a ratio.
    pub unit: &'static str,
    /// Of each hammer of the sample, its weight being the [solution's](Solution::weights).
    pub members: Vec<f64>,
}

/// The hammers.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The scene of the middle one. It is moved in rounds until its blows are the told ones, and so may step by
    /// what is left of them, some tenths of a per cent, where the sheet moves by less.
    pub scene: Scene,
    /// What was given beside what they give.
    pub compared: Vec<Comparison>,
    /// What else follows.
    pub found: Vec<Found>,
    /// What each member of the sample counts.
    pub weights: Vec<f64>,
    /// What was assumed, a sentence each.
    pub assumed: Vec<String>,
    /// What contradicts, a sentence each, with its size.
    pub contradictions: Vec<String>,
}

impl Datasheet {
    /// The hammers that a sheet describes, their rock, feed and material those of a scene.
    ///
    /// # Errors
    /// A number that no hammer has; too little to find a hammer.
    pub fn solve(&self, base: &Scene) -> Result<Solution, DatasheetError> {
        let (scene, mut sample) = self.drawn(base)?;
        let middle = self.hammer(&scene, &sample);
        if let Ok((_, share)) = middle {
            let mut measured = self.get(Quantity::Rate).map(|_| share);
            if let (Some(then), Some(_)) = (&mut measured, self.at) {
                // Measured at the sheet's pressure, whichever is worked at.
                let sheet = Self { at: None, ..self.clone() };
                let (scene, own) = sheet.drawn(base)?;
                *then = sheet.hammer(&scene, &own).map_or(share, |(_, then)| then);
            }
            sample.take_share(share, measured);
        }
        self.answer(scene, middle, &sample)
    }

    /// The numbers of the sample alone: no scene is made, so its share of work to the rock is the usual one.
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
        // Energy and mass say a speed, too.
        let pair = self.get(Quantity::BlowEnergy).zip(self.get(Quantity::PistonMass));
        if let Some((energy, mass)) = pair {
            Quantity::ImpactSpeed.check((2.0 * energy / mass).sqrt())?;
        }
        let mut scene = *base;
        self.lay_rock(&mut scene);
        let sample = Sample::of(self, &scene)?;
        Ok((scene, sample))
    }

    /// A quantity that is known.
    fn get(&self, quantity: Quantity) -> Option<f64> {
        self.known.iter().find(|(q, _)| *q == quantity).map(|(_, value)| *value)
    }

    /// Hole, feed, and the rock under this hole.
    fn lay_rock(&self, scene: &mut Scene) {
        let p = &mut scene.parameters;
        if let Some((hole, _)) = self.hole() {
            p.hole.diameter = hole;
            if !self.own_rock {
                p.rock.spread(hole);
            }
        }
        let feed = self.get(Quantity::Feed).or_else(|| Some(self.usual_feeds()?[1]));
        scene.inputs.feed_force = feed.unwrap_or(scene.inputs.feed_force);
    }
}
