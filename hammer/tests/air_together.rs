//! Air together with other features: the other law of reloading, rods, derivatives, means, a supply that cannot start
//! the hammer.

use crate::scenes::air_turnover;
use hammer::Scene;
use hammer::means::{Kind, Wanted, steady};
use hammer::presets::Preset;
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::{Fidelity, InputValues, Machine, Parameters, Reloading, Source};

fn driven(fidelity: Fidelity) -> Parameters {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    p.drive.source = Source::Air;
    p
}

/// Both balances close, blows occur, and dividing a step changes no bit: with both laws of reloading, with tight and
/// loose rods between piston and bit, and in a casing.
#[test]
fn balances_and_bits_hold_with_all_that_a_hammer_may_have() {
    for (reloading, rods, slack, casing) in [
        (Reloading::Unloading, 0, 0.0, 0.0),
        (Reloading::Unloading, 0, 0.0, 30.0),
        (Reloading::Loading, 1, 0.0, 0.0),
        (Reloading::Unloading, 2, 1e-3, 0.0),
    ] {
        let mut p = driven(Fidelity::Elastic);
        (p.rock.reloading, p.drill.rods, p.drill.joint.slack) = (reloading, rods, slack);
        (p.casing.mass, p.contact.initial_gap) = (casing, 0.04);
        // The mesh must carry the wave through rods of some metres.
        p.bit.elements = if rods > 0 { 48 * rods } else { p.bit.elements };
        let inputs = InputValues { feed_force: 8e3, ..InputValues::default() };
        let run = |slices: u32| {
            let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
            for k in 1..=slices {
                machine.advance(0.06 * f64::from(k) / f64::from(slices)).expect("a step");
            }
            machine
        };
        let (whole, sliced) = (run(1), run(7));
        assert_eq!(whole.state().without_step(), sliced.state().without_step());
        assert!(whole.counters().blows >= 1, "{rods} rods, casing of {casing} kg");
        let energies = whole.energies();
        assert!(energies.residual.abs() <= energies.residual_bound(), "{energies:?}");
        assert!(whole.air_residual().abs() < p.air.error * air_turnover(&whole));
    }
}

/// A chamber that empties through a choked opening has the pressure `p_s cooled^-7` with
/// `cooled = 1 + (kappa - 1) K t / 2`, where `K` is proportional to the opening. The error of each window, 1e-11 of
/// the pressure, is a hundred-thousandth of a difference of 2e-6, and less since it is similar on both sides.
#[test]
fn derivatives_of_the_air_are_those_of_its_closed_form() {
    let mut p = driven(Fidelity::Rigid);
    (p.drive.area_drive, p.drive.area_return, p.gravity) = (0.0, 0.0, 0.0);
    (p.air.supply_area, p.air.error) = (0.0, 1e-11);
    (p.air.drive.supply, p.air.drive.exhaust) = (0.0, -1.0);
    (p.air.returning.supply, p.air.returning.exhaust) = (1.0, -1.0);
    let inputs = InputValues { supply_pressure: 2e6, ..InputValues::default() };
    let scene = Scene { parameters: p, inputs };
    let time = 1e-3;
    let by = ["supply_pressure", "air.exhaust_area"]
        .map(|name| Argument::named(name).expect("a row of the table"));
    let sample = |scene: &Scene| {
        let read = |m: &mut Machine| vec![m.chamber_pressures()[0][0]];
        Sample::of_run(&mut scene.machine()?, &[time], &read)
    };
    let found = derivatives(&scene, &by, &sample).expect("runs");
    let choked = (1.4f64 / 287.05).sqrt() * (2.0f64 / 2.4).powi(3);
    let area = p.air.discharge * p.air.exhaust_area;
    let rate = area * choked * 287.05 * p.air.temperature.sqrt() / p.air.drive.dead_volume;
    let cooled = 1.0 + 0.2 * rate * time;
    let by_supply = cooled.powi(-7);
    let by_area = -7.0 * 2e6 * cooled.powi(-8) * (cooled - 1.0) / p.air.exhaust_area;
    for (row, exact) in found.iter().zip([by_supply, by_area]) {
        assert!((row.values[0] / exact - 1.0).abs() < 1e-5, "{row:?} for {exact}");
    }
}

/// With the supply at the exhaust's pressure the piston comes to rest on the bit, and the hammer is reported as
/// stalled.
#[test]
fn a_supply_that_lifts_no_piston_stalls_the_hammer() {
    let parameters = driven(Fidelity::Rigid);
    let inputs = InputValues { supply_pressure: 101_325.0, ..InputValues::default() };
    let scene = Scene { parameters, inputs };
    let found = steady(&scene, &Wanted { limit: 1.0, ..Wanted::default() }, &mut |_, _| true)
        .expect("an answer");
    assert_eq!(found.kind, Kind::Stalled);
}

/// The means of a long run are the numbers of a single blow after a dozen, from which the blows repeat to 1e-3.
#[test]
fn air_is_among_the_means() {
    let scene = Preset::named("air_4_inch").expect("a preset").start();
    let mean = steady(&scene, &Wanted::default(), &mut |_, _| true).expect("an answer").mean;
    let mut machine = scene.machine().expect("a scene");
    while machine.counters().blows < 15 {
        machine.advance(machine.time() + 1e-3).expect("a step");
    }
    let blow = machine.blow().expect("a blow");
    assert!((mean.get("air_flow") / blow.air_flow - 1.0).abs() < 2e-3, "{mean:?} {blow:?}");
    assert!((mean.get("blow_energy") / blow.energy - 1.0).abs() < 2e-3, "{mean:?} {blow:?}");
}
