//! The layout of a stored state, compared with the last one's (`state_layout.txt`), so that no changed field is read from
//! older bytes. `STATE_LAYOUT=write cargo test -p dth-hammer --test all state_layout` writes it anew.

use crate::scenes::cased;
use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source, State};

/// A part of JSON between two commas with the kind of its number in place of the number.
fn kind(part: &str) -> String {
    let from = part.rfind([':', '[']).map_or(0, |at| at + 1);
    let number = part[from..].trim_end_matches([']', '}']);
    match (number.parse::<i64>(), number.parse::<f64>()) {
        (Ok(_), _) => part.replace(number, "whole"),
        (_, Ok(_)) => part.replace(number, "real"),
        _ => part.into(),
    }
}

/// A state in the middle of a step, under an input over time.
fn layout(parameters: &Parameters) -> Vec<String> {
    let inputs = InputValues { drive_force: 1800.0, ..InputValues::default() };
    let mut machine = Machine::new(parameters, &inputs, 0.0).expect("a scene");
    machine.take_blows();
    machine.advance(0.025).expect("a blow");
    machine.set_input(Input::FeedForce, &[5e3, 1e4]).expect("an input");
    machine.advance(0.0251).expect("a step");
    let json = serde_json::to_string(&machine.state()).expect("a state in JSON");
    let mut lines: Vec<String> = json.split(',').map(kind).collect();
    lines.dedup(); // A list or a tuple of many numbers.
    lines
}

#[test]
fn a_state_is_stored_as_its_format_says() {
    let (mut line, mut air) = (cased(), Parameters::default());
    (line.drive.source, line.drive.impedance, line.drive.delay) = (Source::Force, 1e3, 0.5);
    air.drive.source = Source::Air;
    let rigid = Parameters { fidelity: Fidelity::Rigid, ..air };
    let lines = [layout(&line), layout(&air), layout(&rigid)].concat().join("\n");
    let layout = format!("format {}\n{lines}\n", State::FORMAT);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/state_layout.txt");
    let stored = std::fs::read_to_string(path).unwrap_or_default();
    if std::env::var("STATE_LAYOUT").is_ok_and(|what| what == "write") && stored != layout {
        assert_ne!(stored.lines().next(), layout.lines().next(), "raise State::FORMAT first");
        return std::fs::write(path, layout).expect("a file");
    }
    assert!(layout == stored, "changed: raise State::FORMAT, and write state_layout.txt anew");
}
