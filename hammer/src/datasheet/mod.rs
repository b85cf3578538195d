//! A hammer from what a datasheet says, solved as one.
//!
//! The drive is the relay: a constant force `F` that throws a piston of mass `m` at the bit and lifts it
//! until it is `D` above the bit. What is known, a pressure, a bore, a stroke, an energy, a frequency and
//! so on, each with its error, is fitted by least squares over `F`, `D`, `m` and the effectiveness `eta`
//! of the drive (the mean driving pressure over the supply's, `F = eta p A`). How bit and rock throw the
//! piston back no datasheet says: that is taken from the mean response of simulated blows, and the fit is
//! repeated until both agree. Where the sheet says the air that a hammer takes, the answer is one with
//! its air inside (`air`): the ports are fitted to the air, and its blows are simulated.
//!
//! What a sheet leaves open is assumed (`assume`), with an error, and told: the answer's numbers have the
//! ranges that follow. What no hammer does is told too (`limits`).
//!
//! A number that is off by a unit or a factor of ten is refused, with the range of real hammers. Numbers
//! that contradict each other are told, with the size of the contradiction.

mod air;
mod answer;
mod assume;
mod fit;
mod limits;
mod quantity;
mod relay;
mod response;

pub use air::AirBlow;
pub use quantity::Quantity;
pub use relay::{Relay, Throw};

use crate::error::Error;
use crate::numerics::math;
use crate::presets::DAMPING;
use crate::quantities::domain::ParameterError;
use crate::quantities::parameters::MAX_ELEMENTS;
use crate::quantities::sections::Body;
use crate::scene::Scene;
use fit::{Fit, Unknowns};
use response::Response;
use thiserror::Error as ThisError;

/// Rounds of fit and simulation, and how close the blows of both must come, at first and then.
const ROUNDS: usize = 30;
const CLOSE: f64 = 1e-3;
const SCATTER: f64 = 1e-2;
/// Power of the blows over pressure times flow of a liquid: assumed, to a quarter.
const EFFICIENCY: f64 = 0.6;

/// What is known of a hammer.
#[derive(Clone, Debug, Default)]
pub struct Datasheet {
    /// What the sheet gives, in SI units, each at most once.
    pub known: Vec<(Quantity, f64)>,
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

/// A number that was given, and what the hammer makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Which.
    pub quantity: Quantity,
    /// As given, SI.
    pub given: f64,
    /// Of the hammer, SI.
    pub solved: f64,
}

impl Comparison {
    /// How far the hammer is off, over what was given.
    pub fn off(&self) -> f64 {
        self.solved / self.given - 1.0
    }
}

/// A number that follows, and the range that the errors of all that is given and assumed leave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// What it is.
    pub name: &'static str,
    /// Its value, SI.
    pub value: f64,
    /// From the least to the largest; both the value of what has none.
    pub range: [f64; 2],
    /// SI unit; empty of a ratio.
    pub unit: &'static str,
}

/// The hammer.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Its scene.
    pub scene: Scene,
    /// What was given beside what it gives.
    pub compared: Vec<Comparison>,
    /// What else follows.
    pub found: Vec<Found>,
    /// What was assumed, a sentence each.
    pub assumed: Vec<String>,
    /// What contradicts, a sentence each, with its size.
    pub contradictions: Vec<String>,
}

