//! Warnings about settings that are allowed but probably not intended, each given once.

use super::inputs::Inputs;
use super::settings::Settings;
use hammer::variables::{INPUTS, InputRow};
use hammer::{DisplayNumber, Energies, Input, Machine, Parameters, starved, unfed, unlikely};

/// Warnings that the host has already received.
#[derive(Debug, Default)]
pub struct Warnings {
    ignored: [bool; Input::ALL.len()],
    /// True after the first step, when the drive's inputs are known.
    fed: bool,
    /// Number of times that the energies did not balance.
    unbalanced: u64,
    /// Number of warnings about an exchange that creates energy.
    excesses: u32,
    /// True after a warning: about an impact that is too fast, and about a hole that grows faster than the bit
    /// advances.
    fast: bool,
    outrun: bool,
}

impl Warnings {
    /// Warns of inputs that were set but that the source does not read.
    pub fn ignored(&mut self, parameters: &Parameters, inputs: &Inputs) -> Vec<String> {
        let mut lines = Vec::new();
        for InputRow { name, input, reader, .. } in &INPUTS {
            let known = &mut self.ignored[*input as usize];
            if inputs.sets(*input) && !*known {
                lines.extend(reader.unread(name, parameters).inspect(|_| *known = true));
            }
        }
        lines
    }

    /// At the first step, warns of a source whose inputs were never set, and of a missing feed.
    pub fn starved(&mut self, machine: &Machine, inputs: &Inputs) -> Vec<String> {
        if std::mem::replace(&mut self.fed, true) {
            return Vec::new();
        }
        let starved = starved(machine.parameters().drive.source, |input| inputs.sets(input));
        starved.into_iter().chain(unfed(machine.input(Input::FeedForce))).collect()
    }

    /// Adds warnings after a step.
    pub fn after_step(&mut self, machine: &Machine, lines: &mut Vec<String>) {
        let excesses = machine.exchange_excesses();
        if excesses > self.excesses {
            lines.extend(machine.exchange_warning());
            self.excesses = excesses;
        }
        if !self.fast {
            lines.extend(machine.too_fast().inspect(|_| self.fast = true));
        }
        if !self.outrun {
            lines.extend(machine.outrun().inspect(|_| self.outrun = true));
        }
    }

    /// Warns of energies that do not balance, each time their count has doubled.
    pub fn unbalanced(&mut self, energies: &Energies) -> Option<String> {
        let bound = energies.residual_bound();
        if energies.residual.abs() <= bound {
            return None;
        }
        self.unbalanced += 1;
        self.unbalanced.is_power_of_two().then(|| {
            format!(
                "energy_residual = {} J is beyond the {} J that rounding explains, {} times so \
                 far: do not trust the energies",
                DisplayNumber(energies.residual),
                DisplayNumber(bound),
                self.unbalanced
            )
        })
    }
}

/// Warnings of values that seem to be in another unit.
pub fn of_values(settings: &Settings, inputs: &Inputs) -> Vec<String> {
    let parameters = settings.parameters();
    parameters.map_or_else(|_| Vec::new(), |p| unlikely(&p, &inputs.starting()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_beyond_rounding_is_told_and_counted() {
        let mut warnings = Warnings::default();
        let with = |residual| {
            let mut energies = Energies::default();
            (energies.drive, energies.kinetic, energies.residual) = (300.0, 300.0, residual);
            energies
        };
        assert_eq!(warnings.unbalanced(&with(1e-9)), None);
        let wrong = with(-37.0);
        let lines: Vec<String> = (0..5).filter_map(|_| warnings.unbalanced(&wrong)).collect();
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert!(lines[2].contains("energy_residual = -37 J") && lines[2].contains("4 times"));
        let none = with(f64::NAN);
        assert_eq!((5..8).filter_map(|_| warnings.unbalanced(&none)).count(), 1);
    }
}
