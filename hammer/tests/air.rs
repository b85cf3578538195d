//! A hammer driven by air: closed forms of the gas, and properties of the engine.

use crate::scenes::{Random, air_turnover};
use hammer::{Energies, Error, Fidelity, Input, InputValues, Machine, Parameters, Source};

const GAS: f64 = 287.05;
const KAPPA: f64 = 1.4;

/// The reference hammer, driven by the default air.
fn driven(fidelity: Fidelity) -> Parameters {
    let mut p = Parameters { fidelity, ..Parameters::default() };
    p.drive.source = Source::Air;
    p
}

/// Chambers of constant volume beside a piston at rest, with all ports shut.
fn still() -> Parameters {
    let mut p = driven(Fidelity::Rigid);
    (p.drive.area_drive, p.drive.area_return, p.gravity) = (0.0, 0.0, 0.0);
    for chamber in [&mut p.air.drive, &mut p.air.returning] {
        (chamber.supply, chamber.exhaust) = (1.0, 1.0);
    }
    (p.air.drive.supply, p.air.returning.exhaust) = (-1.0, -1.0);
    p
}

/// Flow through a choked opening over its area, the pressure and the root of the temperature.
fn choked() -> f64 {
    (KAPPA / GAS).sqrt() * (2.0 / (KAPPA + 1.0f64)).powf((KAPPA + 1.0) / (2.0 * (KAPPA - 1.0)))
}

fn pressures(machine: &Machine) -> [f64; 2] {
    machine.chamber_pressures().map(|[pressure, _]| pressure)
}

/// A chamber at 20 bar empties through a choked opening: `T` falls as `(1 + (kappa - 1) K t / 2)^-2`, and `p` with it
/// as in an expansion. Each of some ten windows has an error of `air.error` of the pressure.
#[test]
fn a_chamber_empties_through_a_choked_opening_as_in_closed_form() {
    let mut p = still();
    // The supply is open without area, so that the chamber starts at the supply's pressure.
    (p.air.drive.supply, p.air.drive.exhaust, p.air.supply_area) = (0.0, -1.0, 0.0);
    let inputs = InputValues { supply_pressure: 2e6, ..InputValues::default() };
    let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
    let (volume, area) = (p.air.drive.dead_volume, p.air.discharge * p.air.exhaust_area);
    let rate = area * choked() * GAS * p.air.temperature.sqrt() / volume;
    for t in [0.0, 5e-4, 1e-3, 1.5e-3] {
        machine.advance(t).expect("a step");
        let cooled = 1.0 + 0.5 * (KAPPA - 1.0) * rate * t;
        let expected = 2e6 * cooled.powf(-2.0 * KAPPA / (KAPPA - 1.0));
        assert!(expected > 1.9 * 101_325.0, "still choked");
        let [[found, falls], _] = machine.chamber_pressures();
        for (found, expected) in [(found, expected), (falls, -KAPPA * rate * expected / cooled)] {
            let off = (found / expected - 1.0).abs();
            assert!(off < 10.0 * p.air.error, "at {t}: {found} for {expected}");
        }
    }
}

/// With every port shut both chambers are gas springs: `p V^kappa` is constant to rounding, and so is the sum of the
/// piston's and the gas's energy, up to the windows' error.
#[test]
fn shut_chambers_are_compressed_adiabatically() {
    let mut p = driven(Fidelity::Rigid);
    p.air = hammer::AirLaw { drive: still().air.drive, returning: still().air.returning, ..p.air };
    (p.gravity, p.piston.initial_velocity) = (0.0, -6.0);
    p.rock.stiffness = 1e13; // The return chamber presses on the bit: it is not to yield.
    let mut machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
    let [dead, back] = [p.air.drive.dead_volume, p.air.returning.dead_volume];
    let volumes =
        |x: f64| [dead + p.drive.area_drive * (p.air.cylinder + x), back - p.drive.area_return * x];
    let start = volumes(machine.kinematics().relative.displacement);
    let stored = |p: [f64; 2], v: [f64; 2]| (p[0] * v[0] + p[1] * v[1]) / (KAPPA - 1.0);
    let mass = p.piston_mass();
    // The exhaust's pressure acts on both faces.
    let whole = 18.0 * mass + stored([101_325.0; 2], start);
    for step in 1..=8 {
        machine.advance(f64::from(step) * 1e-3).expect("a step");
        let (now, found) = (*machine.kinematics(), pressures(&machine));
        let v = volumes(now.relative.displacement);
        for i in 0..2 {
            let expected = 101_325.0 * (start[i] / v[i]).powf(KAPPA);
            let swells = [p.drive.area_drive, -p.drive.area_return][i] * now.relative.velocity;
            let rising = -KAPPA * expected * swells / v[i];
            assert!((found[i] / expected - 1.0).abs() < 1e-12);
            let found = machine.chamber_pressures()[i][1];
            assert!((found / rising - 1.0).abs() < 1e-11, "{found} for {rising}");
        }
        let energy = 0.5 * mass * now.piston.velocity.powi(2) + stored(found, v);
        assert!((energy / whole - 1.0).abs() < p.air.error, "{energy} for {whole}");
    }
}

