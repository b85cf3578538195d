//! Studies: convergence with the mesh, and where rigid bodies are enough.

use crate::closed::{self, Struck};
use crate::mesh;
use hammer::{Error, Fidelity, InputValues, Machine, Parameters};
use serde::Serialize;

/// Elements a bar.
pub const MESHES: [usize; 6] = [5, 10, 20, 40, 80, 160];

/// One mesh of the study.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Refined {
    /// Elements a bar.
    pub elements: usize,
    /// Errors against exact waves: `eta`, peak rock force, second collision (one blow,
    /// `kappa` 0.3, `gamma` 5); peak force of a bar on a spring (`k` 1).
    pub errors: [f64; 4],
    /// Transitions of the blow.
    pub events: u64,
    /// Stationary period (ms) and ROP (mm/s) of the reference hammer.
    pub stationary: [f64; 2],
}

/// What the columns of errors are.
pub const QUANTITIES: [&str; 4] =
    ["eta", "peak rock force", "second collision", "peak on a spring"];

/// One mesh.
///
/// # Errors
/// Whatever the engine says.
pub fn refine(elements: usize) -> Result<Refined, Error> {
    let [kappa, gamma, .., second] = closed::BLOWS[3];
    let exact = closed::exact_blow(kappa, gamma, second);
    let ours = closed::strike(&closed::blow_scene(kappa, gamma, elements), second + 2.5)?;
    let (spring, peak) = on_spring(elements)?;
    let errors = [
        ours.share - 2.0 * exact.kept,
        ours.peak - exact.peak,
        ours.second - exact.collisions[1].start,
        spring.contact_peak - peak,
    ];
    let stationary = stationary(elements)?;
    Ok(Refined { elements, errors: errors.map(f64::abs), events: ours.events, stationary })
}

/// A bar on a spring of `k = 1`, and its exact peak `1 - (1 - q) e^-t...`: the closed form
/// is `2 <= s <= 4`, whose maximum is where its slope is zero.
fn on_spring(elements: usize) -> Result<(Struck, f64), Error> {
    let mut p = mesh::bare(elements);
    p.bit.length *= 1e7;
    p.bit.elements = 1;
    p.contact.stiffness = mesh::stretch(&p) / p.piston.length;
    // F = (2 - e^-2 + 2 x) e^-x - 1 with x = s - 2 rises until x = e^-2 / 2.
    let x = 0.5 * (-2f64).exp();
    let peak = 2.0 * (-x).exp() - 1.0;
    Ok((closed::strike(&p, 4.5)?, peak))
}

/// Period (ms) and ROP (mm/s) after thirty blows of the reference hammer.
fn stationary(elements: usize) -> Result<[f64; 2], Error> {
    let mut p = Parameters::default();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    let mut m = Machine::new(&p, &InputValues::default(), 0.0)?;
    while m.counters().blows < 30 {
        m.advance(m.time() + 0.01)?;
    }
    Ok([1e3 * m.blow().period, 1e3 * m.blow().rop])
}

/// Observed order between two meshes.
pub fn order(coarse: &Refined, fine: &Refined, quantity: usize) -> f64 {
    let ratio = coarse.errors[quantity] / fine.errors[quantity];
    ratio.ln() / (fine.elements as f64 / coarse.elements as f64).ln()
}

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
