//! A row of the report: what is compared with what, and how closely it must agree.

/// One comparison.
#[derive(Clone, Debug)]
pub struct Row {
    /// The scene.
    pub case: String,
    /// What is compared.
    pub quantity: String,
    /// The value to be met.
    pub reference: f64,
    /// Where it comes from.
    pub source: &'static str,
    /// What the project's code gives.
    pub ours: f64,
    /// Largest difference allowed.
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub why: &'static str,
}

impl Row {
    /// Ours less the reference.
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
/// If one does not, or if there is none.
pub fn assert_all(rows: &[Row]) {
    assert!(!rows.is_empty(), "no row was made");
    let failed: Vec<String> = rows
        .iter()
        .filter(|row| !row.holds())
        .map(|row| {
            format!(
                "{}, {}: {} instead of {}, off by {:.3e}, allowed {:.3e}",
                row.case,
                row.quantity,
                row.ours,
                row.reference,
                row.difference(),
                row.tolerance
            )
        })
        .collect();
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
    /// No row yet.
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
