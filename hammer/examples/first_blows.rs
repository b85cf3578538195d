//! Cost of a scene before its cycle settles, for a profiler: two blows of the reference hammer and its energies. The first argument is the number of elements per bar, the second one how often this is done (1), each time with a hundredth more feed; from the second time on the decompositions are cached. A third argument is the degree of the bodies' splines (1).
//!
//! ```text
//! cargo build --release -p dth-hammer --example first_blows
//! valgrind --tool=callgrind target/release/examples/first_blows 100
//! valgrind --tool=callgrind target/release/examples/first_blows 100 2
//! valgrind --tool=callgrind target/release/examples/first_blows 20 2 3
//! ```

use hammer::{InputValues, Machine, Parameters, Vectors};

/// Communication step, s.
const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |at: usize, otherwise: u64| {
        std::env::args().nth(at).map_or(Ok(otherwise), |text| text.parse())
    };
    let (elements, times) = (number(1, 20)? as usize, number(2, 1)?);
    let mut parameters = Parameters::default();
    (parameters.piston.elements, parameters.bit.elements) = (elements, elements);
    parameters.mesh.degree = number(3, 1)? as usize;
    for time in 0..times {
        let mut inputs = InputValues::default();
        inputs.feed_force *= 1.0 + 0.01 * time as f64;
        let mut machine = Machine::new(&parameters, &inputs, 0.0)?;
        while machine.counters().blows < 2 {
            machine.advance(machine.time() + STEP)?;
        }
        println!("{} {:?} {:?}", Vectors::in_use(), machine.energies(), machine.counters());
    }
    Ok(())
}
