//! Validates and simulates an FMU of either standard with the crate `fmi-rs`, and writes all real
//! outputs as a table.
//!
//!     importer FILE STEP STOP ROWS.csv [NAME=VALUE ...]
//!
//! About half way the state is passed through a file to another instance, which must not show in the table. In FMI
//! 3.0 events are handled and steps may end early. Each event has two rows, before and after it is handled.

#![allow(clippy::arc_with_non_send_sync, reason = "fmi-rs wants its recorder in one")]

use fmi_rs::fmi3::LibraryKind;
use fmi_rs::model_description::{FMIMajorVersion, ValidationError, peek_fmi_major_version};
use fmi_rs::model_description::{fmi2, fmi3};
use fmi_rs::{sim, zip::extract_zip_archive};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// The task.
struct Task {
    /// The unpacked archive.
    folder: PathBuf,
    step: f64,
    stop: f64,
    starts: Vec<(String, String)>,
    rows: PathBuf,
}

/// Half of the simulation, and the file with the state.
struct Half<'a> {
    start: f64,
    stop: f64,
    starts: &'a [(String, String)],
    read: Option<PathBuf>,
    write: Option<PathBuf>,
}

impl Task {
    fn halves(&self) -> [Half<'_>; 2] {
        // fmi-rs 0.3.4 accepts only a duration whose quotient by the step is an exact integer.
        let fits = |span: f64| (span / self.step).fract() < f64::EPSILON;
        let steps = (0.5 * self.stop / self.step).round();
        let middles = (0..steps as u32).map(|less| (steps - f64::from(less)) * self.step);
        let both = |middle: &f64| fits(*middle) && fits(self.stop - middle);
        let middle = middles.clone().find(both).unwrap_or(steps * self.step);
        let file = Some(self.folder.join("state.bin"));
        let (first, second) = ((0.0, middle), (middle, self.stop));
        let half = |(start, stop)| Half { start, stop, starts: &[], read: None, write: None };
        [
            Half { starts: &self.starts, write: file.clone(), ..half(first) },
            Half { read: file, ..half(second) },
        ]
    }
}

fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, step, stop, rows, starts @ ..] = &arguments[..] else {
        return Err("importer FILE STEP STOP ROWS.csv [NAME=VALUE ...]".into());
    };
    let start = |text: &String| {
        let (name, value) = text.split_once('=').ok_or("a start value is NAME=VALUE")?;
        Ok((name.to_owned(), value.to_owned()))
    };
    let unpacked = tempfile::TempDir::new()?;
    extract_zip_archive(file, unpacked.path())?;
    let task = Task {
        folder: unpacked.path().to_owned(),
        step: step.parse()?,
        stop: stop.parse()?,
        starts: starts.iter().map(start).collect::<Outcome<_>>()?,
        rows: rows.into(),
    };
    let description = unpacked.path().join("modelDescription.xml");
    match peek_fmi_major_version(&description)? {
        FMIMajorVersion::V2 => two(&task, &description),
        FMIMajorVersion::V3 => three(&task, &description),
    }
}

fn demand_valid(problems: &[ValidationError]) -> Outcome {
    let texts: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
    if texts.is_empty() { Ok(()) } else { Err(texts.join("\n").into()) }
}

fn two(task: &Task, description: &Path) -> Outcome {
    use fmi2::{Causality, ScalarVariable, VariableType};
    let description = Arc::new(fmi2::ModelDescription::from_path(description)?);
    demand_valid(&description.validate())?;
    let is_read = |variable: &ScalarVariable| {
        variable.causality == Causality::Output
            && matches!(variable.variableType, VariableType::Real { .. })
    };
    let variables = description.modelVariables.iter().enumerate();
    let read: Vec<usize> = variables.filter(|(_, v)| is_read(v)).map(|(index, _)| index).collect();
    let rows = sim::fmi2::Trajectories::new(description.clone(), read);
    let recorder = Arc::new(sim::fmi2::recorder::Recorder::new(rows));
    for half in task.halves() {
        let settings = sim::fmi2::SimulationSettings {
            unzipdir: task.folder.clone(),
            model_description: description.clone(),
            start_time: half.start,
            stop_time: half.stop,
            logging_on: false,
            set_stop_time: false,
            output_interval: task.step,
            log_time_scale: false,
            tolerance: 1e-9,
            set_tolerance: false,
            start_values: half.starts.to_vec(),
            log_fmi_calls: false,
            input_file: None,
            early_return_allowed: false,
            event_mode_used: false,
            log_file: None,
            initial_fmu_state_file: half.read,
            final_fmu_state_file: half.write,
        };
        sim::fmi2::cs::simulate(&settings, None, recorder.clone())?;
    }
    let rows = recorder.trajectories.borrow();
    Ok(sim::fmi2::csv::write_csv(&rows, &task.rows)?)
}

fn three(task: &Task, description: &Path) -> Outcome {
    use fmi3::{Causality, ModelVariable, VariableType};
    let description = Arc::new(fmi3::ModelDescription::from_path(description)?);
    demand_valid(&description.validate())?;
    let is_read = |variable: &ModelVariable| {
        variable.causality == Causality::Output
            && variable.dimensions.is_empty()
            && matches!(variable.variableType, VariableType::Float64 { .. })
    };
    let variables = description.modelVariables.iter().enumerate();
    let read: Vec<usize> = variables.filter(|(_, v)| is_read(v)).map(|(index, _)| index).collect();
    let rows = sim::fmi3::Trajectories::new(description.clone(), read);
    let recorder = Arc::new(sim::fmi3::recorder::Recorder::new(rows));
    for half in task.halves() {
        let settings = sim::fmi3::SimulationSettings {
            unzipdir: task.folder.clone(),
            model_description: description.clone(),
            library_kind: LibraryKind::Native,
            enable_dae: false,
            start_time: half.start,
            stop_time: half.stop,
            visible: false,
            logging_on: false,
            set_stop_time: false,
            output_interval: task.step,
            log_time_scale: false,
            tolerance: 1e-9,
            set_tolerance: false,
            start_values: half.starts.to_vec(),
            log_fmi_calls: false,
            intermediate_update: false,
            input_file: None,
            early_return_allowed: true,
            event_mode_used: true,
            log_file: None,
            initial_fmu_state_file: half.read,
            final_fmu_state_file: half.write,
        };
        sim::fmi3::cs::simulate(&settings, None, recorder.clone())?;
    }
    let rows = recorder.trajectories.borrow();
    Ok(sim::fmi3::csv::write_csv(&rows, &task.rows)?)
}
