//! Actions without effect: inputs that are set again, and saving and restoring by a host. (For slicing of time see
//! the properties of drawn scenes.)

use hammer::{Input, InputValues, Machine, Parameters, Source, State, Stops};

fn machine() -> Machine {
    Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene")
}

/// The state without the part that belongs to the last step.
fn trajectory(machine: &Machine) -> State {
    machine.state().without_step()
}

#[test]
fn a_state_of_another_scene_is_refused_and_nothing_changes() {
    let mut parameters = Parameters::default();
    parameters.bit.elements = 3;
    let small = Machine::new(&parameters, &InputValues::default(), 0.0).expect("a scene");
    // The state of the small scene under the parameters of the large one.
    let mut forged = serde_json::to_value(small.state()).expect("a state in JSON");
    forged["parameters"] = serde_json::to_value(Parameters::default()).expect("parameters");
    let state: State = serde_json::from_value(forged).expect("a state");
    let mut machine = machine();
    machine.advance(0.02).expect("a step");
    let before = machine.state();
    assert!(machine.restore(&state).is_err());
    assert_eq!(machine.state(), before);
}

/// Setting an input to its own value must not change the trajectory. Setting it to its polynomial's own continuation
/// changes it by rounding only (1e-12 of 10 m/s, over a touch).
#[test]
fn an_input_set_to_its_own_value_costs_nothing() {
    let mut parameters = Parameters::default();
    parameters.drive.source = Source::Force;
    let inputs = InputValues { drive_force: 1500.0, ..Default::default() };
    let mut quiet = Machine::new(&parameters, &inputs, 0.0).expect("a scene");
    let mut repeated = Machine::new(&parameters, &inputs, 0.0).expect("a scene");
    for i in 1..=40 {
        let t = f64::from(i) * 1e-3;
        repeated.set_input(Input::DriveForce, &[1500.0]).expect("an input");
        repeated.advance(t).expect("a step");
        quiet.advance(t).expect("a step");
    }
    assert_eq!(trajectory(&repeated), trajectory(&quiet));
}

/// A force of degree 3 in time over 12 ms, before the first impact: momentum in closed form, to some roundings of
/// 4000 N over that time on 3.4 kg.
#[test]
fn a_polynomial_input_is_integrated_exactly() {
    let mut parameters = Parameters::default();
    parameters.drive.source = Source::Force;
    let mut machine = Machine::new(&parameters, &InputValues::default(), 0.0).expect("a scene");
    machine.set_input(Input::DriveForce, &[800.0, 3e4, -4e6, 1.2e9]).expect("an input");
    let t = 0.012_f64;
    machine.advance(t).expect("a step");
    let impulse = 800.0 * t + 1.5e4 * t * t - 2e6 / 3.0 * t.powi(3) + 5e7 * t.powi(4);
    let velocity = impulse / parameters.piston_mass() + parameters.gravity * t;
    let found = machine.kinematics().piston.velocity;
    assert!((found - velocity).abs() < 1e-13, "{found} {velocity}");
    let energies = machine.energies();
    assert!(energies.residual.abs() < 1e-12 * energies.drive.abs().max(1.0));
}

/// The instant of an event is a sum of two doubles. The first part, which the host uses, may lie before it.
#[test]
fn a_state_is_restored_where_a_host_stops_at_a_blow_and_steps_by_nothing() {
    let mut machine = machine();
    machine.keep_journal(true);
    let mut stops = Stops::new(&machine, true, &[]);
    for _ in 0..40 {
        machine.advance_keeping_start(10.0, Some(&mut stops)).expect("a step to a blow");
        let time = machine.time();
        machine.advance(time).expect("no step");
        let mut restored = self::machine();
        restored.restore(&machine.state()).expect("a state of its own");
        assert_eq!(restored.kinematics(), machine.kinematics(), "at {time}");
        for machine in [&mut restored, &mut machine] {
            machine.advance(time + 1e-3).expect("a step");
        }
        assert_eq!(restored.state(), machine.state(), "after {time}");
    }
    let later = machine.take_journal().iter().filter(|record| record.time_rest > 0.0).count();
    assert!(later > 40, "{later} events after the instant of their names");
}