impl Datasheet {
    /// The hammer that fits best, its rock, feed and material those of a scene.
    ///
    /// # Errors
    /// A number that no hammer has; too little to find a hammer; numbers that no hammer has at once; a
    /// hammer that does not strike.
    pub fn solve(&self, base: &Scene) -> Result<Solution, DatasheetError> {
        self.check()?;
        let mut fit = Fit::new(self, base)?;
        let (mut unknowns, mut response) = (fit.start(), Response::GUESS);
        let mut round = 0;
        loop {
            // Blows that do not repeat have means that scatter.
            let close = if round < ROUNDS / 3 { CLOSE } else { SCATTER };
            unknowns = fit.solve(unknowns, &response)?;
            if fit.limit(&fit.throw(&unknowns, &response)) {
                unknowns = fit.solve(unknowns, &response)?;
            }
            self.check_speed(&fit.throw(&unknowns, &response))?;
            let scene = self.scene(base, &unknowns)?;
            let (next, close) = response.next(&scene, &unknowns.relay(base), close)?;
            response = next;
            round += 1;
            if close || round == ROUNDS {
                let mut failed = None;
                let air = match self.with_air(&scene, &unknowns) {
                    Some(Err(error)) => {
                        failed = Some(format!("It is driven by a constant force here: {error}."));
                        None
                    }
                    found => found.and_then(Result::ok),
                };
                let mut answer = match air {
                    Some((scene, blow)) => {
                        fit.answer(&unknowns, &blow.response(&response), scene, Some(&blow))
                    }
                    None => fit.answer(&unknowns, &response, scene, None),
                };
                answer.contradictions.extend(failed);
                let text =
                    "Such a hammer finds no steady blow: its numbers are those of its last blows.";
                answer.contradictions.extend((!close).then(|| text.into()));
                return Ok(answer);
            }
        }
    }

    /// A quantity that is known.
    fn get(&self, quantity: Quantity) -> Option<f64> {
        self.known.iter().find(|(q, _)| *q == quantity).map(|(_, value)| *value)
    }

    fn check(&self) -> Result<(), DatasheetError> {
        for (quantity, value) in &self.known {
            quantity.check(*value)?;
        }
        // Energy and mass say a speed, too.
        let pair = self.get(Quantity::BlowEnergy).zip(self.get(Quantity::PistonMass));
        pair.map_or(Ok(()), |(energy, mass)| {
            Ok(Quantity::ImpactSpeed.check((2.0 * energy / mass).sqrt())?)
        })
    }

    fn check_speed(&self, throw: &Throw) -> Result<(), DatasheetError> {
        Quantity::ImpactSpeed.check(throw.speed)?;
        Ok(Quantity::BlowEnergy.check(throw.energy)?)
    }

    /// The scene of a hammer: uniform bodies, a mesh and a penalty alike in proportion.
    fn scene(&self, base: &Scene, unknowns: &Unknowns) -> Result<Scene, DatasheetError> {
        let (mut scene, reference) = (*base, base.parameters);
        let p = &mut scene.parameters;
        let density = p.material.density;
        let sections = reference.sections(Body::Piston);
        let own_length = sections.length();
        let own_area = sections.mass(density) / density / own_length;
        let slender = own_length * math::cbrt(unknowns.mass / reference.piston_mass());
        let length = self.get(Quantity::PistonLength).unwrap_or(slender);
        let area = unknowns.mass / (density * length);
        (p.piston.segments, p.bit.segments) = (0, 0);
        (p.piston.length, p.cross_section) = (length, area);
        let bit_mass = self.get(Quantity::BitMass);
        p.bit.length = bit_mass.map_or(length, |mass| mass / (density * area));
        let per_metre = reference.piston.elements as f64 / own_length;
        let elements = |length: f64| ((per_metre * length).round() as usize).clamp(1, MAX_ELEMENTS);
        (p.piston.elements, p.bit.elements) = (elements(length), elements(p.bit.length));
        p.contact.stiffness *= area / own_area;
        p.drive.amplitude = unknowns.force;
        (p.drive.stroke, p.contact.initial_gap) = (unknowns.lift, unknowns.lift);
        let hole = self.hole().map(|(hole, _)| hole);
        p.hole.diameter = hole.unwrap_or(p.hole.diameter);
        if let Some(hole) = hole.filter(|_| !self.own_rock) {
            p.rock.spread(hole);
        }
        let damping = p.damping_time_of(self.get(Quantity::DampingRatio).unwrap_or(DAMPING));
        p.material.damping_time = damping.unwrap_or(p.material.damping_time);
        let feed = self.get(Quantity::Feed).or_else(|| self.usual_feed());
        scene.inputs.feed_force = feed.unwrap_or(scene.inputs.feed_force);
        p.validate().map_err(Error::from)?;
        Ok(scene)
    }
}
