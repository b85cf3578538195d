//! The stored solutions of the reference hammer in extended precision.

use hammer::InputValues;
use oracles::dd::Dd;
use oracles::reference::{MESHES, stored};
use oracles::run::Run;
use oracles::taylor::Accuracy;
use verify::{reference, scene};

#[test]
fn the_stored_solutions_are_of_the_reference_hammer() {
    for elements in MESHES {
        let p = reference::hammer(elements);
        let mut wanted = scene::finite_elements(&p, &InputValues::default());
        let stored = stored(elements).unwrap().scene;
        // The stored resolution is a round number; no crossing is that shallow.
        for (stored, wanted) in stored.resolutions.iter().zip(wanted.resolutions) {
            assert!((stored - wanted).abs() < 0.1 * wanted, "{stored} {wanted}");
        }
        wanted.resolutions = stored.resolutions;
        assert_eq!(stored, wanted);
    }
}

#[test]
fn the_stored_reference_is_what_its_program_gives() {
    let record = stored(5).unwrap();
    let mut run = Run::<Dd>::new(&record.scene, Accuracy { order: 36, tolerance: 1e-28 });
    run.through(&[15e-3], &[]).unwrap();
    let known = record.states.iter().find(|s| s.time == 15e-3).unwrap();
    for (own, known) in run.samples[0].state.u.iter().zip(&known.u) {
        // The file holds the nearest double.
        assert!((own.hi - known).abs() <= f64::EPSILON * known.abs(), "{own:?} {known}");
    }
    for (own, known) in run.events.iter().zip(&record.events) {
        assert_eq!(own.event, known.event);
        let rest = (own.time.hi - known.time) + (own.time.lo - known.time_rest);
        assert!(rest.abs() < 1e-22, "{own:?}");
    }
}