fn run(p: &Parameters, inputs: &InputValues, times: &[f64]) -> Machine {
    let mut machine = Machine::new(p, inputs, 0.0).expect("a scene");
    times.iter().for_each(|t| machine.advance(*t).expect("a step"));
    machine
}

/// Scenes for properties of the engine: rigid and elastic, bare and in a casing with a vent.
fn usual() -> Vec<(Parameters, InputValues)> {
    let mut list = Vec::new();
    for fidelity in Fidelity::ALL {
        let mut p = driven(fidelity);
        (p.air.leakage_area, p.air.drag) = (2e-6, 5.0);
        list.push((p, InputValues::default()));
        (p.casing.mass, p.chuck.idle_travel, p.contact.initial_gap) = (30.0, 0.02, 0.04);
        list.push((p, InputValues { feed_force: 8e3, ..InputValues::default() }));
    }
    list
}

/// Chambers, ports, pressures and bodies drawn around the reference's, in a casing or without.
fn drawn(random: &mut Random) -> (Parameters, InputValues) {
    let mut p = driven(if random.unit() < 0.85 { Fidelity::Rigid } else { Fidelity::Elastic });
    (p.piston.length, p.bit.length) = (random.spread(0.1, 0.4), random.spread(0.1, 0.4));
    (p.drive.area_drive, p.drive.area_return) =
        (random.spread(8e-4, 3e-3), random.spread(8e-4, 2e-3));
    (p.air.drive.dead_volume, p.air.returning.dead_volume) =
        (random.spread(2e-5, 2e-4), random.spread(2e-5, 2e-4));
    for (chamber, supply) in [(&mut p.air.drive, -0.03), (&mut p.air.returning, -0.015)] {
        chamber.supply = supply + random.between(-0.01, 0.01);
        chamber.exhaust += random.between(-0.01, 0.01);
    }
    p.air.leakage_area = if random.unit() < 0.3 { random.spread(1e-7, 1e-5) } else { 0.0 };
    p.contact.initial_gap = random.between(0.005, 0.05);
    if random.unit() < 0.6 {
        p.casing.mass = random.spread(5.0, 60.0);
        p.chuck.travel = random.between(0.005, 0.03);
    }
    let inputs = InputValues {
        feed_force: random.between(0.0, 12e3),
        supply_pressure: random.spread(5e5, 3e6),
        exhaust_pressure: random.spread(5e4, 3e5),
        ..InputValues::default()
    };
    (p, inputs)
}

/// The work of the gas by its volumes, `int (p_d - p_e) dV_d + int (p_r - p_e) dV_r`, is the drive's work on the
/// hammer, in a casing or without, also where the bit hangs out; up to the error allowed of the sum of all energies,
/// within a factor of three, as for any stated error.
#[test]
fn the_gas_gives_what_the_hammer_gets() {
    let (mut random, mut hung) = (Random::new(51), 0);
    for scene in 0..200 {
        let (p, inputs) = drawn(&mut random);
        let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
        let places = |machine: &Machine| {
            let now = machine.kinematics();
            [now.relative.displacement, now.over_struck.displacement]
        };
        let from = places(&machine);
        machine.advance(0.06).unwrap_or_else(|error| panic!("scene {scene}: {error}"));
        let to = places(&machine);
        hung += usize::from((to[1] - to[0]).abs() > 1e-3);
        let swept =
            p.drive.area_drive * (to[0] - from[0]) - p.drive.area_return * (to[1] - from[1]);
        let given = machine.air_work() - inputs.exhaust_pressure * swept;
        let energies = machine.energies();
        let (off, turnover) = (given - energies.drive, air_turnover(&machine));
        assert!(off.abs() < 3.0 * p.air.error * turnover, "scene {scene}: {off:e} of {turnover} J");
        let residual = machine.air_residual();
        assert!(residual.abs() < 3.0 * p.air.error * turnover, "scene {scene}: {residual:e} J");
        assert!(energies.residual.abs() <= energies.residual_bound());
    }
    assert!(hung >= 10, "{hung} bits hung out");
}

