//! Altered states: a changed number in a stored state leads to a motion or a named error, and no step takes more work
//! than its budget.

use crate::scenes::one_in;
use hammer::Joint;
use hammer::{
    Counters, Error, Fidelity, Input, InputValues, Machine, Parameters, Segment, Source, State,
};
use serde_json::Value;

/// Largest work of a step with an allowance of one second: 375 million coordinates, of which a unit takes at least
/// 20, and the work of one guard between two checks, 64 windows of 4096 steps each.
const BUDGET: u64 = 375_000_000 / 20 + 64 * 4096;

/// Evaluations, rotations and windows, from the counters.
fn work(counters: Counters) -> u64 {
    counters.guard_evaluations + counters.samples + counters.scans + 16 * counters.windows
}

/// Values that replace a number of the state.
const STRANGE: [f64; 8] = [0.0, -1.0, 1e300, -1e300, 1e-300, 1e6, 1e9, -0.3];

/// Replaces number `place` of all numbers in `value` by `strange` plus the number times `factor`. Returns false if
/// there are fewer numbers.
fn alter(value: &mut Value, place: &mut usize, strange: f64, factor: f64) -> bool {
    match value {
        Value::Number(number) => {
            if *place > 0 {
                *place -= 1;
                return false;
            }
            // An integer stays an integer, since nothing else can be read back.
            let strange = strange + factor * number.as_f64().unwrap_or_default();
            *value = if number.is_f64() { strange.into() } else { (strange.abs() as u64).into() };
            true
        }
        Value::Array(items) => items.iter_mut().any(|item| alter(item, place, strange, factor)),
        Value::Object(items) => items.values_mut().any(|item| alter(item, place, strange, factor)),
        _ => false,
    }
}

/// Scenes in which contacts, rock and drive are active, each at an instant after its last event: two bodies with
/// every drive, in a casing whose bit may hang on the ring and vent the drive, and with loose rods.
fn scene(fidelity: Fidelity, source: Source, around: Around) -> Machine {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    (p.mesh.degree, p.piston.elements, p.bit.elements, p.drive.source) = (1, 2, 2, source);
    p.work_limit = 1;
    match around {
        Around::Nothing => (),
        Around::Casing => {
            (p.casing.mass, p.casing.impedance) = (40.0, 4e3);
            (p.chuck.travel, p.chuck.idle_travel) = (2e-3, 1e-3);
        }
        Around::LooseRods => {
            (p.mesh.degree, p.piston.elements, p.bit.elements) = (3, 4, 14);
            p.drill.rods = 1;
            (p.drill.shank, p.drill.rod) =
                ([0.4, 0.5].map(|length| Segment { length, area: 1e-3 })).into();
            p.drill.joint = Joint { stiffness: 1e10, slack: 1e-4 };
        }
    }
    let inputs = InputValues::default();
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.advance(0.02).expect("a step");
    if source == Source::Force {
        machine.set_input(Input::DriveForce, &[2e3, -1e5, 3e6]).expect("a force that varies");
    }
    machine.advance(0.02125).expect("a step");
    machine
}

/// Its state in stored form.
fn written(machine: &Machine) -> Value {
    serde_json::to_value(machine.state()).expect("a state in JSON")
}

/// Surroundings of piston and bit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Around {
    Nothing,
    Casing,
    LooseRods,
}

/// Only every thirteenth number is altered. It is prime, so that over the numbers each alteration meets each kind.
const EVERY: usize = 13;

/// Each number of a state in turn is replaced, by a distant value, and by one so near that all checks of that number
/// alone pass. The machine then advances, its balance can be read, and nothing exceeds its budget.
#[test]
fn an_altered_state_ends_in_motion_or_a_named_error_within_its_budget() {
    let (mut ends, mut tries) = ([0; 4], 0);
    for (fidelity, source, around) in [
        (Fidelity::Rigid, Source::Air, Around::Nothing),
        (Fidelity::Elastic, Source::Air, Around::Casing),
        (Fidelity::Elastic, Source::Relay, Around::Nothing),
        (Fidelity::Elastic, Source::Relay, Around::Casing),
        (Fidelity::Elastic, Source::Force, Around::LooseRods),
    ] {
        let machine = scene(fidelity, source, around);
        let honest = written(&machine);
        let mut other = scene(fidelity, source, around);
        for place in (0..).step_by(one_in(EVERY)) {
            let near = [1.0 + 1e-9, 0.999, 1.1, -1.0][place % 4];
            for (strange, factor) in [(STRANGE[place % STRANGE.len()], 0.0), (0.0, near)] {
                let mut forged = honest.clone();
                if !alter(&mut forged, &mut place.clone(), strange, factor) {
                    break;
                }
                tries += 1;
                let end = tried(
                    &mut other,
                    forged,
                    &format!("{source:?} {around:?} {place} {strange} {factor}"),
                );
                ends[end] += 1;
            }
            if !alter(&mut honest.clone(), &mut place.clone(), 0.0, 0.0) {
                assert!(place > 200, "only {place} numbers");
                break;
            }
        }
    }
    let [_, moved, overwork, refused] = ends;
    assert!(moved > 250 && overwork > 0 && refused > 25, "{ends:?}");
    println!("{tries} altered states: unreadable, moved, too much work, refused: {ends:?}");
}

