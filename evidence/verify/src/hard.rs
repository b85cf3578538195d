//! Hard cases: what a solver of this model may stumble over, each under watch.

use crate::hard_cases;
use crate::monitor::{Monitored, Violation};
use hammer::{Counters, InputValues, Parameters};

/// How a case goes beyond being driven.
pub type Play = fn(&mut Monitored) -> Result<String, Violation>;

/// One hard case.
pub struct Case {
    /// Name, also of its test.
    pub name: &'static str,
    /// What is set, and why it is hard.
    pub setting: &'static str,
    /// Parameters.
    pub parameters: Parameters,
    /// Inputs.
    pub inputs: InputValues,
    /// Samples that it may take.
    pub allowed: u64,
    /// What is done; the string is the outcome.
    pub play: Play,
}

/// What came of it.
#[derive(Debug)]
pub struct Outcome {
    /// In words.
    pub words: String,
    /// Counted.
    pub counters: Counters,
    /// Largest residual, J, its bound, and the largest ratio met.
    pub energy: [f64; 3],
    /// At the end.
    pub stalled: bool,
}

impl Case {
    /// Plays the case.
    ///
    /// # Errors
    /// The first violation.
    pub fn run(&self) -> Result<Outcome, Violation> {
        let mut monitored = Monitored::new(&self.parameters, &self.inputs, self.allowed)?;
        let words = (self.play)(&mut monitored)?;
        monitored.observe()?;
        let observed = monitored.observed;
        Ok(Outcome {
            words,
            counters: monitored.machine.counters(),
            energy: [observed.residual, observed.bound, observed.ratio],
            stalled: monitored.machine.stalled(),
        })
    }
}

/// All of them.
pub fn all() -> Vec<Case> {
    [hard_cases::stiff(), crate::hard_scenes::scenes(), crate::graze::cases()]
        .into_iter()
        .flatten()
        .collect()
}

/// Plays the case of this name.
///
/// # Panics
/// If there is none, or it fails.
pub fn assert_case(name: &str) {
    let cases = all();
    let case = cases.iter().find(|c| c.name == name).expect("a case of this name");
    if let Err(violation) = case.run() {
        panic!("{name}: {violation}");
    }
}
