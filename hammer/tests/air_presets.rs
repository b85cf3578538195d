//! The hammers that air drives, in their casings. (What their maker publishes: `catalogue` of `evidence/verify`.)

use crate::scenes::{air_turnover, one_in};
use hammer::presets::{PRESETS, Preset};
use hammer::{Error, Event, Input, InputValues, Machine, Parameters, Scene, Source};

/// Power of the blows, kW, over the second half second, at 24 bar.
fn power(p: &Parameters, inputs: InputValues) -> f64 {
    let mut machine = Machine::new(p, &inputs, 0.0).expect("a scene");
    machine.advance(0.5).expect("a run");
    machine.advance(1.0).expect("a run");
    machine.step_blows().iter().map(|blow| blow.energy).sum::<f64>() / 0.5 / 1e3
}

/// The air's balance closes to its error, relative to the sum of all energies.
fn balances(machine: &Machine) {
    let energies = machine.energies();
    assert!(energies.residual.abs() <= energies.residual_bound());
    let (residual, turnover) = (machine.air_residual(), air_turnover(machine));
    assert!(
        residual.abs() < machine.parameters().air.error * turnover,
        "{residual} of {turnover} J"
    );
}

/// Every preset runs and balances with any feed, any supply from half a bar over the exhaust to 40 bar, any back
/// pressure and any error.
#[test]
fn the_air_is_followed_whatever_its_feed_pressures_and_error() {
    let outside =
        [(1.5e5, 1e5), (3e5, 3e4), (1e6, 101_325.0), (2.5e6, 5e5), (4e6, 1e6), (4e6, 101_325.0)];
    let (mut scenes, mut tried) = (0, 0);
    for preset in PRESETS.iter().filter(|preset| preset.name.starts_with("air_")) {
        let Scene { parameters: mut p, mut inputs } = preset.start();
        for ((supply, exhaust), feed) in
            outside.iter().flat_map(|o| [0.0, 9e3, 3e4].map(|f| (*o, f)))
        {
            for error in [1e-3, 1e-6, 1e-11] {
                scenes += 1;
                // One in four, so that three errors take turns.
                if scenes % one_in(4) > 0 {
                    continue;
                }
                p.air.error = error;
                (inputs.supply_pressure, inputs.exhaust_pressure) = (supply, exhaust);
                inputs.feed_force = feed;
                let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
                let run = machine.advance(0.1);
                assert!(run.is_ok(), "{} {supply} {exhaust} {feed} {error}: {run:?}", preset.name);
                let energies = machine.energies();
                assert!(energies.residual.abs() <= energies.residual_bound());
                tried += 1;
            }
        }
    }
    assert!(tried >= 200 / one_in(4), "{tried} of {scenes}");
}

/// The piston follows a bit that hangs out, with a drive that is never vented, and rests on it. The return chamber is
/// between these two, and keeps its volume.
#[test]
fn a_piston_on_a_bit_that_hangs_out_is_followed() {
    let Scene { parameters: mut p, inputs } =
        Preset::named("air_4_inch").expect("a preset").start();
    p.chuck.idle_travel = 0.0;
    for feed_force in [0.0, 1e3, 5e3] {
        let inputs = InputValues { feed_force, ..inputs };
        let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
        let mut lowest = 0.0f64;
        for k in 1..=500 {
            machine.advance(f64::from(k) * 1e-3).expect("a step");
            let now = machine.kinematics();
            lowest = lowest.max(now.relative.displacement);
            let over = now.over_struck.displacement;
            assert!(p.drive.area_return * over < p.air.returning.dead_volume);
        }
        // Lower than where the chamber would be empty if it ended at the casing.
        let empty = p.air.returning.dead_volume / p.drive.area_return;
        assert!(feed_force > 2e3 || lowest > 0.5 * empty, "{lowest} of {empty}");
        balances(&machine);
    }
}

/// An exhaust far above the supply throws the piston into the cylinder's end, from which it returns.
#[test]
fn an_exhaust_above_the_supply_ends_no_run() {
    let Scene { parameters: p, inputs } = Preset::named("air_4_inch").expect("a preset").start();
    let inputs = InputValues { supply_pressure: 6e5, exhaust_pressure: 1e6, ..inputs };
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    machine.keep_journal(true);
    assert_eq!(machine.advance(0.5), Ok(()));
    let events: Vec<Event> = machine.take_journal().iter().map(|record| record.event).collect();
    let passes = |inside| events.iter().filter(|event| **event == Event::End(inside)).count();
    let (entered, left) = (passes(true), passes(false));
    assert!(entered >= 1 && entered - left <= 1, "{entered} {left}");
    balances(&machine);
}