/// Powers computed from outputs, by the trapezoidal rule over 0.1 s in steps of 20 us and of 5 us, beside the
/// ledger's energies, J. The rule's error is proportional to the square of the step, so a third of the difference of
/// two steps is the error of the finer one.
fn from_outside<const N: usize>(
    (p, inputs): &(Parameters, InputValues),
    powers: impl Fn(&Machine) -> [f64; N],
    ledger: impl Fn(&Energies) -> [f64; N],
) {
    let by = |steps: u32| {
        let mut machine = Machine::new(p, inputs, 0.0).expect("a scene");
        let (mut sums, mut last) = ([0.0; N], [0.0; N]);
        let span = 0.1 / f64::from(steps);
        for k in 1..=steps {
            machine.advance(f64::from(k) * span).expect("a step");
            let now = powers(&machine);
            (0..N).for_each(|i| sums[i] += 0.5 * span * (last[i] + now[i]));
            last = now;
        }
        (sums, ledger(&machine.energies()))
    };
    let ((coarse, _), (fine, energies)) = (by(5_000), by(20_000));
    for i in 0..N {
        let (apart, energy) = ((coarse[i] - fine[i]).abs(), energies[i]);
        assert!(energy > 10.0 && apart < 0.01 * energy, "{coarse:?} {fine:?} {energies:?}");
        assert!((fine[i] - energy).abs() < apart + 1e-4 * energy, "{} for {energy} J", fine[i]);
    }
}

/// Without a casing the cylinder follows the bit. The drive's work is its force times the piston's displacement
/// relative to the bit, and the holder of the cylinder does the rest.
#[test]
fn what_holds_the_cylinder_is_among_the_feed() {
    let (p, inputs) = (driven(Fidelity::Rigid), InputValues::default());
    let powers = |machine: &Machine| {
        let now = machine.kinematics();
        let anvil = (pressures(machine)[1] - inputs.exhaust_pressure) * p.drive.area_return;
        let force = now.applied_drive_force;
        let held = (force + anvil + inputs.feed_force) * now.bit.velocity;
        [force * now.relative.velocity, held]
    };
    from_outside(&(p, inputs), powers, |energies| [energies.drive, energies.feed]);
}

/// An amount that is added to one of a state's sums shows in the balance.
#[test]
fn the_balance_of_the_air_says_what_is_missing() {
    let (p, inputs) = usual().remove(0);
    let mut machine = run(&p, &inputs, &[0.1]);
    let before = machine.air_residual();
    for (sum, sign) in [("enthalpy", 1.0), ("work", -1.0)] {
        let mut state = serde_json::to_value(machine.state()).expect("a state in JSON");
        let of = &mut state["motion"]["air"]["sums"][sum];
        *of = (of.as_f64().expect("a number") + 0.5).into();
        let mut other = run(&p, &inputs, &[]);
        other.restore(&serde_json::from_value(state).expect("a state")).expect("the same scene");
        let more = other.air_residual() - before;
        assert!((more - 0.5 * sign).abs() < 1e-9, "{sum}: {more}");
    }
    machine.advance(0.11).expect("a step");
}

/// A smaller error leads to the same motion, within the larger error; also with few elements, whose oscillations
/// affect a bit without a casing most.
#[test]
fn the_error_allowed_bounds_the_error() {
    let mut coarse = usual()[2];
    assert_eq!(coarse.0.fidelity, Fidelity::Elastic);
    (coarse.0.mesh.degree, coarse.0.piston.elements, coarse.0.bit.elements) = (1, 3, 3);
    coarse.1.supply_pressure = 1.5e6;
    for (p, inputs) in usual().into_iter().chain([coarse]) {
        let of = |error: f64| {
            let mut p = p;
            p.air.error = error;
            let machine = run(&p, &inputs, &[0.08]);
            (*machine.blow().expect("a blow"), machine.air_mass()[0])
        };
        let (finest, mass) = of(1e-11);
        for error in [1e-8, 1e-6] {
            let (blow, taken) = of(error);
            assert!((blow.speed / finest.speed - 1.0).abs() < error);
            assert!((blow.time / finest.time - 1.0).abs() < error);
            assert!((taken / mass - 1.0).abs() < error);
        }
    }
}

