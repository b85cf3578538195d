//! Hard cases: what a solver of this model may stumble over, each under watch.

pub mod cases;
mod graze;

use crate::laws::monitor::{Monitored, Violation};
use hammer::{Counters, InputValues, Parameters};

/// What is done in a case; the string is the outcome.
type Play = dyn Fn(&mut Monitored) -> Result<String, Violation>;

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
    /// What is done.
    pub play: Box<Play>,
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

/// Samples for a couple of blows: an ordinary one takes about two thousand.
pub(crate) const BLOWS: u64 = 500_000;

pub(crate) fn case(
    name: &'static str,
    setting: &'static str,
    change: impl FnOnce(&mut Parameters, &mut InputValues),
    play: impl Fn(&mut Monitored) -> Result<String, Violation> + 'static,
) -> Case {
    let (mut parameters, mut inputs) = (Parameters::default(), InputValues::default());
    change(&mut parameters, &mut inputs);
    Case { name, setting, parameters, inputs, allowed: BLOWS, play: Box::new(play) }
}

pub(crate) fn summary(w: &mut Monitored) -> String {
    let (c, mode) = (w.machine.counters(), w.machine.mode());
    let stalled = if w.machine.stalled() { ", stalled" } else { "" };
    format!("{} blows, {} drilling cycles, ends {:?}{stalled}", c.blows, c.rock_cycles, mode.rock)
}

/// Driven for a time, in so many steps.
pub(crate) fn run(span: f64, steps: u32) -> impl Fn(&mut Monitored) -> Result<String, Violation> {
    move |w| {
        w.run(span, steps)?;
        Ok(summary(w))
    }
}

/// Two cycles of the reference hammer.
pub(crate) fn cycles(w: &mut Monitored) -> Result<String, Violation> {
    run(0.1, 200)(w)
}

/// A case that did not show what it is for.
pub fn missed(what: &'static str, w: &Monitored) -> Violation {
    Violation::Wrong { what, time: w.machine.time(), value: 0.0, allowed: 1.0 }
}

/// What is left when host and step are taken out of a state.
pub fn trajectory(w: &hammer::Machine) -> hammer::State {
    w.state().without_step()
}
