//! Scaled scenes. Their motion is scaled to the bit, since the guards' resolutions are shares of the travel.

use crate::drawn::scenes::RandomScene;

/// The scene with every mass, stiffness, viscosity, force and `WR` times `a`.
pub fn heavier(case: &RandomScene, a: f64) -> RandomScene {
    let mut d = case.clone();
    let p = &mut d.parameters;
    // Scaling the section leaves density and modulus, and so the wave speed, as they are.
    p.cross_section *= a;
    let segments = p.piston.segments.iter_mut().chain(p.bit.segments.iter_mut());
    let segments = segments.chain(p.casing.segments.iter_mut());
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
