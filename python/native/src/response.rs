//! Long-run responses for Python: what is wanted, and what was found, as numbers.

use crate::failure::refused;
use hammer::means::{Averages, Kind, MOST_REPEATING, Steady, Wanted};
use pyo3::prelude::*;

/// A response as numbers: blows after which it repeats (0: never, -1: stalled), blows of the means, whether the error
/// was reached, means, errors, spreads.
pub fn response_numbers(found: &Steady) -> Vec<f64> {
    let repeating = match found.kind {
        Kind::Cycle(blows) => blows as f64,
        Kind::Irregular => 0.0,
        Kind::Stalled => -1.0,
    };
    let head = [repeating, found.blows as f64, f64::from(u8::from(found.reached))];
    let means = [found.mean, found.error, found.spread];
    head.into_iter().chain(means.iter().flat_map(|averages| averages.0)).collect()
}

/// What is wanted: the largest error of each mean, most blows, longest time without a blow (s), longest cycle in blows,
/// and whether a second start is tried.
pub type Asked = (Vec<f64>, usize, f64, usize, bool);

/// What is wanted, as the engine has it.
pub fn wanted_of((error, blows, limit, repeating, second): Asked) -> PyResult<Wanted> {
    if repeating > MOST_REPEATING {
        return Err(refused(format!("repeating = {repeating} must be 0 to {MOST_REPEATING}")));
    }
    let error = error.try_into().map(Averages).map_err(|wrong: Vec<f64>| {
        refused(format!("{} errors are not the {} of the means", wrong.len(), Averages::COUNT))
    })?;
    Ok(Wanted { error, blows, limit, repeating, threads: 1, second })
}
