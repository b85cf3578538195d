//! A setting on finer and finer meshes: what is measured, its errors, and their order.

use hammer::Error;

/// Elements per bar.
pub const MESHES: [usize; 6] = [5, 10, 20, 40, 80, 160];
/// Orders are fitted to meshes from here on.
const FITTED: usize = 2;

/// What is measured, and the order that theory gives it.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Name, with its unit.
    pub name: String,
    /// Expected order.
    pub order: f64,
}

/// One mesh.
#[derive(Clone, Debug)]
pub struct Level {
    /// Elements per bar.
    pub elements: usize,
    /// Error of each quantity.
    pub errors: Vec<f64>,
    /// Transitions.
    pub events: u64,
    /// Rotations of the modal state: the cost, on any machine.
    pub samples: u64,
    /// Time taken here, decompositions included, s.
    pub seconds: f64,
}

/// One setting, refined.
#[derive(Clone, Debug)]
pub struct Study {
    /// Title.
    pub title: String,
    /// What is kept and what scales, and what it is compared with.
    pub setting: &'static str,
    /// The columns.
    pub quantities: Vec<Quantity>,
    /// The rows.
    pub levels: Vec<Level>,
}

impl Study {
    /// Order observed between a mesh and the one before.
    pub fn order(&self, level: usize, quantity: usize) -> Option<f64> {
        let (coarse, fine) = (self.levels.get(level.checked_sub(1)?)?, &self.levels[level]);
        let ratio = coarse.errors[quantity].abs() / fine.errors[quantity].abs();
        Some(ratio.ln() / (fine.elements as f64 / coarse.elements as f64).ln())
    }

    /// Order fitted to the four finest meshes: the slope of a line through the logarithms.
    pub fn fitted(&self, quantity: usize) -> f64 {
        let point = |l: &Level| [(l.elements as f64).ln(), -l.errors[quantity].abs().ln()];
        let points: Vec<_> = self.levels[FITTED..].iter().map(point).collect();
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(0), mean(1));
        let up: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
        up / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
    }
}

/// A level a mesh of [`MESHES`].
///
/// # Errors
/// Whatever the engine says.
pub fn refined(level: impl Fn(usize) -> Result<Level, Error>) -> Result<Vec<Level>, Error> {
    MESHES.into_iter().map(level).collect()
}

/// How far a value may be from its limit, by its changes over three meshes, each twice as fine as the one
/// before.
pub fn remaining([quarter, half, full]: [f64; 3]) -> f64 {
    let ratio = 2f64.powf(2.0 / 3.0);
    (full - half).abs().max((half - quarter).abs() / ratio) / (ratio - 1.0)
}