/// The pressure of air must be positive: the input is named at the start, and where it is set. Other sources do not
/// read it.
#[test]
fn a_pressure_that_no_air_has_is_refused_by_its_name() {
    let Scene { parameters: p, inputs: usual } =
        Preset::named("air_4_inch").expect("a preset").start();
    let start = |p: &Parameters, inputs: InputValues| Machine::new(p, &inputs, 0.0).map(|_| ());
    let mut relay = p;
    relay.drive.source = Source::Relay;
    for (inputs, input) in [
        (InputValues { supply_pressure: 0.0, ..usual }, Input::SupplyPressure),
        (InputValues { exhaust_pressure: -1e5, ..usual }, Input::ExhaustPressure),
    ] {
        let error = start(&p, inputs).expect_err("a vacuum");
        assert!(matches!(error, Error::Input { name, .. } if name == input.name()), "{error}");
        assert!(error.to_string().contains("above 0"), "{error}");
        assert_eq!(start(&relay, inputs), Ok(()));
        let mut machine = Machine::new(&p, &usual, 0.0).expect("a scene");
        assert!(machine.set_input(input, &[0.0]).is_err());
        assert_eq!(machine.advance(0.01), Ok(()));
    }
}

/// With hardly any feed the casing rises and the bit hangs out. The drive is vented again and again, and the air in
/// the cylinder's end, at the exhaust's pressure, throws the rising piston back with its own speed. Both balances
/// close.
#[test]
fn the_cylinder_s_end_throws_a_vented_piston_back() {
    let Scene { parameters: p, inputs } = Preset::named("air_4_inch").expect("a preset").start();
    let end = -p.air.cylinder;
    let no_room = end - p.air.drive.dead_volume / p.drive.area_drive;
    for feed_force in [1e3, 5e3] {
        let inputs = InputValues { feed_force, ..inputs };
        let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
        let (mut highest, mut compared, mut came) = (0.0f64, 0, false);
        while machine.time() < 1.0 {
            machine.advance(machine.time() + 2e-5).expect("a step");
            let (now, at) = (*machine.kinematics(), machine.time());
            let x = now.relative.displacement;
            highest = highest.min(x);
            let [drive, back] = machine.chamber_pressures().map(|[pressure, _]| pressure);
            came = machine.mode().vented && (x >= end || came);
            if came && x < end {
                // Adiabatic from the exhaust's pressure, at which the end begins.
                let volume = p.air.drive.dead_volume + p.drive.area_drive * (x - end);
                let expected = 101_325.0 * (p.air.drive.dead_volume / volume).powf(1.4);
                assert!((drive / expected - 1.0).abs() < 1e-7, "{drive} for {expected} at {x}");
                if compared == 0 {
                    let mut other = Machine::new(&p, &inputs, 0.0).expect("a scene");
                    other.restore(&machine.state()).expect("its own state");
                    for m in [&mut machine, &mut other] {
                        m.advance(at + 2e-3).expect("a step");
                    }
                    assert_eq!(machine.state().without_step(), other.state().without_step());
                }
                compared += 1;
            } else if machine.mode().vented && x >= end {
                assert_eq!([drive, back], [101_325.0; 2]);
                assert_eq!(now.applied_drive_force, 0.0);
            }
        }
        assert!(compared > 0 && highest < end && highest > no_room, "{highest}: {compared} steps");
        balances(&machine);
    }
}

/// If the feed does not hold the casing down, the bit hangs out, the drive is vented, and the hammer idles.
#[test]
fn a_feed_below_the_air_s_reaction_lets_the_hammer_idle() {
    let Scene { parameters: p, inputs } = Preset::named("air_4_inch").expect("a preset").start();
    let little = InputValues { feed_force: 9.4e3, ..inputs };
    let [held, idle] = [inputs, little].map(|inputs| power(&p, inputs));
    assert!(idle < 0.75 * held, "{idle} of {held} kW");
}
