//! Rules that hold at any instant, not only where a guard crosses its level.

use hammer::{Error, Fidelity, Input, InputValues, Machine, Parameters, RockMode};

fn scene(parameters: &Parameters, feed_force: f64) -> Machine {
    let inputs = InputValues { feed_force, ..InputValues::default() };
    Machine::new(parameters, &inputs, 0.0).expect("a scene")
}

/// A feed raised by 5 N makes the bit oscillate in standstill at 1e-4 m/s. If `vs` is slightly less, drilling or
/// unloading starts at that instant, whether the speed grows or falls, and however fast it changes.
#[test]
fn a_guard_already_beyond_its_level_fires_at_once() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        let parameters = Parameters { fidelity, ..Parameters::default() };
        let mut machine = scene(&parameters, 5000.0);
        machine.set_input(Input::FeedForce, &[5005.0]).expect("an input");
        let mut looks = [0, 0];
        for i in 1..=300 {
            machine.advance(f64::from(i) * 3e-6).expect("a step");
            let k = *machine.kinematics();
            let v = k.tip.velocity;
            if machine.mode().rock != RockMode::Standstill || v.abs() < 1e-5 {
                continue;
            }
            let mut other = scene(&parameters, 5000.0);
            other.restore(&machine.state()).expect("the same scene");
            // Setting an input makes the present the instant from which guards are tracked.
            other.set_input(Input::FeedForce, &[5005.0 + 1e-9]).expect("an input");
            // The same state with another `vs`, which no call can change, through its JSON.
            let mut state = serde_json::to_value(other.state()).expect("a state in JSON");
            state["parameters"]["rock"]["standstill_speed"] = (0.999 * v.abs()).into();
            let state = serde_json::from_value(state).expect("a state");
            other.restore(&state).expect("the same scene");
            other.advance(machine.time()).expect("no step at all");
            let expected = if v > 0.0 { RockMode::DissipativeForward } else { RockMode::Backward };
            assert_eq!(other.mode().rock, expected, "at {}, {v} m/s", machine.time());
            looks[usize::from(v * k.tip.acceleration < 0.0)] += 1;
        }
        assert!(looks[0] >= 50 && looks[1] >= 50, "{fidelity:?}: {looks:?} growing, falling");
    }
}

/// A step must end at a finite instant, and no earlier than it begins. A refused step changes nothing.
#[test]
fn a_step_back_or_without_end_is_refused() {
    let mut machine = scene(&Parameters::default(), 5000.0);
    machine.advance(0.01).expect("a step");
    let before = machine.state();
    for to in [0.0, 0.01 - 1e-9, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let refused = matches!(machine.advance(to), Err(Error::Backwards { .. }));
        assert!(refused && machine.state() == before, "{to}");
    }
    machine.advance(0.02).expect("a step");
}

/// A scene `2^k` times as slow has all times that much longer, and the same events. Rounding is the same, except for
/// dyadic spans that no longer fit; two touches of the rock amplify it to 1e-9.
#[test]
fn a_slower_scene_has_the_same_events_later() {
    let run = |slow: f64| {
        let mut p = Parameters::default();
        p.material.youngs_modulus /= slow * slow;
        p.material.damping_time *= slow;
        for x in [
            &mut p.contact.stiffness,
            &mut p.rock.stiffness,
            &mut p.rock.energy_barrier,
            &mut p.drive.amplitude,
            &mut p.gravity,
        ] {
            *x /= slow * slow;
        }
        p.rock.viscosity /= slow;
        p.rock.standstill_speed /= slow;
        let mut m = scene(&p, 5000.0 / (slow * slow));
        m.keep_journal(true);
        m.advance(0.06 * slow).expect("a run");
        (p.resolutions(), m.take_journal())
    };
    let ([displacement, velocity], events) = run(1.0);
    for slow in [0.5, 64.0, 1024.0] {
        let (resolutions, later) = run(slow);
        assert_eq!(resolutions, [displacement, velocity / slow]);
        assert_eq!(later.len(), events.len(), "{slow}");
        for (a, b) in events.iter().zip(&later) {
            assert_eq!((a.event, a.mode), (b.event, b.mode), "{slow}: at {}", a.time);
            assert!((a.time - b.time / slow).abs() <= 1e-9 * a.time, "{slow}: at {}", a.time);
        }
    }
}

/// The limit where the loads just carry the bit: it hangs from its shoulder, at rest, in the limit from both sides.
/// `FS + Mb G` of 1e-6 N moves it by 1e-6 / (gamma KR) or not at all.
#[test]
fn the_start_has_one_limit_where_the_loads_just_carry_the_bit() {
    let p = Parameters::default();
    let weight = p.bit_mass() * p.gravity;
    let start = |press: f64| {
        let m = scene(&p, press - weight);
        (m.mode().rock, m.profile(), m.energies())
    };
    let (above, below) = (start(1e-6), start(-1e-6));
    assert_eq!((above.0, below.0), (RockMode::Standstill, RockMode::FreeFlight));
    // Strain of a hanging bit: 33 N over 2.6e-3 m2 of 210 GPa, 0.168 m, is 1e-8 m.
    let stretch = |bit: &[[f64; 2]]| bit[bit.len() - 1][0] - bit[0][0];
    let hang = 0.5 * weight * p.bit.length / (p.material.youngs_modulus * p.cross_section);
    assert!((stretch(&above.1.bit) - hang).abs() < 1e-6 * hang);
    for (a, b) in above.1.bit.iter().zip(&below.1.bit) {
        // 1e-6 N of the strain's 33 N, and 1e-6 / (gamma KR) of the position.
        assert!((a[0] - b[0]).abs() < 1e-7 * hang + 1e-14, "{a:?} {b:?}");
        // At rest, up to rounding of displacements of 1e-9 m times 1e6/s.
        assert!(a[1].abs().max(b[1].abs()) < 1e-18, "{a:?} {b:?}");
    }
    assert!((above.2.strain - below.2.strain).abs() < 1e-6 * above.2.strain);
}

/// During a blow the piston rests on the bit too, but the contact will open.
#[test]
fn a_hammer_at_work_is_not_stalled() {
    let mut machine = scene(&Parameters::default(), 5000.0);
    let mut closed = 0;
    for step in 1..=10_000 {
        machine.advance(1e-5 * f64::from(step)).expect("a step");
        closed += u32::from(machine.mode().closed());
        assert!(!machine.stalled(), "{}", machine.time());
    }
    assert!(closed > 10, "{closed}");
}
