//! Settled cycles of the reference hammer, for a profiler: 12 blows to settle, then as many cycles as the first argument says, in communication steps of 1 ms. With `count` it counts the instructions of a cycle by valgrind: `cargo work-per-cycle`.
//!
//! Further arguments: `energies` reads the energies at every step; `rigid`, or a number of elements per bar, changes
//! the bodies; `air` drives the piston by air; `preset=NAME` is another hammer; `loose` weakens the joints of its rods;
//! `casing` adds one of 40 kg; `AVX2` and the like choose the vectors.

mod callgrind;

use callgrind::instructions;
use hammer::presets::Preset;
use hammer::{Fidelity, InputValues, Machine, Parameters, Scene, Source, Vectors};

/// Blows until the cycle repeats.
const SETTLED: u64 = 12;
/// Communication step, s.
const STEP: f64 = 1e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if words.first().is_some_and(|word| word == "count") {
        let [none, ten] = [instructions(0, &words[1..])?, instructions(10, &words[1..])?];
        println!("{} instructions per settled cycle", (ten - none) / 10);
        return Ok(());
    }
    let cycles: u64 = std::env::args().nth(1).map_or(Ok(20), |text| text.parse())?;
    let (mut parameters, mut inputs) = (Parameters::default(), InputValues::default());
    let mut asked = false;
    for word in std::env::args().skip(2) {
        match word.as_str() {
            "energies" => asked = true,
            "rigid" => parameters.fidelity = Fidelity::Rigid,
            "air" => parameters.drive.source = Source::Air,
            "loose" => parameters.drill.joint.stiffness = 3e9,
            "casing" => parameters.casing.mass = 40.0,
            _ if word.starts_with("preset=") => {
                let preset = Preset::named(&word["preset=".len()..]).ok_or("no such preset")?;
                Scene { parameters, inputs } = preset.start();
            }
            _ if Vectors::available().any(|v| v.to_string() == word && v.select()) => {}
            elements => {
                parameters.piston.elements = elements.parse()?;
                parameters.bit.elements = elements.parse()?;
            }
        }
    }
    let mut machine = Machine::new(&parameters, &inputs, 0.0)?;
    while machine.counters().blows < SETTLED + cycles {
        machine.advance(machine.time() + STEP)?;
        if asked {
            std::hint::black_box(machine.energies());
        }
    }
    println!("{} {:?}", Vectors::in_use(), machine.counters());
    Ok(())
}
