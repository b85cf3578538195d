//! Reference solutions: of two runs of [`crate::run`] with different accuracy, the better one and the difference.
//! One is stored.

use crate::dd::Dd;
use crate::law::State;
use crate::linear::Real;
use crate::record::{Passed, Sampled};
use crate::run::Run;
use crate::scene::Scene;
use crate::taylor::Accuracy;
use serde::{Deserialize, Serialize};

/// A scene solved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solution {
    /// The scene.
    pub scene: Scene,
    /// Largest difference from the second run at any instant: displacements over 1 mm, velocities over 1 m/s.
    pub uncertainty: f64,
    /// Every transition, in order.
    pub events: Vec<Passed<Dd>>,
    /// States at the instants asked for.
    pub states: Vec<Sampled<Dd>>,
}

/// Largest difference, in 1 mm and 1 m/s; `f64::MAX` if any is not finite.
pub fn distance<T: Real>(a: &State<T>, b: &State<T>) -> f64 {
    let worst = |x: &[T], y: &[T], scale: f64| {
        x.iter().zip(y).fold(0.0f64, |max, (&x, &y)| {
            let d = (x - y).to_f64().abs() / scale;
            if d.is_finite() { max.max(d) } else { f64::MAX }
        })
    };
    worst(&a.u, &b.u, 1e-3).max(worst(&a.v, &b.v, 1.0))
}

/// Runs twice, and keeps the first run with the difference.
///
/// # Errors
/// A run was given up, or the two have different sequences of events.
pub fn solve(
    scene: &Scene,
    instants: &[f64],
    accuracies: [Accuracy; 2],
) -> Result<Solution, String> {
    let [mut one, mut two] = accuracies.map(|accuracy| Run::<Dd>::new(scene, accuracy));
    for run in [&mut one, &mut two] {
        run.through(instants, &[]).map_err(|e| e.to_string())?;
    }
    if !one.events.iter().map(|e| e.event).eq(two.events.iter().map(|e| e.event)) {
        return Err("the two runs disagree on the events".into());
    }
    let pairs = one.samples.iter().zip(&two.samples);
    let uncertainty = pairs.fold(0.0, |max, (a, b)| f64::max(max, distance(&a.state, &b.state)));
    Ok(Solution { scene: scene.clone(), uncertainty, events: one.events, states: one.samples })
}

/// Elements per bar of the reference hammer whose solution is stored.
pub const ELEMENTS: usize = 5;

/// Instants at which its states are kept: six in the first 20 ms, with the first blow and its rebound, and five about
/// the second blow, s.
pub const INSTANTS: [f64; 11] =
    [10e-3, 13.72e-3, 14e-3, 15e-3, 17e-3, 20e-3, 46e-3, 58e-3, 59e-3, 62e-3, 70e-3];

/// Where it is, in a checkout.
pub const STORED: &str = "evidence/oracles/data/reference.json";

/// The stored solution.
///
/// # Errors
/// It is no solution.
pub fn stored() -> std::io::Result<Solution> {
    Ok(serde_json::from_str(include_str!("../data/reference.json"))?)
}
