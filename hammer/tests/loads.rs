//! Varying loads: every order of an input's derivatives, at any rate, on soft and stiff rock.

use hammer::{Event, Fidelity, Input, InputValues, Machine, Parameters, Record, RockEvent};

/// 5 kN with an oscillation of 1 kN at 500 Hz, and its derivatives.
fn feed(t: f64) -> [f64; 5] {
    let w = 2.0 * std::f64::consts::PI * 500.0;
    let (s, c) = (w * t).sin_cos();
    [5e3 + 1e3 * s, 1e3 * w * c, -1e3 * w * w * s, -1e3 * w.powi(3) * c, 1e3 * w.powi(4) * s]
}

fn rock(stiffness: f64, viscosity: f64) -> Parameters {
    let mut p = Parameters::default();
    (p.rock.stiffness, p.rock.viscosity) = (stiffness, viscosity);
    p
}

fn start(parameters: &Parameters) -> Machine {
    Machine::new(parameters, &InputValues::default(), 0.0).expect("a scene")
}

/// The largest residual of the energy balance over `steps` steps, in which the load is extrapolated by derivatives up
/// to this order.
fn held(machine: &mut Machine, order: usize, step: f64, steps: u32) -> f64 {
    let mut worst = 0.0f64;
    for i in 0..steps {
        let t = f64::from(i) * step;
        machine.set_input(Input::FeedForce, &feed(t)[..=order]).expect("an input");
        machine.advance(f64::from(i + 1) * step).expect("a step");
        if i % 10 == 9 {
            worst = worst.max(machine.energies().residual.abs());
        }
    }
    worst
}

/// In each interval between two events or inputs, works and losses are sums over some hundred modal coordinates, none
/// larger than the energy that has passed through the scene or is stored in it: 128 roundings of that for each
/// interval.
fn rounding(machine: &Machine, inputs: u32) -> f64 {
    let e = machine.energies();
    let passed = e.drive.abs() + e.feed.abs() + e.gravity.abs() + e.viscous + e.damping;
    let stored = e.kinetic + e.strain + e.contact + e.rock_stored;
    128.0
        * f64::EPSILON
        * (passed + stored)
        * (f64::from(inputs) + machine.counters().events as f64)
}

/// On soft rock the tip creeps at 6/s while the load turns at 3000/s. The oracle is the same
/// engine under loads that are constant for 2 us, each at its middle: no derivative comes into
/// it, and its steps err by `(w step)^2 / 24` = 2e-6 of the oscillation. A hold of order `n`
/// leaves out `(w step)^(n+1) / (n+1)!` of it at the end of a step and less before: 5e-2, 5e-3,
/// 4e-4 and 3e-5 for the orders 1 to 4. The works are of second degree in the load.
#[test]
fn a_load_that_oscillates_on_creeping_rock_does_the_work_it_must() {
    let parameters = rock(1e6, Parameters::default().rock.viscosity);
    let (step, steps) = (1e-4, 60);
    let mut fine = start(&parameters);
    for i in 0..3000 {
        let middle = (f64::from(i) + 0.5) * 2e-6;
        fine.set_input(Input::FeedForce, &feed(middle)[..1]).expect("an input");
        fine.advance(f64::from(i + 1) * 2e-6).expect("a step");
    }
    let exact = fine.energies();
    for (order, left_out) in [(1, 5e-2), (2, 5e-3), (3, 4e-4), (4, 3e-5)] {
        let mut machine = start(&parameters);
        let residual = held(&mut machine, order, step, steps);
        let bound = rounding(&machine, steps);
        assert!(residual < bound, "order {order}: residual {residual:e} above {bound:e}");
        let (found, events) = (machine.energies(), machine.counters().events);
        let off = (found.viscous - exact.viscous).abs() / exact.viscous;
        let allowed = left_out + 4e-6;
        assert!(off < allowed, "order {order}: viscous work off by {off:e}");
        let off = (found.feed - exact.feed).abs() / exact.feed.abs();
        assert!(off < allowed, "order {order}: work of the feed off by {off:e}");
        assert_eq!(events, fine.counters().events, "order {order}");
    }
}

