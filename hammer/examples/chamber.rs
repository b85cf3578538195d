//! A hammer driven by a custom chamber. Its pressure is a force that depends on the piston's position,
//! set from step to step as a polynomial of time.
//!
//! `cargo run --release -p dth-hammer --example chamber`

use hammer::{Input, InputValues, Machine, Parameters, PointMotion, Source};

/// Communication step, s. The force is linear over it.
const STEP: f64 = 2e-5;
/// Pressure in the chamber at rest, times its area, N; and the stroke of the piston that doubles it, m.
const FORCE: f64 = 1500.0;
const DEPTH: f64 = 0.08;

/// Force on the piston and its rate: adiabatic compression (exponent 1.4) on the way up, full supply on the way down.
fn chamber(position: f64, velocity: f64) -> [f64; 2] {
    let room = (DEPTH + position).max(0.1 * DEPTH);
    let force = FORCE * (DEPTH / room).powf(1.4);
    [force - 2.2 * FORCE * f64::from(velocity < 0.0), -1.4 * force * velocity / room]
}

fn main() -> Result<(), hammer::Error> {
    let mut parameters = Parameters::default();
    parameters.drive.source = Source::Force;
    let mut hammer = Machine::new(&parameters, &InputValues::default(), 0.0)?;
    for step in 1..=25_000 {
        let PointMotion { displacement: x, velocity: v, .. } = hammer.kinematics().relative;
        hammer.set_input(Input::DriveForce, &chamber(x, v))?;
        hammer.advance(f64::from(step) * STEP)?;
    }
    let (blow, energies) = (hammer.blow().expect("blows"), hammer.energies());
    println!("{} blows, the last of {:.0} J", hammer.counters().blows, blow.energy);
    println!("work of the chamber {:.1} J, residual {:.0e} J", energies.drive, energies.residual);
    Ok(())
}
