//! A setting on finer and finer meshes: what is measured, its errors, and their order.

/// Elements per bar.
pub const MESHES: [usize; 6] = [5, 10, 20, 40, 80, 160];
/// Orders are fitted to meshes from here on.
const FITTED: usize = 2;

/// Order of every quantity where the mesh resolves the fronts.
pub const ORDER: f64 = 2.0;

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
    pub quantities: Vec<&'static str>,
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

/// How far a value may be from its limit, by its changes over three meshes, each twice as fine as the one
/// before.
pub fn remaining([quarter, half, full]: [f64; 3]) -> f64 {
    let ratio = 2f64.powf(2.0 / 3.0);
    (full - half).abs().max((half - quarter).abs() / ratio) / (ratio - 1.0)
}
