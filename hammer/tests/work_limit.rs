//! Chattering ends with an error that names its cause, and any step ends when it is interrupted.

use crate::scenes;
use hammer::Scene;
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::{
    Error, Fidelity, InputValues, Interrupt, Machine, Parameters, Source, State, Tie, WorkLimit,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A contact a million times stiffer than its splines, pressed together and undamped.
fn rattling() -> (Parameters, InputValues) {
    let mut p = scenes::overdamped();
    (p.piston.elements, p.bit.elements, p.mesh.degree) = (4, 4, 7);
    (p.material.damping_time, p.drive.source) = (0.0, Source::Force);
    p.contact.stiffness = 1e6 * p.mesh_stiffness();
    p.work_limit = 1;
    (p, InputValues { drive_force: 1e4, ..InputValues::default() })
}

fn machine((p, inputs): &(Parameters, InputValues)) -> Machine {
    Machine::new(p, inputs, 0.0).expect("a scene")
}

#[test]
fn a_contact_a_million_times_too_stiff_is_named() {
    let mut m = machine(&rattling());
    let error = loop {
        if let Err(error) = m.advance(m.time() + 1e-3) {
            break error;
        }
        assert!(m.time() < 0.1, "a blow is over");
    };
    let Error::Overwork { limit, suspect: Some(suspect), .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(
        (*limit, suspect.name),
        (WorkLimit::Tie(Tie::Contact), "contact.stiffness"),
        "{error}"
    );
    assert!((suspect.ratio / 1e6 - 1.0).abs() < 1e-12, "{error}");
    assert_eq!(m.advance(m.time() + 1e-3), Err(error), "and so says every later step");
}

/// Each event takes the state through two products with a basis, each a sum of a few rounded terms: 16 units in the
/// last place of all energies, as if all errors had the same sign.
#[test]
fn the_energy_balance_holds_over_twenty_thousand_events_of_rattling() {
    let mut m = machine(&rattling());
    while m.counters().events < 20_000 {
        m.advance(m.time() + 2e-5).expect("a step");
    }
    let energies = m.energies();
    let bound = 16.0 * f64::EPSILON * m.counters().events as f64 * energies.turnover();
    assert!(energies.residual.abs() < bound, "{energies:?}");
}

/// The state without the part that belongs to the step.
fn state(m: &Machine) -> State {
    m.state().without_step()
}

#[test]
fn an_interrupted_step_ends_at_once_and_leads_on_to_the_same_motion() {
    // Chattering that takes seconds.
    let scene = rattling();
    let mut m = machine(&scene);
    m.advance(0.012).expect("a fall");
    // After it is set, the work may check it a few times on its way out, but must not continue.
    let asked = Arc::new(AtomicUsize::new(0));
    let count = asked.clone();
    let handle = Interrupt::asking(move || count.fetch_add(1, Ordering::Relaxed) == 300);
    assert_eq!(handle.watch(|| m.advance(0.2)), Err(Error::Cancelled));
    assert_eq!(asked.load(Ordering::Relaxed), 301, "it ended where it was told to");
    assert!(m.counters().events > 0 && m.time() > 0.012 && m.time() < 0.2, "{}", m.time());
    let stopped = m.time();
    assert_eq!(handle.watch(|| m.advance(0.2)), Err(Error::Cancelled), "as long as it is set");
    assert_eq!(m.time(), stopped);
    handle.clear();
    // Equal to the last bit to an uninterrupted run.
    let until = stopped + 1e-6;
    m.advance(until).expect("goes on");
    let mut other = machine(&scene);
    other.advance(until).expect("a run");
    assert_eq!(state(&m), state(&other));
}

/// A million times longer than the fall takes; the limit does not depend on the step's length.
#[test]
fn a_call_has_a_limit_however_long_its_step_is() {
    let (p, inputs) = rattling();
    let mut m = machine(&(p, inputs));
    m.advance(0.012).expect("a fall");
    let before = m.counters();
    let error = m.advance(1e6).expect_err("a rattle for ever");
    assert!(matches!(error, Error::Overwork { .. }), "{error}");
    assert!(error.to_string().contains("work_limit = 1"), "{error}");
    // A unit takes a coordinate of each of at least 22 modes, of 625 million in a second.
    let after = m.counters();
    let work = after.guard_evaluations + after.samples - before.guard_evaluations - before.samples;
    assert!(work < 625_000_000 / 22, "{work}");
}

/// Each derivative repeats the run a few times; all together have the limit of a single call.
#[test]
fn derivatives_have_one_limit_together() {
    let (parameters, inputs) = rattling();
    let scene = Scene { parameters, inputs };
    let blows = |m: &mut Machine| vec![m.counters().blows as f64];
    let run = |scene: &Scene| Sample::of_run(&mut scene.machine()?, &[0.01373], &blows);
    assert!(run(&scene).is_ok(), "one run is within a second");
    let by: Vec<_> = ["feed_force", "gravity"].map(Argument::named).into_iter().flatten().collect();
    let refused = derivatives(&scene, &by, &run);
    assert!(matches!(refused, Err(Error::Overwork { .. })), "{refused:?}");
}

/// Waves travel at 5 km/s in steel, and at 18 km/s in diamond; at 3.6e11 m/s a step of 1.6 ms took 40 s.
#[test]
fn waves_faster_than_any_solid_s_are_refused_by_name() {
    let mut p = Parameters::default();
    p.material.youngs_modulus = 1e14;
    let error = Machine::new(&p, &InputValues::default(), 0.0).expect_err("no such steel");
    let text = error.to_string();
    assert!(
        text.contains("material.youngs_modulus") && text.contains("up to 3140000000000"),
        "{text}"
    );
    p.fidelity = Fidelity::Rigid;
    assert!(Machine::new(&p, &InputValues::default(), 0.0).is_ok(), "no waves, no limit");
}

/// Each window of air needs a series, which takes longer than the search of a rigid hammer. The series use up a
/// call's work, and are named as the cause.
#[test]
fn air_uses_up_a_call_and_is_named() {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    (p.drive.source, p.work_limit) = (Source::Air, 1);
    let mut m = machine(&(p, InputValues::default()));
    let error = m.advance(1e6).expect_err("air for ever");
    assert!(matches!(error, Error::Overwork { limit: WorkLimit::Air, .. }), "{error}");
    assert!(m.counters().blows > 10, "not before it began");
}
