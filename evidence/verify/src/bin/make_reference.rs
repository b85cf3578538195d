//! Writes what [`oracles::reference::stored`] reads:
//! `cargo run --release -p verify --features programs --bin make-reference`.

use hammer::InputValues;
use oracles::reference::{ELEMENTS, INSTANTS, STORED, solve};
use oracles::taylor::Accuracy;
use support::run::checkout;
use verify::{reference, scene};

const ACCURACIES: [Accuracy; 2] =
    [Accuracy { order: 40, tolerance: 1e-31 }, Accuracy { order: 34, tolerance: 1e-30 }];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hammer = reference::overdamped(ELEMENTS);
    let scene = scene::finite_elements(&hammer, &InputValues::default());
    let solution = solve(&scene, &INSTANTS, ACCURACIES)?;
    println!("{} events, states to {:.1e}", solution.events.len(), solution.uncertainty);
    std::fs::write(checkout().join(STORED), serde_json::to_string(&solution)? + "\n")?;
    Ok(())
}
