//! Checks and limits of the engine, tested by a defect in a saved state, or against their definition computed from
//! other outputs.

use hammer::{
    Error, Event, Fidelity, Input, InputValues, Machine, Parameters, RockEvent, RockMode, Source,
    State,
};
use serde_json::Value;
use std::f64::consts::PI;

fn machine() -> Machine {
    Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene")
}

/// The state with one number changed.
fn planted(machine: &Machine, place: &str, change: impl Fn(f64) -> f64) -> State {
    let mut value = serde_json::to_value(machine.state()).expect("a state is data");
    let slot = value.pointer_mut(place).expect("the state has this number");
    let old = slot.as_f64().expect("a number");
    *slot = if slot.is_u64() { Value::from(change(old) as u64) } else { change(old).into() };
    serde_json::from_value(value).expect("a state")
}

/// A machine in the middle of the interval that ends with the first such event.
fn before(wanted: impl Fn(RockMode, Event) -> bool) -> (Machine, f64) {
    let mut scout = machine();
    scout.keep_journal(true);
    scout.advance(0.1).expect("two blows");
    let journal = scout.take_journal();
    let pair = journal.windows(2).find(|pair| wanted(pair[0].mode.rock, pair[1].event));
    let [from, to] = pair.expect("such an event") else { unreachable!("windows of two") };
    let mut machine = machine();
    machine.advance(0.5 * (from.time + to.time)).expect("a step");
    (machine, to.time + 1e-12)
}

/// The balance is `work = stored + lost + residual`, so a missing work is in the residual.
#[test]
fn a_joule_that_is_missing_in_the_balance_shows_as_the_residual() {
    let mut machine = machine();
    machine.advance(0.1).expect("two blows");
    let sound = machine.energies();
    assert!(sound.residual.abs() <= sound.residual_bound(), "{sound:?}");
    let state = planted(&machine, "/history/ledger/sums/work/0", |work| work + 1.0);
    machine.restore(&state).expect("a state that could be");
    let unsound = machine.energies();
    assert!((unsound.residual - 1.0).abs() <= 2.0 * sound.residual_bound(), "{unsound:?}");
}

/// A spring that is stiffened while it is compressed takes energy from outside, which the balance contains. Every
/// drilling cycle in the journal is counted.
#[test]
fn the_balance_holds_over_a_change_of_the_rock_and_cycles_are_counted() {
    let mut machine = machine();
    machine.keep_journal(true);
    machine.advance(0.1).expect("two blows");
    let journal = machine.take_journal();
    let begins = |record: &&hammer::Record| {
        record.mode.rock == RockMode::DissipativeForward && matches!(record.event, Event::Rock(_))
    };
    let begun = journal.iter().filter(begins).count();
    assert!(begun > 2 && machine.counters().rock_cycles == begun as u64, "{begun}");
    let changes: [fn(&mut Parameters); 3] = [
        |p| p.rock.stiffness *= 1.5,
        |p| p.rock.unloading_ratio *= 1.5,
        |p| p.rock.viscosity *= 1.5,
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let (mut machine, until) = before(|rock, _| rock == RockMode::DissipativeForward);
        let mut tuned = *machine.parameters();
        change(&mut tuned);
        machine.retune(&tuned).expect("another rock");
        // Also into motions whose systems were cached with the previous rock.
        for until in [until, 0.1] {
            machine.advance(until).expect("a step");
            let energies = machine.energies();
            let bound = energies.residual_bound();
            assert!(k > 0 || energies.retuned.abs() > 1e3 * bound, "{energies:?}");
            assert!(energies.residual.abs() < bound, "{k}: {energies:?}");
        }
    }
}

/// A rigid piston falls freely: gravity's work becomes kinetic energy, and the rock stores `F^2 / (2 gamma KR)` of
/// the loads. The bound is the share of their sum that `Energies` promises.
#[test]
fn the_turnover_of_a_fall_is_the_sum_of_its_terms() {
    let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
    p.drive.source = Source::Force;
    let inputs = InputValues::default();
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.advance(0.05).expect("a fall");
    let fallen = 0.5 * p.piston_mass() * (p.gravity * 0.05).powi(2);
    let load = inputs.feed_force + p.bit_mass() * p.gravity;
    let stored = load * load / (2.0 * p.rock.unloading_ratio * p.rock.stiffness);
    let (energies, turnover) = (machine.energies(), 2.0 * fallen + stored);
    // Some tens of roundings.
    assert!((energies.turnover() / turnover - 1.0).abs() < 1e-13, "{energies:?} {turnover}");
    assert!((energies.residual_bound() / (1e-8 * turnover) - 1.0).abs() < 1e-13);
}

