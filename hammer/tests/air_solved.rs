//! Blows of hammers driven by air, against SciPy's solution: the air as mass and internal energy, port edges and
//! transitions located, rigid bodies and bars, bare and in a casing (`evidence/oracles/data/air.py`).

use hammer::Rock;
use hammer::{AirChamber, AirLaw, Fidelity, InputValues, Machine, Parameters, Source};
use serde_json::Value;

/// Error of both solutions in each step.
const ERROR: f64 = 1e-8;
/// Two such solutions differ by no more than this over some blows, which amplify an error; also with bars, where
/// dozens of contacts follow each blow.
const AGREED: f64 = 1e-6;

fn scene(all: &Value, one: &Value) -> (Parameters, InputValues) {
    let (air, steel) = (&all["air"], &all["steel"]);
    let of = |table: &Value, name: &str| table[name].as_f64().expect(name);
    let elements = one["elements"].as_u64().expect("elements") as usize;
    let fidelity = if elements == 0 { Fidelity::Rigid } else { Fidelity::Elastic };
    let mut p = Parameters { fidelity, ..Parameters::default() };
    (p.material.youngs_modulus, p.material.density) = (of(steel, "E"), of(steel, "rho"));
    (p.material.damping_time, p.cross_section) = (of(steel, "beta"), of(steel, "A"));
    (p.piston.length, p.bit.length) = (of(steel, "L"), of(steel, "L"));
    (p.mesh.degree, p.piston.elements, p.bit.elements) = (1, elements.max(1), elements.max(1));
    (p.contact.stiffness, p.contact.initial_gap) = (of(steel, "KC"), of(steel, "g0"));
    p.rock = Rock {
        stiffness: of(steel, "KR"),
        unloading_ratio: of(steel, "gamma"),
        viscosity: of(steel, "CR"),
        energy_barrier: of(steel, "WR"),
        standstill_speed: of(steel, "vs"),
        standstill_penetration: of(steel, "dps"),
        ..p.rock
    };
    (p.gravity, p.casing.mass) = (of(steel, "G"), of(one, "casing"));
    (p.chuck.stiffness, p.chuck.viscosity) = (of(steel, "ks"), of(steel, "cs"));
    p.drive.source = Source::Air;
    let number = |value: &Value| value.as_f64().expect("a number");
    [p.drive.area_drive, p.drive.area_return] = [0, 1].map(|i| number(&air["areas"][i]));
    let chamber = |i: usize, dead: &str| AirChamber {
        dead_volume: of(air, dead),
        supply: number(&air["edges"][i][0]),
        exhaust: number(&air["edges"][i][1]),
    };
    p.air = AirLaw {
        drive: chamber(0, "drive_dead"),
        returning: chamber(1, "return_dead"),
        cylinder: of(air, "cylinder"),
        port_height: of(air, "height"),
        supply_area: of(air, "supply_area"),
        exhaust_area: of(air, "exhaust_area"),
        discharge: of(air, "discharge"),
        leakage_area: of(air, "leakage"),
        drag: of(air, "drag"),
        temperature: of(air, "temperature"),
        error: ERROR,
    };
    let inputs = InputValues {
        feed_force: of(one, "feed"),
        supply_pressure: of(air, "supply"),
        exhaust_pressure: of(air, "exhaust"),
        ..InputValues::default()
    };
    (p, inputs)
}

#[test]
fn blows_are_those_of_an_independent_solution() {
    let text = include_str!("../../evidence/oracles/data/air.json");
    let all: Value = serde_json::from_str(text).expect("JSON");
    for one in all["scenes"].as_array().expect("scenes") {
        let (p, inputs) = scene(&all, one);
        let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
        let number = |value: &Value| value.as_f64().expect("a number");
        let close = |what: &str, found: f64, expected: f64| {
            let off = found / expected - 1.0;
            println!("{}: {what} {found}, off {off:e}", one["name"]);
            assert!(off.abs() < AGREED, "{}: {what} {found} for {expected}", one["name"]);
        };
        let blows = one["blows"].as_array().expect("blows");
        assert!(blows.len() >= 2);
        for blow in blows {
            let time = number(&blow[0]);
            machine.advance(time + 1e-4).expect("a step");
            let found = *machine.blow().expect("a blow");
            close("time", found.time, time);
            close("speed", found.speed, number(&blow[1]));
        }
        machine.advance(number(&one["until"])).expect("a step");
        assert_eq!(machine.counters().blows as usize, blows.len());
        close("air", machine.air_mass()[0], number(&one["air"]));
        for (found, expected) in
            machine.chamber_pressures().iter().zip(one["pressures"].as_array().expect("two"))
        {
            close("pressure", found[0], number(expected));
        }
    }
}
