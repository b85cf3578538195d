//! Where rigid bodies are enough.

use crate::closed;
use hammer::{Error, Fidelity, Parameters};
use serde::Serialize;

/// Ratios `Lp / Lb` of the map.
pub const RATIOS: [f64; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// `kappa = KR Lp / (E A)` of the map.
pub const KAPPAS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// A point of the map: relative error of rigid bodies in the energy that the rock keeps
/// and in the largest rock force.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// `Lp / Lb`.
    pub ratio: f64,
    /// `kappa`.
    pub kappa: f64,
    /// Of the energy kept.
    pub energy: f64,
    /// Of the largest force.
    pub force: f64,
}

/// The whole map, ratio by ratio.
///
/// # Errors
/// Whatever the engine says.
pub fn all() -> Result<Vec<Point>, Error> {
    let points = RATIOS.into_iter().flat_map(|r| KAPPAS.map(|k| (r, k)));
    points.map(|(ratio, kappa)| compare(ratio, kappa)).collect()
}

/// One point: a bare blow, until the rock has let go once.
///
/// # Errors
/// Whatever the engine says.
pub fn compare(ratio: f64, kappa: f64) -> Result<Point, Error> {
    let mut p = closed::blow_scene(kappa, Parameters::default().rock.unloading_ratio, 20);
    // The longer bar keeps its twenty elements' size.
    p.material.damping_time = Parameters::default().material.damping_time;
    p.bit.length = p.piston.length / ratio;
    p.bit.elements = ((20.0 / ratio).round() as usize).clamp(4, 160);
    // A quarter of the period of both masses on the rock, and of the bit's waves.
    let quarter = 0.5 * std::f64::consts::PI * ((1.0 + 1.0 / ratio) / kappa).sqrt();
    let until = 1.5 * quarter + 4.0 * (1.0 + 1.0 / ratio);
    let elastic = closed::strike(&p, until)?;
    p.fidelity = Fidelity::Rigid;
    let rigid = closed::strike(&p, until)?;
    Ok(Point {
        ratio,
        kappa,
        energy: rigid.share / elastic.share - 1.0,
        force: rigid.peak / elastic.peak - 1.0,
    })
}
