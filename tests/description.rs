//! The description: the interface that hosts rely on. The library's exports and imports are checked when it is
//! packaged.

use dth_hammer::{GUID, MODEL_DESCRIPTION, MODEL_DESCRIPTION_3, TOKEN, description, description3};
use hammer::variables::{Role, VARIABLES};
use std::collections::BTreeSet;

/// Names that hosts rely on, beside those that `tests/python/test_interface.py` has with their types: more may be added,
/// none may be removed.
const PROMISED: &str = "
    mesh.degree piston.segments bit.segments piston.segment[1].length piston.segment[8].area
    bit.segment[1].area bit.segment[8].length blow.minimum_speed hole.diameter
    rock.specific_energy rock.reloading drilled_length casing.mass casing.impedance
    chuck.stiffness chuck.viscosity chuck.travel chuck.idle_travel casing_position
    casing_velocity chuck_force chuck_force_peak coupling.delay drive.impedance energy_exchange
    drive_volume return_volume drive_flow return_flow drive_flow_mean return_flow_mean
    drive_line_pressure return_line_pressure";

const TUNABLE: [&str; 8] = [
    "coupling.delay",
    "rock.stiffness",
    "rock.unloading_ratio",
    "rock.viscosity",
    "rock.energy_barrier",
    "drive.amplitude",
    "rock.specific_energy",
    "rock.specific_energy_factor",
];

#[test]
fn the_committed_copies_are_fresh() {
    let two = description::describe();
    assert!(
        MODEL_DESCRIPTION == two && MODEL_DESCRIPTION_3 == description3::describe(&two),
        "refresh them with `cargo describe`"
    );
    assert!(MODEL_DESCRIPTION.contains(&format!("guid=\"{GUID}\"")) && GUID.len() == 36);
    assert!(MODEL_DESCRIPTION_3.contains(&format!("Token=\"{TOKEN}\"")) && TOKEN.len() == 36);
}

#[test]
fn promised_names_are_there_once() {
    let names: Vec<&str> = VARIABLES.iter().map(|variable| variable.name).collect();
    let unique: BTreeSet<&str> = names.iter().copied().collect();
    assert_eq!(unique.len(), names.len());
    for name in PROMISED.split_whitespace() {
        assert!(unique.contains(name), "{name}");
    }
}

/// A harness that keeps a number reads the same port in the next version: names are added at the end, and none moves.
/// The checksum is that of the first numbers that were promised; it is raised with their count, at a release alone.
#[test]
fn a_value_reference_is_a_names_for_ever() {
    let names: String = VARIABLES.iter().map(|variable| format!("{}\n", variable.name)).collect();
    let promised: usize = names.split_inclusive('\n').take(183).map(str::len).sum();
    assert_eq!(crc32fast::hash(&names.as_bytes()[..promised]), 0xd6567d1a);
    for (place, row) in VARIABLES.iter().enumerate() {
        let listed = format!("<ScalarVariable name=\"{}\" valueReference=\"{place}\"", row.name);
        assert!(MODEL_DESCRIPTION.contains(&listed), "{listed}");
        let listed = format!(" name=\"{}\" valueReference=\"{place}\"", row.name);
        assert!(MODEL_DESCRIPTION_3.contains(&listed), "{listed}");
    }
}

#[test]
fn parameters_have_dotted_names_and_ports_flat_ones() {
    for variable in VARIABLES.iter() {
        let port = matches!(variable.role, Role::Input(_) | Role::Output(_));
        assert!(!(port && variable.name.contains('.')), "{}", variable.name);
        let tunable = matches!(variable.role, Role::Parameter(row) if row.tunable);
        assert_eq!(tunable, TUNABLE.contains(&variable.name), "{}", variable.name);
    }
}

#[test]
fn a_declared_minimum_is_allowed_itself() {
    let mut found = 0;
    for variable in VARIABLES.iter() {
        let begin = format!("<ScalarVariable name=\"{}\"", variable.name);
        let row = MODEL_DESCRIPTION.split(&begin).nth(1).unwrap();
        let row = row.split("</ScalarVariable>").next().unwrap();
        let (Some(domain), Some(text)) = (variable.domain(), row.split(" min=\"").nth(1)) else {
            continue;
        };
        let least: f64 = text.split('"').next().unwrap().parse().unwrap();
        assert!(domain.contains(least), "{}: {least:e}", variable.name);
        // `std::stod` of C++ throws at a subnormal number, so the least normal one stands for it.
        assert!(!least.is_subnormal(), "{}: {least:e}", variable.name);
        let below = if least == f64::MIN_POSITIVE { 0.0 } else { least.next_down() };
        assert!(!domain.contains(below), "{}: {least:e} is not least", variable.name);
        found += 1;
    }
    assert!(found > 20, "{found}");
}

/// Importers of past years crash if an initial unknown lacks its dependencies, or if an enumeration type has a
/// description.
#[test]
fn initial_unknowns_write_out_on_what_they_depend() {
    for (text, row) in [(MODEL_DESCRIPTION, "<Unknown "), (MODEL_DESCRIPTION_3, "<InitialUnknown ")]
    {
        let from = text.find("<InitialUnknown").unwrap();
        let rows: Vec<&str> = text[from..].split(row).skip(1).collect();
        assert!(rows.len() > 50);
        let number = |part: &str| part.split('"').nth(1).unwrap().parse::<u32>().unwrap();
        assert!(rows.is_sorted_by_key(|row| number(row)));
        let known = rows.iter().map(|row| row.split("dependencies=\"").nth(1).unwrap());
        let counts: Vec<usize> =
            known.map(|rest| rest.split('"').next().unwrap().split_whitespace().count()).collect();
        let all =
            VARIABLES.iter().filter(|row| matches!(row.role, Role::Parameter(_) | Role::Input(_)));
        let all = all.count();
        assert!(counts.iter().all(|count| [0, all].contains(count)), "{counts:?}");
        assert!(counts.contains(&0) && counts.contains(&all));
    }
    let types = MODEL_DESCRIPTION_3.split("<EnumerationType ").skip(1);
    assert!(types.clone().count() >= 4);
    assert!(
        types
            .map(|rest| &rest[..rest.find('>').unwrap()])
            .all(|head| !head.contains("description"))
    );
}
