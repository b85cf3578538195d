//! The table of parameters agrees with the engine.

use crate::scenes::one_in;
use hammer::variables::{PARAMETERS, Parameter, Slot};
use hammer::{Domain, Fidelity, InputValues, Machine, Parameters, Record, Source};
use std::collections::BTreeSet;

/// A value of the domain that differs from the start value.
fn other(row: &Parameter) -> f64 {
    let usual = row.slot.read(&Parameters::default());
    match row.domain {
        Domain::Between(low, high) => {
            if usual < high {
                (usual + 1.0).min(high)
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
    (machine.take_journal(), machine.kinematics().tip.displacement)
}

/// Scenes of every source of the drive, of rigid and elastic bodies with and without sections.
fn scenes() -> Vec<Parameters> {
    let scene = |(k, source): (usize, Source)| {
        let mut p = Parameters::default();
        (p.drive.source, p.contact.initial_gap) = (source, 0.005);
        (p.piston.elements, p.bit.elements) = (4, 4);
        p.fidelity = Fidelity::ALL[k % 2];
        p.piston.segments.set_count([0, 2, 0, 3, 0][k]);
        p.bit.segments.set_count([0, 2, 2, 0, 0][k]);
        p
    };
    Source::ALL.into_iter().enumerate().map(scene).collect()
}

/// No bit changes. A scene that reads all of them would notice.
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
            let prefix = format!("{} is ignored: ", row.name);
            let warnings =
                Machine::new(&changed, &InputValues::default(), 0.0).expect("a scene").warnings();
            assert!(warnings.iter().any(|line| line.starts_with(&prefix)), "{warnings:?}");
            ignored.insert(row.name);
        }
    }
    assert!(ignored.len() > 60, "{}", ignored.len());
}

/// No other parameter is reported as ignored.
#[test]
fn a_parameter_that_is_read_is_not_told_to_be_ignored() {
    for scene in scenes() {
        for row in PARAMETERS.iter().filter(|row| row.reader.reads(&scene)) {
            let mut changed = scene;
            row.slot.write(&mut changed, other(row));
            let prefix = format!("{} is ignored: ", row.name);
            let lines: Vec<String> = PARAMETERS.iter().filter_map(|r| r.unread(&changed)).collect();
            assert!(!lines.iter().any(|line| line.starts_with(&prefix)), "{lines:?}");
        }
    }
}

/// A row writes what it reads, and no two rows write to the same place.
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
        if row.tunable {
            assert_eq!(done, Ok(()), "{}", row.name);
            assert_eq!(*machine.parameters(), wanted);
        } else {
            let refused = done.expect_err(row.name).to_string();
            assert!(refused.starts_with(row.name) && refused.contains("fixed"), "{refused}");
            assert_eq!(*machine.parameters(), Parameters::default());
        }
    }
}

/// Numbers at the ends of a parameter's domain and of its magnitudes, beyond them, and between.
fn extremes(row: &Parameter) -> Vec<f64> {
    let usual = row.slot.read(&Parameters::default());
    let mut values = vec![0.0, 1e-300, -1e-300, 1e300, -usual, 1e-6 * usual, 1e6 * usual];
    if let Slot::Real(quantity, _) = row.slot {
        let [least, most] = quantity.magnitudes;
        values.extend([least, most, -most, (least * most).sqrt(), 1e3 * least, 1e-3 * most]);
    }
    match row.domain {
        Domain::Between(low, high) => values.extend([low, high, 0.5 * (low + high)]),
        Domain::AtLeast(low) | Domain::Above(low) => values.extend([low, low + f64::EPSILON]),
        Domain::Any => values.push(f64::MAX),
    }
    values
}

/// Each parameter is set nearly to zero, to huge values, and to the ends of its domain, with all drives, with a
/// casing and without. The scene is refused at its start by the parameter's name, or moves so that its energies
/// balance and slicing changes no bit; an error on the way gives its reason.
#[test]
fn extreme_parameters_are_refused_by_name_or_right() {
    let mut ends = [0; 3];
    for (mut scene, around) in scenes().into_iter().zip(0..) {
        scene.work_limit = 1;
        if around % 2 == 1 {
            (scene.casing.mass, scene.chuck.travel) = (30.0, 1e-3);
        }
        let reals = PARAMETERS.iter().filter(|row| matches!(row.slot, Slot::Real(..)));
        for row in reals.filter(|row| row.reader.reads(&scene)) {
            // Each drive tests one of four values, so that each value is tested with some drive.
            for value in extremes(row).into_iter().skip(around % one_in(4)).step_by(one_in(4)) {
                let mut p = scene;
                row.slot.write(&mut p, value);
                if row.slot.read(&p) != value {
                    continue;
                }
                let inputs = InputValues {
                    drive_pressure: 1.2e6,
                    drive_force: 1800.0,
                    ..Default::default()
                };
                let name = format!("{:?}: {} = {value:e}", p.drive.source, row.name);
                let mut whole = match Machine::new(&p, &inputs, 0.0) {
                    Ok(machine) => machine,
                    Err(error) => {
                        let text = error.to_string();
                        let named = PARAMETERS.iter().any(|row| text.contains(row.name));
                        // The error names the body if one of its sections differs too much from the others.
                        assert!(
                            named || text.contains("sections differ too much"),
                            "{name}: {text}"
                        );
                        ends[0] += 1;
                        continue;
                    }
                };
                let done = whole.advance(0.012);
                // How far a call gets within its limit of work depends on where it began.
                if matches!(done, Err(hammer::Error::Overwork { .. })) {
                    ends[1] += 1;
                    continue;
                }
                let mut sliced = Machine::new(&p, &inputs, 0.0).expect("the same");
                let slices = (1..=8).try_for_each(|k| sliced.advance(0.0015 * f64::from(k)));
                assert_eq!(slices, done, "{name}");
                if done.is_err() {
                    ends[1] += 1;
                    continue;
                }
                let states = [&whole, &sliced].map(|machine| machine.state().without_step());
                assert!(states[0] == states[1], "{name}: sliced otherwise, it moves otherwise");
                let energies = whole.energies();
                assert!(
                    energies.residual.abs() <= energies.residual_bound(),
                    "{name}: {energies:?}"
                );
                ends[2] += 1;
            }
        }
    }
    println!("refused at the start, on the way, right: {ends:?}");
    assert!(ends[0] > 100 && ends[2] > 160, "{ends:?}");
}
