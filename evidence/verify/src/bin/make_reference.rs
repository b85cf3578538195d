//! Writes `evidence/oracles/data/reference_<elements>.json`, the oracle of the state errors.
//!
//! `cargo run --release -p verify --features programs --bin make-reference [elements ...]`

use hammer::InputValues;
use oracles::reference::{INSTANTS, MESHES, path, record};
use oracles::taylor::Accuracy;
use std::time::Instant;
use verify::{reference, scene};

const ACCURACIES: [Accuracy; 2] =
    [Accuracy { order: 40, tolerance: 1e-31 }, Accuracy { order: 34, tolerance: 1e-30 }];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut counts: Vec<usize> =
        std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    if counts.is_empty() {
        counts = MESHES.to_vec();
    }
    for elements in counts {
        let p = reference::hammer(elements);
        let scene = scene::finite_elements(&p, &InputValues::default());
        let clock = Instant::now();
        let record = record(&scene, &INSTANTS, ACCURACIES)?;
        println!(
            "{elements} elements: {} events, uncertainty {:.1e} of the states, {:.1e} s of the \
             events, {:.0} s",
            record.events.len(),
            record.state_uncertainty,
            record.event_uncertainty,
            clock.elapsed().as_secs_f64()
        );
        std::fs::write(path(elements), serde_json::to_string(&record)? + "\n")?;
    }
    Ok(())
}
