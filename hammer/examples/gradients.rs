//! Settled cycles of the reference hammer with derivatives, for a profiler: 12 blows to settle,
//! then as many cycles as the first argument says, with as many parameters as the second.

use hammer::tangent::{Parameter, Seed, Tangents};
use hammer::{InputValues, Machine, Parameters};

/// Blows until the cycle repeats.
const SETTLED: u64 = 12;
/// Communication step, s.
const STEP: f64 = 1e-3;
/// The rock's first: what one calibrates by.
const FIRST: [Parameter; 5] = [
    Parameter::RockStiffness,
    Parameter::UnloadingRatio,
    Parameter::RockViscosity,
    Parameter::EnergyBarrier,
    Parameter::DriveAmplitude,
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |k: usize, default: u64| {
        std::env::args().nth(k).map_or(Ok(default), |text| text.parse::<u64>())
    };
    let (cycles, count) = (number(1, 20)?, number(2, 0)? as usize);
    let others = Parameter::ALL.iter().filter(|p| !FIRST.contains(p));
    let seeds: Vec<Seed> =
        FIRST.iter().chain(others).take(count).map(|p| Seed::Parameter(*p)).collect();
    let mut machine = Machine::new(&Parameters::default(), &InputValues::default(), 0.0)?;
    while machine.counters().blows < SETTLED {
        machine.advance(machine.time() + STEP)?;
    }
    let mut tangents = Tangents::from_here(&machine, &seeds)?;
    while machine.counters().blows < SETTLED + cycles {
        let to = machine.time() + STEP;
        if seeds.is_empty() {
            machine.advance(to)?;
        } else {
            tangents.advance(&mut machine, to)?;
        }
    }
    std::hint::black_box(tangents.look(&machine));
    println!("{} parameters, {:?}", seeds.len(), machine.counters());
    Ok(())
}
