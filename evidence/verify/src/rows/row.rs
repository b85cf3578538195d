//! A row of the report: two compared numbers, and how closely they must agree.

/// One comparison.
#[derive(Clone, Debug)]
pub struct Row {
    /// The scene.
    pub case: String,
    /// The compared quantity.
    pub quantity: String,
    /// The reference value.
    pub reference: f64,
    /// Its source.
    pub source: &'static str,
    /// The engine's value.
    pub ours: f64,
    /// Largest difference allowed.
    pub tolerance: f64,
    /// Reason of the tolerance.
    pub why: &'static str,
}

impl Row {
    /// The engine's value less the reference.
    pub fn difference(&self) -> f64 {
        self.ours - self.reference
    }

    /// True if the difference is within the tolerance.
    pub fn holds(&self) -> bool {
        self.difference().abs() <= self.tolerance
    }
}

/// Panics with every row that does not hold.
///
/// # Panics
/// If a row does not hold, or if there is none.
pub fn assert_all(rows: &[Row]) {
    assert!(!rows.is_empty(), "no row was made");
    let line = |row: &Row| {
        let Row { case, quantity, ours, reference, tolerance, .. } = row;
        let off = row.difference();
        format!(
            "{case}, {quantity}: {ours} instead of {reference}, off by {off:.3e}, allowed {tolerance:.3e}"
        )
    };
    let failed: Vec<String> = rows.iter().filter(|row| !row.holds()).map(line).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// Rows of one case that share source and reason.
pub struct Rows {
    case: String,
    source: &'static str,
    why: &'static str,
    /// The rows so far.
    pub list: Vec<Row>,
}

impl Rows {
    /// An empty list.
    pub fn new(case: impl Into<String>, source: &'static str, why: &'static str) -> Self {
        Self { case: case.into(), source, why, list: Vec::new() }
    }

    /// Adds a comparison.
    pub fn add(&mut self, quantity: impl Into<String>, reference: f64, ours: f64, tolerance: f64) {
        let quantity = quantity.into();
        let (case, source, why) = (self.case.clone(), self.source, self.why);
        self.list.push(Row { case, quantity, reference, source, ours, tolerance, why });
    }
}
