//! Writes `evidence/oracles/data/reference_<elements>.json`, the oracle of the state errors.
//!
//! `cargo run --release -p oracles --bin make-reference [elements ...]`

use hammer::parameters::{InputValues, Parameters};
use oracles::model::Model;
use oracles::reference::record;
use oracles::taylor::Accuracy;
use std::time::Instant;

/// Six instants in the first 20 ms (the first blow is at 13.68 ms, the rebound at
/// 14.39 ms), one before the second blow and four after its start at 57.86 ms, s.
const INSTANTS: [f64; 11] =
    [10e-3, 13.72e-3, 14e-3, 15e-3, 17e-3, 20e-3, 46e-3, 58e-3, 59e-3, 62e-3, 70e-3];

const ACCURACIES: [Accuracy; 2] =
    [Accuracy { order: 40, tolerance: 1e-31 }, Accuracy { order: 34, tolerance: 1e-30 }];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut counts: Vec<usize> =
        std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    if counts.is_empty() {
        counts = vec![5, 10, 20, 40];
    }
    for elements in counts {
        let mut parameters = Parameters::default();
        (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
        let model = Model::new(&parameters, &InputValues::default());
        let clock = Instant::now();
        let record = record(&model, elements, &INSTANTS, ACCURACIES)?;
        println!(
            "{elements} elements: {} events, uncertainty {:.1e} of the states, {:.1e} s of the \
             events, {:.0} s",
            record.events.len(),
            record.state_uncertainty,
            record.event_uncertainty,
            clock.elapsed().as_secs_f64()
        );
        let path = format!("{}/data/reference_{elements}.json", env!("CARGO_MANIFEST_DIR"));
        std::fs::write(path, serde_json::to_string_pretty(&record)? + "\n")?;
    }
    Ok(())
}