/// In dissipative loading the barrier is lowered below the work already done, so that it breaks at that instant. This
/// is the only transition there. After a hundred others it is allowed, after one more it is an error.
#[test]
fn the_hundred_and_first_transition_at_one_instant_is_an_error_that_says_so() {
    let spent = |rock, event| {
        rock == RockMode::DissipativeForward && event == Event::Rock(RockEvent::Barrier)
    };
    for (count, refused) in [(99.0, false), (100.0, true)] {
        let (mut machine, _) = before(spent);
        assert!(machine.viscous_work_of_cycle() > 0.0);
        let state = planted(&machine, "/history/zeno/simultaneous", |_| count);
        machine.restore(&state).expect("a state that could be");
        let mut tuned = *machine.parameters();
        tuned.rock.energy_barrier = 0.0;
        machine.retune(&tuned).expect("a barrier of none");
        match machine.advance(machine.time() + 1e-9) {
            Err(Error::Chattering { transitions, .. }) => {
                assert!(refused && transitions == 101, "{transitions}");
            }
            other => assert!(!refused && other.is_ok(), "{count}: {other:?}"),
        }
    }
}

/// Each counter may be as large as a double can count, and no larger.
#[test]
fn counts_that_no_run_reaches_are_refused() {
    let mut machine = machine();
    for count in ["contacts", "blows", "rock_cycles", "events", "basis_changes"] {
        let most = (1u64 << 53) as f64;
        let place = format!("/history/counters/{count}");
        let [held, refused] = [most, most + 2.0].map(|count| planted(&machine, &place, |_| count));
        assert!(machine.restore(&refused).is_err(), "{count}");
        machine.restore(&held).expect("a count that could be");
    }
}

/// Q6 leads to standstill if the cycle's permanent gain is below the limit, otherwise to a new drilling cycle.
#[test]
fn a_cycle_stands_still_below_the_limit_of_its_gain_and_drills_on_at_it() {
    let limit = Parameters::default().rock.standstill_penetration;
    let returns =
        |rock, event| rock == RockMode::Backward && event == Event::Rock(RockEvent::Return);
    for (part, mode) in [
        (1.0 - 1e-9, RockMode::Standstill),
        (1.0, RockMode::DissipativeForward),
        (1.0 + 1e-9, RockMode::DissipativeForward),
    ] {
        let (mut machine, after) = before(returns);
        let state = planted(&machine, "/motion/memory/gain", |_| part * limit);
        machine.restore(&state).expect("a state that could be");
        machine.keep_journal(true);
        machine.advance(after).expect("a step");
        let journal = machine.take_journal();
        assert_eq!(journal.first().map(|record| record.mode.rock), Some(mode), "{part}");
    }
}

/// On linear elements a stress is `E (u' + beta v')`, from differences of nodes. These cancel six digits:
/// displacements of a millimetre have differences of nanometres.
#[test]
fn a_stress_is_that_of_the_differences_of_its_nodes_and_of_their_speeds() {
    let mut p = Parameters::default();
    (p.mesh.degree, p.material.damping_time) = (1, 1e-6);
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
    machine.advance(0.01372).expect("half a blow");
    let profile = machine.profile();
    let h = p.piston.length / p.piston.elements as f64;
    let [mut largest, mut damped] = [0.0f64; 2];
    for (ends, stress) in profile.piston.windows(2).zip(&profile.piston_stress) {
        let [strain, rate] = [0, 1].map(|k| (ends[1][k] - ends[0][k]) / h);
        let damping = p.material.youngs_modulus * p.material.damping_time * rate;
        let expected = p.material.youngs_modulus * strain + damping;
        largest = largest.max(stress.abs());
        damped = damped.max(damping.abs());
        assert!((stress - expected).abs() < 1e-6 * largest.max(1e6), "{stress} {expected}");
    }
    assert!(damped > 1e-3 * largest && largest > 1e6, "{damped} {largest}");
}

/// The mean rates are the sums of gains over the sums of periods of all blows after the first, to rounding. A growing
/// feed has drilled before the first blow.
#[test]
fn the_mean_rates_are_the_blows_gains_over_their_periods() {
    let mut machine = machine();
    machine.set_input(Input::FeedForce, &[20e3]).expect("an input");
    machine.advance(0.5).expect("ten blows");
    let blows: Vec<_> = machine.step_blows().iter().copied().collect();
    assert!(blows.len() > 8);
    // The response has not settled, so the mean differs from the last blow's rate.
    let Parameters { rock, hole, .. } = *machine.parameters();
    let work_per_length = rock.specific_energy * PI / 4.0 * hole.diameter.powi(2);
    let (mut gain, mut drilled, mut time) = (0.0, 0.0, 0.0);
    for blow in &blows[1..] {
        (gain, time) = (gain + blow.penetration, time + blow.period);
        drilled += blow.rop * blow.period;
        assert!((blow.tip_rate_mean * time / gain - 1.0).abs() < 1e-13, "{blow:?}");
        assert!((blow.rop_mean * time / drilled - 1.0).abs() < 1e-13, "{blow:?}");
        let length = blow.rock_work / work_per_length;
        assert!((blow.rop * blow.period / length - 1.0).abs() < 1e-13, "{blow:?}");
    }
    assert!(machine.drilled_length() > 1.01 * drilled, "the feed drills first");
    let last = blows[blows.len() - 1];
    assert!((last.tip_rate_mean / last.tip_rate - 1.0).abs() > 1e-6, "{last:?}");
}
