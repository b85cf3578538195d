//! Scaling laws on the reference hammer, exact: the resolutions of the guards are parts of the
//! travel and scale with it.

use crate::random_scene::RandomScene;
use crate::row::{Row, Rows};
use hammer::{Error, InputValues, Machine, Parameters, Record};

/// The reference hammer.
fn reference() -> RandomScene {
    let (parameters, inputs) = (Parameters::default(), InputValues::default());
    RandomScene { parameters, inputs, duration: 1.0, cuts: vec![], actions: Default::default() }
}

/// Two blows, s.
const SPAN: f64 = 0.1;

/// Events and the tip's place at the end.
fn run(case: &RandomScene) -> Result<(Vec<Record>, f64), Error> {
    let mut m = Machine::new(&case.parameters, &case.inputs, 0.0)?;
    m.keep_journal(true);
    m.advance(SPAN)?;
    Ok((m.take_journal(), m.kinematics().bit_tip_position))
}

/// Largest difference of an event's time; infinite if the events are others.
fn apart(a: &[Record], b: &[Record]) -> f64 {
    if a.len() != b.len() || a.iter().zip(b).any(|(x, y)| (x.event, x.mode) != (y.event, y.mode)) {
        return f64::INFINITY;
    }
    let off = |(x, y): (&Record, &Record)| ((x.time - y.time) + (x.time_rest - y.time_rest)).abs();
    a.iter().zip(b).map(off).fold(0.0, f64::max)
}

const EXACT: &str =
    "none: a power of two changes no digit of a product, a power of four none of a square root";

/// Closed form 7.
pub fn rows() -> Result<Vec<Row>, Error> {
    let scene = reference();
    let (events, tip) = run(&scene)?;
    let mut list = Vec::new();
    let heavier = [16.0, 1.0 / 64.0].map(|a| {
        let case = format!("two blows; masses, stiffnesses, viscosities, forces, WR times {a}");
        (case, heavier(&scene, a), ("place of the tip, m", 1.0))
    });
    let larger = [0.25, 2.0, 8.0].map(|b| {
        let case = format!("two blows; displacements, velocities, forces times {b}, WR times b^2");
        (case, larger(&scene, b), ("place of the tip / b, m", b))
    });
    for (case, scaled, (what, unit)) in heavier.into_iter().chain(larger) {
        let (ours, place) = run(&scaled)?;
        let mut rows = Rows::new(case, "scaling law", EXACT);
        rows.add("largest difference of an event's time, s", 0.0, apart(&events, &ours), 0.0);
        rows.add(what, tip, place / unit, 0.0);
        list.extend(rows.list);
    }
    Ok(list)
}

/// The scene with every mass, stiffness, viscosity, force and `WR` times `a`.
pub fn heavier(case: &RandomScene, a: f64) -> RandomScene {
    let mut d = case.clone();
    let p = &mut d.parameters;
    // Through the section: density and modulus keep the waves' speed.
    p.cross_section *= a;
    let segments = p.piston.segment.iter_mut().chain(&mut p.bit.segment);
    let segments = segments.chain(&mut p.casing.segment);
    segments.for_each(|segment| segment.area *= a);
    for x in [
        &mut p.contact.stiffness,
        &mut p.rock.stiffness,
        &mut p.rock.viscosity,
        &mut p.rock.energy_barrier,
        &mut p.drive.amplitude,
        &mut p.drive.area_drive,
        &mut p.drive.area_return,
        &mut p.drive.anvil_area,
        &mut p.casing.mass,
        &mut p.casing.impedance,
        &mut p.chuck.stiffness,
        &mut p.chuck.viscosity,
        &mut p.drill.shank.area,
        &mut p.drill.rod.area,
        &mut p.drill.coupling.area,
        &mut p.drill.joint.stiffness,
        &mut d.inputs.feed_force,
        &mut d.inputs.drive_force,
    ] {
        *x *= a;
    }
    d
}

/// The scene with every displacement, velocity and force times `b`, and `WR` times `b^2`.
pub fn larger(case: &RandomScene, b: f64) -> RandomScene {
    let mut d = case.clone();
    let p = &mut d.parameters;
    p.rock.energy_barrier *= b * b;
    for chamber in [&mut p.chambers.drive, &mut p.chambers.returning] {
        for port in [&mut chamber.supply, &mut chamber.exhaust] {
            port.position *= b;
            port.open_pressure *= b;
            port.shut_pressure *= b;
        }
    }
    for x in [
        &mut p.piston.initial_velocity,
        &mut p.contact.initial_gap,
        &mut p.rock.standstill_speed,
        &mut p.rock.standstill_penetration,
        &mut p.drive.amplitude,
        &mut p.drive.stroke,
        &mut p.chuck.travel,
        &mut p.chuck.idle_travel,
        &mut p.drill.joint.slack,
        &mut p.gravity,
        &mut d.inputs.feed_force,
        &mut d.inputs.drive_force,
        &mut d.inputs.drive_pressure,
        &mut d.inputs.return_pressure,
    ] {
        *x *= b;
    }
    d
}
