//! What is allowed but likely not meant: each told once, as a warning.

use super::inputs::Inputs;
use super::settings::Settings;
use hammer::quantity::{Quantity, SOURCE};
use hammer::variables::{INPUTS, InputRow, Reader, Role, Slot, VARIABLES, Variable};
use hammer::{DisplayNumber, Energies, Input, InputValues, Parameters, Source};

/// A value this many times off the reference hammer's is likely in another unit: those that
/// are mixed up lie a thousand apart (mm and m, kN and N), real hammers and rocks less.
const SLIP: f64 = 300.0;

/// What the host was told already.
#[derive(Debug, Default)]
pub struct Doubts {
    ignored: [bool; Input::ALL.len()],
    /// A step was made: whether the drive has its inputs is known.
    fed: bool,
    /// How often the energies did not balance when they were looked at.
    unbalanced: u64,
}

impl Doubts {
    /// Inputs that were set, and that the source does not read.
    pub fn ignored(&mut self, parameters: &Parameters, inputs: &Inputs) -> Vec<String> {
        let mut told = Vec::new();
        for InputRow { name, input, reader, .. } in &INPUTS {
            let known = &mut self.ignored[*input as usize];
            if inputs.sets(*input) && !*known {
                told.extend(reader.unread(name, parameters).inspect(|_| *known = true));
            }
        }
        told
    }

    /// At the first step: a source that reads inputs of which none was set.
    pub fn starved(&mut self, source: Source, inputs: &Inputs) -> Option<String> {
        let reads = |row: &&InputRow| matches!(row.reader, Reader::Drive(s) if s.contains(&source));
        let needed = || INPUTS.iter().filter(reads).map(|row| row.input);
        let first = !std::mem::replace(&mut self.fed, true);
        if !first || needed().count() == 0 || needed().any(|input| inputs.sets(input)) {
            return None;
        }
        let names: Vec<&str> = needed().map(Input::name).collect();
        let (chosen, names) = (SOURCE.items[source as usize].0, names.join(" or "));
        Some(format!(
            "drive.source is {chosen}, but nothing sets {names}: the piston is not driven"
        ))
    }
}

impl Doubts {
    /// Energies that do not balance, each time that the count of them has doubled.
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

/// Values that look as if they were in another unit.
pub fn of_values(settings: &Settings, inputs: &Inputs) -> Vec<String> {
    let Ok(parameters) = settings.parameters() else { return Vec::new() };
    let (usual, mut started) = (Parameters::default(), inputs.starting());
    let doubt = |(reference, variable): (usize, &Variable)| {
        let (quantity, value, own): (Quantity, f64, f64) = match &variable.role {
            Role::Parameter { slot: slot @ Slot::Real(quantity, _), row, .. }
                if row.reader.reads(&parameters) && !row.switches =>
            {
                (*quantity, settings.get(reference), slot.read(&usual))
            }
            Role::Input { quantity, start, .. } => {
                (*quantity, *start(&mut started), *start(&mut InputValues::default()))
            }
            _ => return None,
        };
        let ratio = (value / own).abs();
        let plain = quantity.unit == "1";
        let likely = (1.0 / SLIP..=SLIP).contains(&ratio);
        if plain || value == 0.0 || own == 0.0 || likely {
            return None;
        }
        let (name, unit) = (variable.name, quantity.unit);
        let [value, own] = [value, own].map(DisplayNumber);
        Some(format!(
            "{name} = {value} {unit} is {} times the reference hammer's {own} {unit}: is the \
             unit right?",
            rounded(ratio)
        ))
    };
    VARIABLES.iter().enumerate().filter_map(doubt).collect()
}

/// To three digits.
fn rounded(ratio: f64) -> DisplayNumber {
    DisplayNumber(format!("{ratio:.2e}").parse().unwrap_or(ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_beyond_rounding_is_told_and_counted() {
        let mut doubts = Doubts::default();
        let fine = Energies { drive: 300.0, kinetic: 300.0, residual: 1e-9, ..Default::default() };
        assert_eq!(doubts.unbalanced(&fine), None);
        let wrong = Energies { residual: -37.0, ..fine };
        let told: Vec<String> = (0..5).filter_map(|_| doubts.unbalanced(&wrong)).collect();
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(told[2].contains("energy_residual = -37 J") && told[2].contains("4 times"));
        let none = Energies { residual: f64::NAN, ..fine };
        assert_eq!((5..8).filter_map(|_| doubts.unbalanced(&none)).count(), 1);
    }
}