/// Q3 is where `CR int p'^2` since the start of drilling reaches `WR`, here summed by Simpson's rule from the tip's
/// velocity, for any share of the total work of a load, down to where a difference of such works would have no
/// digits. From 2048 panels to 4096 the sum changes by at most 3.3e-10; the remaining error is a fifteenth of that.
#[test]
fn the_barrier_is_passed_where_the_viscous_work_since_drilling_began_is_its_energy() {
    let rising: [&[f64]; 4] = [&[5e3, 1e7], &[5e3, 1e7, 5e9], &[5e3, 1e7, -1e9, 1e13], &[2e4]];
    for (fidelity, barrier) in Fidelity::ALL.into_iter().flat_map(|f| [0.3, 1e-8].map(|b| (f, b))) {
        for feed in rising {
            let mut p = Parameters { fidelity, ..Parameters::default() };
            p.rock.energy_barrier = barrier;
            let mut scout = start(&p);
            scout.keep_journal(true);
            scout.set_input(Input::FeedForce, feed).expect("an input");
            scout.advance(5e-3).expect("a step");
            let journal = scout.take_journal();
            let of = |event| move |r: &&Record| r.event == Event::Rock(event);
            let to = journal.iter().find(of(RockEvent::Barrier)).expect("a barrier").time;
            let mut before = journal.iter().filter(|r| r.time < to);
            let from = before.rfind(of(RockEvent::Restart)).expect("drilling").time;
            let mut machine = start(&p);
            machine.set_input(Input::FeedForce, feed).expect("an input");
            let panels = 4096;
            let mut work = 0.0;
            for i in 0..=2 * panels {
                let at = from + (to - from) * f64::from(i) / f64::from(2 * panels);
                machine.advance(at).expect("a step");
                let weight =
                    [2.0, 4.0][i as usize % 2] / if i % (2 * panels) == 0 { 2.0 } else { 1.0 };
                work += weight * machine.kinematics().tip.velocity.powi(2);
            }
            work *= p.rock.viscosity * (to - from) / f64::from(6 * panels);
            let off = work / p.rock.energy_barrier - 1.0;
            assert!(off.abs() < 1e-10, "{fidelity:?} {feed:?}: {from} {to} {off:e}");
        }
    }
}

#[test]
fn steps_of_a_microsecond_keep_the_balance_at_every_order() {
    let soft = rock(1e5, 1e6);
    for (parameters, orders) in [(Parameters::default(), 0..5), (soft, 1..2)] {
        for order in orders {
            let mut machine = start(&parameters);
            let residual = held(&mut machine, order, 1e-6, 2000);
            let bound = rounding(&machine, 2000);
            assert!(residual < bound, "order {order}: residual {residual:e} above {bound:e}");
        }
    }
}

/// One polynomial for 20 ms, against the same one set again every 50 us. Each time its coefficients are rounded by
/// 1e-16, which at most some dozen touches and turns multiply by 1e3 each before the motion is damped.
#[test]
fn a_polynomial_held_for_long_is_the_one_told_often() {
    let parameters = rock(1e6, 1.7e5);
    let load = |t: f64| {
        let x = t / 4e-3;
        let value = 5e3 + 2e3 * x - 1.5e3 * x.powi(2) + 80.0 * x.powi(4);
        let d1 = (2e3 - 3e3 * x + 320.0 * x.powi(3)) / 4e-3;
        let d2 = (-3e3 + 960.0 * x.powi(2)) / 4e-3f64.powi(2);
        [value, d1, d2, 1920.0 * x / 4e-3f64.powi(3), 1920.0 / 4e-3f64.powi(4)]
    };
    let (mut once, mut often) = (start(&parameters), start(&parameters));
    once.set_input(Input::FeedForce, &load(0.0)).expect("an input");
    for i in 0..400 {
        let t = f64::from(i) * 5e-5;
        often.set_input(Input::FeedForce, &load(t)).expect("an input");
        often.advance(f64::from(i + 1) * 5e-5).expect("a step");
    }
    once.advance(often.time()).expect("a step");
    let (a, b) = (once.energies(), often.energies());
    assert_eq!(once.counters().events, often.counters().events);
    for (a, b) in [(a.viscous, b.viscous), (a.feed, b.feed), (a.kinetic, b.kinetic)] {
        assert!((a - b).abs() < 1e-9 * a.abs(), "{a} {b}");
    }
    assert!(a.residual.abs() < rounding(&once, 100), "{:e}", a.residual);
}
