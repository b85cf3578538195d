//! Warnings: settings that are allowed but probably not intended.

use crate::numerics::display::DisplayNumber;
use crate::quantities::inputs::{INPUTS, Input, InputRow};
use crate::quantities::parameters::{InputValues, Parameters, Source};
use crate::quantities::quantity::SOURCE;
use crate::variables::{Reader, Role, Slot, VARIABLES, Variable};

/// A value that differs from the reference hammer's by this factor is probably in another unit.
/// Units that are confused differ by a thousand (mm and m, kN and N); real hammers and rocks differ
/// by less.
const SLIP: f64 = 300.0;

/// Values that seem to be in another unit, one sentence each.
pub fn unlikely(parameters: &Parameters, inputs: &InputValues) -> Vec<String> {
    VARIABLES.iter().filter_map(|variable| slip(variable, parameters, *inputs)).collect()
}

fn slip(variable: &Variable, parameters: &Parameters, mut inputs: InputValues) -> Option<String> {
    let (quantity, value, own) = match &variable.role {
        Role::Parameter { slot: slot @ Slot::Real(quantity, _), row, .. }
            if row.reader.reads(parameters) && !row.switches =>
        {
            (*quantity, slot.read(parameters), slot.read(&Parameters::default()))
        }
        Role::Input { quantity, start, .. } => {
            (*quantity, *start(&mut inputs), *start(&mut InputValues::default()))
        }
        _ => return None,
    };
    let ratio = (value / own).abs();
    let likely = (1.0 / SLIP..=SLIP).contains(&ratio);
    if quantity.unit == "1" || value == 0.0 || own == 0.0 || likely {
        return None;
    }
    let (name, unit) = (variable.name, quantity.unit);
    let [value, own] = [value, own].map(DisplayNumber);
    // Rounds to three digits.
    let ratio = DisplayNumber(format!("{ratio:.2e}").parse().unwrap_or(ratio));
    Some(format!(
        "{name} = {value} {unit} is {ratio} times the reference hammer's {own} {unit}: is the \
         unit right?"
    ))
}

/// A drive whose inputs are never set, as a sentence.
pub fn starved(source: Source, sets: impl Fn(Input) -> bool) -> Option<String> {
    let reads = |row: &&InputRow| matches!(row.reader, Reader::Drive(s) if s.contains(&source));
    let empty = |row: &&InputRow| *(row.start)(&mut InputValues::default()) == 0.0;
    let needed = || INPUTS.iter().filter(reads).filter(empty).map(|row| row.input);
    if needed().count() == 0 || needed().any(sets) {
        return None;
    }
    let names: Vec<&str> = needed().map(Input::name).collect();
    let (chosen, names) = (SOURCE.items[source as usize].0, names.join(" or "));
    Some(format!("drive.source is {chosen}, but nothing sets {names}: the piston is not driven"))
}
