//! The same by FMI 3.0, with event mode and early return: a row at each communication point, and
//! one at each event, whose first number is the time.

use fmi::EventFlags;
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance::InstanceCS;
use fmi::fmi3::schema::{AbstractVariableTrait, ArrayableVariableTrait, Causality};
use fmi::fmi3::{CoSimulation, Common, Fmi3Model, GetSet};
use fmi::traits::FmiImport;
use std::error::Error;

pub fn run(file: &str, step: f64, steps: u32, starts: &[String]) -> Result<(), Box<dyn Error>> {
    let import: Fmi3Import = fmi::import::from_path(file)?;
    let variables = import.model_description().model_variables.float64();
    let (names, references): (Vec<&str>, Vec<u32>) = variables
        .iter()
        .filter(|variable| variable.causality() == Causality::Output)
        .filter(|variable| variable.dimensions().is_empty())
        .map(|variable| (variable.name(), variable.value_reference()))
        .unzip();

    let mut instance = import.instantiate_cs("hammer", false, false, true, true, &[])?;
    for start in starts {
        let (name, value) = start.split_once('=').ok_or("a start value is NAME=VALUE")?;
        let variable = variables.iter().find(|variable| variable.name() == name);
        let reference = variable.ok_or(format!("no variable {name}"))?.value_reference();
        instance.set_float64(&[reference], &[value.parse()?])?;
    }
    instance.enter_initialization_mode(None, 0.0, None)?;
    instance.exit_initialization_mode()?;
    instance.update_discrete_states(&mut EventFlags::default())?;
    instance.enter_step_mode()?;

    println!("time,{}", names.join(","));
    print_row(&mut instance, 0.0, &references)?;
    let mut time = 0.0;
    for number in 1..=steps {
        let point = f64::from(number) * step;
        loop {
            let ([mut event, mut end, mut early], mut reached) = ([false; 3], time);
            let size = point - time;
            instance.do_step(time, size, true, &mut event, &mut end, &mut early, &mut reached)?;
            time = reached;
            print_row(&mut instance, time, &references)?;
            if event {
                instance.enter_event_mode()?;
                instance.update_discrete_states(&mut EventFlags::default())?;
                instance.enter_step_mode()?;
            }
            if !early {
                break;
            }
        }
    }
    instance.terminate()?;
    Ok(())
}

fn print_row(
    instance: &mut InstanceCS,
    time: f64,
    references: &[u32],
) -> Result<(), Box<dyn Error>> {
    let mut values = vec![0.0; references.len()];
    instance.get_float64(references, &mut values)?;
    let texts: Vec<String> = std::iter::once(time).chain(values).map(|v| v.to_string()).collect();
    println!("{}", texts.join(","));
    Ok(())
}