/// Result of a step from an altered state: it cannot be read, it moves, it takes too much work, it is refused.
fn tried(machine: &mut Machine, forged: Value, name: &str) -> usize {
    let Ok(state) = serde_json::from_value::<State>(forged) else { return 0 };
    let before = work(machine.counters());
    let restored = machine.restore(&state);
    let (from, read) = (machine.time(), work(machine.counters()));
    let stepped = restored.and_then(|()| machine.advance(from + 0.02));
    let stepping = work(machine.counters()).saturating_sub(read);
    assert!(
        read.saturating_sub(before) <= BUDGET && stepping <= BUDGET,
        "{name}: {stepping} units"
    );
    machine.kinematics();
    assert!(machine.time() >= from, "{name}: time runs backwards");
    match stepped {
        Ok(()) => {
            assert_eq!(machine.time(), from + 0.02, "{name}");
            machine.energies();
            1
        }
        Err(Error::Overwork { .. }) => 2,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            3
        }
    }
}

/// A state whose present is beyond its next event would turn time back. It is refused, and the scene is not changed.
#[test]
fn a_state_whose_present_lies_beyond_its_next_event_is_refused() {
    for source in [Source::Relay, Source::Air] {
        let mut machine = scene(Fidelity::Elastic, source, Around::Nothing);
        let before = machine.state();
        let honest = serde_json::to_value(&before).expect("a state in JSON");
        // The hammer strikes within 25 ms of any instant.
        let mut forged = honest.clone();
        for place in ["/motion/now", "/motion/time"] {
            let value = forged.pointer_mut(place).expect("a number");
            *value = (value.as_f64().expect("a number") + 0.025).into();
        }
        let state = serde_json::from_value(forged).expect("a state");
        assert!(matches!(machine.restore(&state), Err(Error::Corrupt { .. })), "{source:?}");
        assert_eq!(machine.state(), before);
        machine.advance(0.03).expect("goes on where it was");
    }
}

/// Past events must be in the past: a blow in the future would have a negative period.
#[test]
fn a_state_whose_past_is_to_come_is_refused() {
    let machine = scene(Fidelity::Rigid, Source::Relay, Around::Nothing);
    let honest = written(&machine);
    let mut other = scene(Fidelity::Rigid, Source::Relay, Around::Nothing);
    let places = [
        "/history/blows/last/time",
        "/history/blows/milestones/0/time",
        "/history/blows/milestones/1/time",
        "/history/blows/way/began",
        "/history/blows/collision",
        "/history/blows/opened",
        "/history/zeno/burst_start",
    ];
    for place in places {
        let mut forged = honest.clone();
        let value = forged.pointer_mut(place).unwrap_or_else(|| panic!("{place}: {honest}"));
        assert!(alter(value, &mut 0, machine.time() + 1e-3, 0.0), "{place}");
        let state = serde_json::from_value(forged).expect("a state");
        assert!(matches!(other.restore(&state), Err(Error::Corrupt { .. })), "{place}");
    }
    let state = serde_json::from_value(honest).expect("a state");
    other.restore(&state).expect("as it was written");
}

/// The host's time of an event is rounded, so a state may be named a little before it. Time is not turned back then.
#[test]
fn a_state_that_is_named_before_its_event_stands_at_it() {
    let machine = scene(Fidelity::Elastic, Source::Relay, Around::Nothing);
    let mut state = written(&machine);
    let epoch = state["motion"]["epoch"]["high"].as_f64().expect("a number");
    let named = epoch - 1e-12 * (1.0 + 0.9 * epoch);
    let place = |state: &mut Value, place: &str, value: f64| {
        *state.pointer_mut(place).unwrap_or_else(|| panic!("{place}")) = value.into();
    };
    place(&mut state, "/motion/time", named);
    place(&mut state, "/motion/now", 0.0);
    place(&mut state, "/history/peaks/start", 0.0);
    let mut other = scene(Fidelity::Elastic, Source::Relay, Around::Nothing);
    let state = serde_json::from_value(state).expect("a state");
    other.restore(&state).expect("within the rounding");
    let before = other.kinematics().relative.displacement;
    other.advance(named).expect("no step");
    // Motion at 1 m/s for 1e-12 s, and the forces of a blow.
    let moved = other.kinematics().relative.displacement - before;
    assert!(moved.abs() < 1e-11, "{moved:e}");
    other.advance(epoch + 1e-3).expect("a step");
}
