//! The one table: what it says of a parameter is true of the engine.

use hammer::variables::{Change, PARAMETERS, Parameter, Slot, VARIABLES};
use hammer::{Domain, Fidelity, Input, InputValues, Machine, Parameters, Record, Source};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A value of the domain that differs from the start value.
fn other(row: &Parameter) -> f64 {
    let usual = row.slot.read(&Parameters::default());
    match row.domain {
        Domain::Between(low, high) => {
            if usual < high {
                usual + 1.0
            } else {
                low
            }
        }
        _ if usual == 0.0 => 1.0,
        _ => 1.25 * usual,
    }
}

fn motion(parameters: &Parameters) -> (Vec<Record>, f64) {
    let inputs = InputValues { drive_force: 1800.0, drive_pressure: 1.2e6, ..Default::default() };
    let mut machine = Machine::new(parameters, &inputs, 0.0).expect("a scene");
    machine.keep_journal(true);
    machine.advance(0.02).expect("a run");
    (machine.take_journal(), machine.kinematics().bit_tip_position)
}

/// Scenes of every source of the drive, of rigid and elastic bodies with and without sections.
fn scenes() -> Vec<Parameters> {
    let scene = |(k, source): (usize, Source)| {
        let mut p = Parameters::default();
        (p.drive.source, p.contact.initial_gap) = (source, 0.005);
        (p.piston.elements, p.bit.elements) = (4, 4);
        p.fidelity = Fidelity::ALL[k % 2];
        (p.piston.segments, p.bit.segments) = ([0, 2, 0, 3][k], [0, 2, 2, 0][k]);
        p
    };
    Source::ALL.into_iter().enumerate().map(scene).collect()
}

/// To the last bit; and a scene that does read them all would notice.
#[test]
fn a_parameter_that_is_not_read_changes_nothing() {
    let mut ignored = BTreeSet::new();
    for scene in scenes() {
        let as_it_is = motion(&scene);
        assert!(as_it_is.0.len() > 3, "{} events", as_it_is.0.len());
        for row in PARAMETERS.iter().filter(|row| !row.reader.reads(&scene)) {
            let mut changed = scene;
            row.slot.write(&mut changed, other(row));
            assert_ne!(changed, scene, "{}", row.name);
            assert_eq!(motion(&changed), as_it_is, "{}", row.name);
            let told = format!("{} is ignored: ", row.name);
            let warnings =
                Machine::new(&changed, &InputValues::default(), 0.0).expect("a scene").warnings();
            assert!(warnings.iter().any(|line| line.starts_with(&told)), "{warnings:?}");
            ignored.insert(row.name);
        }
    }
    assert!(ignored.len() > 60, "{}", ignored.len());
}

/// Nor is any other told of.
#[test]
fn a_parameter_that_is_read_is_not_told_to_be_ignored() {
    for scene in scenes() {
        for row in PARAMETERS.iter().filter(|row| row.reader.reads(&scene)) {
            let mut changed = scene;
            row.slot.write(&mut changed, other(row));
            let told = format!("{} is ignored: ", row.name);
            let lines: Vec<String> = PARAMETERS.iter().filter_map(|r| r.unread(&changed)).collect();
            assert!(!lines.iter().any(|line| line.starts_with(&told)), "{lines:?}");
        }
    }
}

/// A row writes where it reads, and no two rows write to one place.
#[test]
fn each_parameter_has_a_place_of_its_own() {
    for row in PARAMETERS.iter() {
        let (usual, mut changed) = (Parameters::default(), Parameters::default());
        row.slot.write(&mut changed, other(row));
        for known in PARAMETERS.iter() {
            let differs = known.slot.read(&changed) != known.slot.read(&usual);
            assert_eq!(differs, known.name == row.name, "{} by {}", known.name, row.name);
        }
    }
}

#[test]
fn only_a_tunable_parameter_may_change_on_the_way() {
    for row in PARAMETERS.iter() {
        let mut machine =
            Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
        machine.advance(1e-3).expect("a step");
        let mut wanted = Parameters::default();
        row.slot.write(&mut wanted, other(row));
        let done = machine.retune(&wanted);
        if row.change == Change::Tunable {
            assert_eq!(done, Ok(()), "{}", row.name);
            assert_eq!(*machine.parameters(), wanted);
        } else {
            let refused = done.expect_err(row.name).to_string();
            assert!(refused.starts_with(row.name) && refused.contains("fixed"), "{refused}");
            assert_eq!(*machine.parameters(), Parameters::default());
        }
    }
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            rust_files(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            found.push(entry);
        }
    }
}

/// The table is one: outside their row, no code of the engine or of the face spells a variable's
/// name. So a tunable parameter is its field, its start value and its row, an output its value and
/// its row.
#[test]
fn a_name_stands_in_its_row_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    rust_files(&root.join("src"), &mut files);
    rust_files(&root.join("../src"), &mut files);
    let texts: Vec<String> =
        files.iter().map(|file| fs::read_to_string(file).expect("a file")).collect();
    let code: Vec<&str> =
        texts.iter().map(|t| t.split("#[cfg(test)]").next().unwrap_or_default()).collect();
    for variable in VARIABLES.iter() {
        let quoted = format!("\"{}\"", variable.name);
        let places = |text: &&str| text.matches(&quoted).count();
        let count: usize = code.iter().map(places).sum();
        let made = variable.name.contains(".segment[") || variable.name.starts_with("chambers.");
        assert_eq!(count, usize::from(!made), "{quoted}");
    }
    assert!(Input::ALL.iter().all(|input| VARIABLES.iter().any(|v| v.name == input.name())));
    let real = |row: &&Parameter| matches!(row.slot, Slot::Real(..));
    assert!(PARAMETERS.iter().filter(real).count() > 60);
}