/// At every instant the force is that of the pressures and the drag, to ten times the error of the pressures' force;
/// also in a window that is cut short by a feed set every 0.2 us, under which the bit would oscillate within the
/// window.
#[test]
fn the_force_is_that_of_the_pressures_and_the_drag() {
    let (mut p, inputs) = usual().remove(0);
    (p.air.drag, p.rock.stiffness) = (1e3, 1e9);
    let mut machine = run(&p, &inputs, &[]);
    for step in 0..100 {
        machine.set_input(Input::FeedForce, &[5e3 + 20.0 * f64::from(step), 1e8]).expect("a force");
        machine.advance(f64::from(step + 1) * 2e-7).expect("a step");
        let (now, pressures) = (machine.kinematics(), pressures(&machine));
        let over = pressures.map(|pressure| pressure - inputs.exhaust_pressure);
        let pushed = over[0] * p.drive.area_drive - over[1] * p.drive.area_return;
        let off = now.applied_drive_force - (pushed - p.air.drag * now.relative.velocity);
        let both = pressures[0] * p.drive.area_drive + pressures[1] * p.drive.area_return;
        assert!(off.abs() <= 10.0 * p.air.error * both, "step {step}: {off} of {both} N");
    }
}

/// While the bit hangs out, the chambers are at the exhaust's pressure and no air is taken. When the bit is pressed
/// back, the hammer starts again.
#[test]
fn a_lifted_hammer_is_vented_and_starts_again() {
    let (p, inputs) = usual().remove(1);
    let mut machine = run(&p, &inputs, &[0.05]);
    machine.set_input(Input::FeedForce, &[-1e3]).expect("a force");
    while !machine.mode().vented {
        machine.advance(machine.time() + 1e-3).expect("a step");
        assert!(machine.time() < 2.0, "never vented");
    }
    let [mass, _] = machine.air_mass();
    machine.advance(machine.time() + 5e-3).expect("a step");
    assert_eq!(machine.air_mass(), [mass, 0.0]);
    assert_eq!(machine.kinematics().applied_drive_force, 0.0);
    assert!(pressures(&machine).iter().all(|p| (p / 101_325.0 - 1.0).abs() < 1e-12));
    machine.set_input(Input::FeedForce, &[8e3]).expect("a force");
    let blows = machine.counters().blows;
    machine.advance(machine.time() + 0.3).expect("a step");
    assert!(machine.counters().blows > blows + 2 && machine.air_mass()[0] > mass);
    assert!(machine.energies().residual.abs() <= machine.energies().residual_bound());
    assert!(
        machine.air_residual().abs() < p.air.error * air_turnover(&machine),
        "{}",
        machine.air_residual()
    );
}

/// The piston's travel up to where the last port is fully open, 39 mm, is longer than a cylinder of 38 mm.
#[test]
fn a_cylinder_shorter_than_its_ports_need_is_warned_of() {
    let mut p = driven(Fidelity::Rigid);
    let mut warning = |cylinder| {
        p.air.cylinder = cylinder;
        let machine = Machine::new(&p, &InputValues::default(), 0.0).expect("a scene");
        machine.warnings().into_iter().find(|text| text.contains("air.cylinder"))
    };
    assert_eq!(warning(0.0395), None);
    let text = warning(0.038).expect("a warning");
    for part in ["air.cylinder = 0.038 m", "air.return.exhaust = -0.035 m", "0.0390 m above"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn what_has_no_volume_is_refused_by_name() {
    let mut p = driven(Fidelity::Rigid);
    p.contact.initial_gap = 0.2;
    let error = Machine::new(&p, &InputValues::default(), 0.0).err();
    let Some(Error::Parameter(error)) = error else { panic!("{error:?}") };
    assert_eq!(error.name, "contact.initial_gap");
    for (field, name) in [
        ((|p| &mut p.air.temperature) as fn(&mut Parameters) -> &mut f64, "air.temperature"),
        (|p| &mut p.air.drive.dead_volume, "air.drive.dead_volume"),
        (|p| &mut p.air.error, "air.error"),
    ] {
        let mut p = driven(Fidelity::Rigid);
        *field(&mut p) = 0.0;
        let error = p.validate().expect_err(name);
        assert_eq!(error.name, name);
    }
}
