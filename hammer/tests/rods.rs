//! A top hammer: a drill string of shank, rods and sleeves between piston and bit.

use hammer::Scene;
use hammer::means::{Averages, Kind, Wanted, steady};
use hammer::presets::PRESETS;
use hammer::{
    Body, Event, Fidelity, InputValues, MAX_RODS, MAX_SECTIONS, Machine, Parameters, Reading, Relay,
};

fn top_hammer() -> Scene {
    let preset = PRESETS.iter().find(|preset| preset.name == "top_hammer").expect("a preset");
    preset.start()
}

/// Lengths of rods and shank are from face to face, so sleeves add none. A sleeve covers half of its length on each
/// side of a joint, and that part has its section.
#[test]
fn a_string_is_as_long_as_its_parts_and_sleeves_cover_their_joints() {
    let mut p = top_hammer().parameters;
    for rods in 1..=MAX_RODS {
        p.drill.rods = rods;
        let (d, n, s) = (p.drill, rods as f64, p.sections(Body::Bit));
        let own: f64 = p.bit.segments.iter().map(|part| part.length).sum();
        let length = d.shank.length + n * d.rod.length + own;
        // A rounding for each of the sections.
        assert!((s.length() - length).abs() < 1e-15 * 30.0 * length, "{rods}");
        let volume = d.shank.area * (d.shank.length - 0.5 * d.coupling.length)
            + n * d.coupling.area * d.coupling.length
            + d.rod.area * (n * d.rod.length - (n - 0.5) * d.coupling.length)
            + p.bit.segments.iter().map(|part| part.length * part.area).sum::<f64>();
        assert!((s.mass(1.0) - volume).abs() < 1e-15 * 30.0 * volume, "{rods}");
        // Each joint is in the middle of a sleeve.
        for joint in 0..rods {
            let place = d.shank.length + joint as f64 * d.rod.length;
            for (side, area) in [(-0.49, d.coupling.area), (0.49, d.coupling.area)] {
                assert_eq!(s.area_at(place + side * d.coupling.length), area);
            }
            let above = if joint == 0 { d.shank.area } else { d.rod.area };
            assert_eq!(s.area_at(place - 0.51 * d.coupling.length), above);
            assert_eq!(s.area_at(place + 0.51 * d.coupling.length), d.rod.area);
        }
        assert!(s.as_slice().len() == 3 + 2 * rods && s.as_slice().len() <= MAX_SECTIONS);
    }
    p.drill.coupling.length = 0.0;
    assert_eq!(p.sections(Body::Bit).as_slice().len(), 1 + MAX_RODS + 2);
}

#[test]
fn a_string_that_cannot_be_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Parameters)| {
        let mut p = top_hammer().parameters;
        change(&mut p);
        Machine::new(&p, &InputValues::default(), 0.0).expect_err("refused").to_string()
    };
    for (change, name, range) in [
        (
            &(|p: &mut Parameters| p.drill.coupling.length = 1.0) as &dyn Fn(&mut Parameters),
            "drill.coupling.length = 1 ",
            "below 1, the rod's length and twice the shank's",
        ),
        (&|p| p.fidelity = Fidelity::Rigid, "drill.rods = 4 ", "0 with rigid bodies"),
        (&|p| p.drill.rods = 9, "drill.rods = 9 ", "0 to 8"),
        (&|p| p.bit.elements = 20, "bit.elements = 20 ", "at least"),
        (&|p| p.mesh.degree = 1, "mesh.degree = 1 ", "above 1"),
        (
            &|p| (p.piston.segments[0].length, p.mesh.degree, p.drill.rod.length) = (0.03, 7, 6.0),
            "drill.rods = 4 ",
            "fewer",
        ),
    ] {
        let message = refused(change);
        assert!(message.starts_with(name) && message.contains(range), "{message}");
    }
    // The number that is asked for suffices, and one less does not.
    let mut p = top_hammer().parameters;
    p.bit.elements = 20;
    let message = p.validate().expect_err("too few").allowed;
    let needed =
        message.split_whitespace().nth(2).and_then(|word| word.trim_matches(',').parse().ok());
    p.bit.elements = needed.expect("a number");
    assert_eq!(p.validate(), Ok(()));
    p.bit.elements -= 1;
    assert!(p.validate().is_err());
}

/// Published for drifters of this class: 18 to 19 kW at up to 60 Hz. The blows never repeat, so means are compared.
#[test]
fn the_top_hammer_has_the_published_power_and_never_repeats() {
    let wanted = Wanted { error: Averages::of_rates(0.02), threads: 2, ..Wanted::default() };
    let found = steady(&top_hammer(), &wanted, &mut |_, _| true).expect("a response");
    assert!(found.kind == Kind::Irregular && found.reached);
    let [energy, period] = ["blow_energy", "period"].map(|name| found.mean.get(name));
    let power = energy / period;
    assert!((15e3..=19e3).contains(&power) && 1.0 / period <= 60.0, "{power} W, {period} s");
}

/// The waves of 49 m of string take 19 ms to the bit and back, as long as a period. Each blow of the piston on the
/// shank is counted nonetheless, as many as there are returns of the drive.
#[test]
fn each_blow_on_a_string_as_long_as_a_period_counts() {
    let Scene { mut parameters, inputs } = top_hammer();
    (parameters.drill.rods, parameters.drill.rod.length) = (8, 6.1);
    parameters.mesh_for(Reading::Rate, 0.01).expect("a mesh").apply(&mut parameters);
    let mut m = Machine::new(&parameters, &inputs, 0.0).expect("a scene");
    m.keep_journal(true);
    m.advance(0.2).expect("a run");
    let back = Event::Relay(Relay::Return);
    let returns = m.take_journal().iter().filter(|record| record.event == back).count();
    assert!(returns >= 9 && m.counters().blows == returns as u64, "{returns} {:?}", m.counters());
}

/// The mesh advised for a rate preserves the blow's wave along any string, for any error asked for.
#[test]
fn the_advised_mesh_carries_the_wave_down_any_string() {
    let mut p = top_hammer().parameters;
    for (rods, stiffness, error) in [(1, 0.0, 0.3), (8, 0.0, 0.3), (8, 3e9, 0.3), (4, 0.0, 1e-3)] {
        (p.drill.rods, p.drill.joint.stiffness, p.drill.rod.length) = (rods, stiffness, 6.1);
        p.mesh_for(Reading::Rate, error).expect("a mesh").apply(&mut p);
        assert_eq!(p.validate(), Ok(()), "{rods} {stiffness} {error}");
    }
}
