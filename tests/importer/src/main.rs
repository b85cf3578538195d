//! Simulates an FMU by the `fmi` crate, and prints all Real outputs as a table.
//!
//!     importer FILE STEP STEPS [NAME=VALUE ...]
//!     importer 3 FILE STEP STEPS [NAME=VALUE ...]     # of FMI 3.0: see `three.rs`
//!
//! Half way it takes the state, steps on, and goes back: by the state that it holds and by
//! one that went through bytes. The table must not show it.

mod three;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::{Causality, ScalarVariableElement};
use fmi::traits::{FmiImport, FmiStatus};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let of_three = arguments.first().is_some_and(|first| first == "3");
    let [file, step, steps, starts @ ..] = &arguments[usize::from(of_three)..] else {
        return Err("importer [3] FILE STEP STEPS [NAME=VALUE ...]".into());
    };
    let (step, steps) = (step.parse::<f64>()?, steps.parse::<u32>()?);
    if of_three {
        return three::run(file, step, steps, starts);
    }
    let import: Fmi2Import = fmi::import::from_path(file)?;
    let variables = &import.model_description().model_variables.variables;
    let (names, references): (Vec<&str>, Vec<u32>) = variables
        .iter()
        .filter(|variable| variable.causality == Causality::Output)
        .filter(|variable| matches!(variable.elem, ScalarVariableElement::Real(_)))
        .map(|variable| (variable.name.as_str(), variable.value_reference))
        .unzip();

    let mut instance = import.instantiate_cs("hammer", false, true)?;
    instance.setup_experiment(None, 0.0, None)?;
    for start in starts {
        let (name, value) = start.split_once('=').ok_or("a start value is NAME=VALUE")?;
        let variable = variables.iter().find(|variable| variable.name == name);
        let reference = variable.ok_or(format!("no variable {name}"))?.value_reference;
        instance.set_real(&[reference], &[value.parse()?])?;
    }
    instance.enter_initialization_mode()?;
    instance.exit_initialization_mode()?;

    println!("{}", names.join(","));
    print_row(&mut instance, &references)?;
    for number in 0..steps {
        let time = f64::from(number) * step;
        if number == steps / 2 {
            go_there_and_back(&mut instance, time, step)?;
        }
        instance.do_step(time, step, true)?;
        print_row(&mut instance, &references)?;
    }
    instance.terminate()?;
    Ok(())
}

fn go_there_and_back(
    instance: &mut InstanceCS,
    time: f64,
    step: f64,
) -> Result<(), Box<dyn Error>> {
    let held = instance.get_fmu_state()?;
    let bytes = instance.serialize_fmu_state(&held)?;
    let read = instance.deserialize_fmu_state(&bytes)?;
    for state in [held, read] {
        instance.do_step(time, step, true)?;
        instance.set_fmu_state(&state).ok()?;
    }
    Ok(())
}

fn print_row(instance: &mut InstanceCS, references: &[u32]) -> Result<(), Box<dyn Error>> {
    let mut values = vec![0.0; references.len()];
    instance.get_real(references, &mut values)?;
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    println!("{}", texts.join(","));
    Ok(())
}
