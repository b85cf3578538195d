//! The stored solutions of the reference hammer in extended precision.

use hammer::InputValues;
use oracles::dd::Dd;
use oracles::reference::{ELEMENTS, distance, stored};
use oracles::run::Run;
use oracles::taylor::Accuracy;
use verify::{reference, scene};

#[test]
fn the_stored_solution_is_the_reference_hammers() {
    let stored = stored().unwrap();
    let hammer = reference::overdamped(ELEMENTS);
    assert_eq!(stored.scene, scene::finite_elements(&hammer, &InputValues::default()));
    let mut run = Run::<Dd>::new(&stored.scene, Accuracy { order: 36, tolerance: 1e-28 });
    run.through(&[15e-3], &[]).unwrap();
    let known = stored.states.iter().find(|sample| sample.time == 15e-3).unwrap();
    let off = distance(&run.samples[0].state, &known.state);
    // Some thousand steps of that tolerance, and rounding that some dozen events multiply.
    assert!(off < 1e-20, "{off:e}");
    for (own, known) in run.events.iter().zip(&stored.events) {
        assert_eq!((own.event, own.mode), (known.event, known.mode));
        assert!((own.time - known.time).hi.abs() < 1e-22, "{own:?}");
    }
}
