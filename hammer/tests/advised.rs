//! Advise a mesh, then run on it: every system that a scene can meet has its modes, also where equal bars
//! have each frequency twice and the splines' last modes hardly feel what ties the bodies.

use hammer::laws::event::Bodies;
use hammer::laws::rock::Spring;
use hammer::modal::model::Model;
use hammer::presets::PRESETS;
use hammer::scene::graph::Group;
use hammer::{InputValues, Machine, Mode, Parameters, Reading, RockMode, Segment};

/// Every kind of casing on the mesh that is advised for a force within a thousandth, and a feed that
/// holds it down.
fn cased(p: &Parameters, elastic: bool, impedance: f64) -> Option<(Parameters, InputValues)> {
    let mut p = *p;
    (p.casing.mass, p.casing.impedance) = (40.0, impedance);
    if elastic {
        p.casing.segments = 1;
        p.casing.segment[0] = Segment { length: 1.0, area: 5e-3 };
    }
    let mesh = p.mesh_for(Reading::Force, 1e-3)?;
    mesh.apply(&mut p);
    let inputs = InputValues { feed_force: p.drive.amplitude + 5e3, ..InputValues::default() };
    Some((p, inputs))
}

/// All springs at the tip, contact and chuck closed or open. Each system is refused unless its basis and
/// the inverse of that fit to 1e-5.
fn decompose(p: &Parameters, name: &str) {
    let model = Model::new(p).expect("a model");
    let mode = Mode::starting(RockMode::Forward);
    let (bit, piston, casing) = (Bodies::STRUCK, Bodies::PISTON, Bodies::one(model.graph.frame));
    for spring in Spring::ALL {
        for bodies in [bit, bit.and(piston), bit.and(casing), model.graph.all()] {
            let system = model.system(Group { bodies, spring: Some(spring) }, mode);
            assert!(system.is_ok(), "{name} {bodies:?} {spring:?}: {}", system.unwrap_err());
        }
    }
}

#[test]
fn every_preset_in_any_casing_runs_on_the_mesh_that_is_advised() {
    let (mut runs, mut all) = (0, 0);
    for preset in PRESETS {
        let (start, _) = preset.start();
        if start.drill.rods > 0 {
            continue; // It has no casing.
        }
        for elastic in [false, true] {
            for impedance in [0.0, 4e3] {
                let name = format!("{}, elastic {elastic}, string {impedance}", preset.name);
                all += 1;
                let Some((p, inputs)) = cased(&start, elastic, impedance) else { continue };
                decompose(&p, &name);
                let mut machine = Machine::new(&p, &inputs, 0.0).expect("a scene");
                // The first blow and what follows of it.
                while machine.blow().is_none() {
                    let next = machine.time() + 2e-3;
                    machine.advance(next).unwrap_or_else(|error| panic!("{name}: {error}"));
                    assert!(next < 0.2, "{name}: no blow");
                }
                let energies = machine.energies();
                // As in `casing.rs`.
                let bound = 1e-10 * energies.turnover();
                assert!(energies.residual.abs() <= bound, "{name}: {energies:?}");
                runs += 1;
            }
        }
    }
    assert!(all >= 32 && 10 * runs >= 9 * all, "{runs} of {all}");
}
