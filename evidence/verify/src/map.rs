//! Where rigid bodies are enough.

use crate::{closed, mesh};
use hammer::{Error, Event, Fidelity, InputValues, Machine, Parameters, Relay};
use serde::Serialize;

/// Ratios `Lp / Lb` of the map.
pub const RATIOS: [f64; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// `kappa = KR Lp / (E A)` of the map.
pub const KAPPAS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// A point of the map: relative errors of rigid bodies.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// `Lp / Lb`.
    pub ratio: f64,
    /// `kappa`.
    pub kappa: f64,
    /// In the energy that the rock keeps of one bare blow.
    pub energy: f64,
    /// In the largest rock force of that blow.
    pub force: f64,
    /// In the rate of penetration of the whole hammer.
    pub tip_rate: f64,
    /// In its period.
    pub period: f64,
}

/// The whole map, ratio by ratio.
///
/// # Errors
/// Whatever the engine says.
pub fn all() -> Result<Vec<Point>, Error> {
    let points = RATIOS.into_iter().flat_map(|r| KAPPAS.map(|k| (r, k)));
    points.map(|(ratio, kappa)| compare(ratio, kappa)).collect()
}

/// The bit's length by the ratio, and elements as long as the piston's.
fn lengthen(p: &mut Parameters, ratio: f64) {
    p.bit.length = p.piston.length / ratio;
    p.bit.elements = ((p.piston.elements as f64 / ratio).round() as usize).clamp(4, 160);
}

fn compare(ratio: f64, kappa: f64) -> Result<Point, Error> {
    let both = |of: &dyn Fn(Fidelity) -> Result<[f64; 2], Error>| -> Result<[f64; 2], Error> {
        let (rigid, elastic) = (of(Fidelity::Rigid)?, of(Fidelity::Elastic)?);
        Ok([rigid[0] / elastic[0] - 1.0, rigid[1] / elastic[1] - 1.0])
    };
    let [energy, force] = both(&|fidelity| blow(fidelity, ratio, kappa))?;
    let [tip_rate, period] = both(&|fidelity| hammer(fidelity, ratio, kappa))?;
    Ok(Point { ratio, kappa, energy, force, tip_rate, period })
}

/// Energy kept and largest force of a bare blow, until the rock has let go once.
fn blow(fidelity: Fidelity, ratio: f64, kappa: f64) -> Result<[f64; 2], Error> {
    let mut p = closed::blow_scene(kappa, Parameters::default().rock.unloading_ratio, 20);
    p.fidelity = fidelity;
    p.material.damping_time = Parameters::default().material.damping_time;
    lengthen(&mut p, ratio);
    // A quarter of the period of both masses on the rock, and of the bit's waves.
    let quarter = 0.5 * std::f64::consts::PI * ((1.0 + 1.0 / ratio) / kappa).sqrt();
    let until = 1.5 * quarter + 4.0 * (1.0 + 1.0 / ratio);
    let struck = closed::strike(&p, until)?;
    Ok([struck.share, struck.peak])
}

/// Rate of penetration and period of the reference hammer with another bit in other rock,
/// the mean of twenty cycles after ten.
fn hammer(fidelity: Fidelity, ratio: f64, kappa: f64) -> Result<[f64; 2], Error> {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    lengthen(&mut p, ratio);
    p.rock.stiffness = kappa * mesh::stretch(&p) / p.piston.length;
    let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
    m.keep_journal(true);
    let mut switches = 0;
    // At the switches of the relay: a light piston may strike twice in one cycle.
    let mut mark = |count: usize| -> Result<[f64; 3], Error> {
        while switches < count {
            m.advance(m.time() + 1e-3)?;
            switches +=
                m.take_journal().iter().filter(|r| r.event == Event::Relay(Relay::Return)).count();
        }
        Ok([m.time(), m.kinematics().hole_depth, switches as f64])
    };
    let (start, end) = (mark(10)?, mark(30)?);
    let [time, depth, cycles] = [0, 1, 2].map(|i| end[i] - start[i]);
    Ok([depth / time, time / cycles])
}
