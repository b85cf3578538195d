//! The motion of drawn scenes, one on a line, to compare two versions of the engine.
//!
//! `cargo journals > before`, and after a change that must keep every bit `cargo journals | diff before -`. A line
//! has the scene's name, the number of its events, and a hash of the bits of all event times and of the positions,
//! velocities and forces at the end.

use clap::Parser;
use verify::comparison::tally::{Kind, drawn};
use verify::drawn::actions::follow;

#[derive(Parser)]
#[command(about = "Prints a hash of the motion of drawn scenes")]
struct Arguments {
    /// Scenes of each kind
    #[arg(long, default_value_t = 100)]
    scenes: u32,
}

fn main() {
    let Arguments { scenes } = Arguments::parse();
    for (name, kind) in [("still", Kind::Still), ("mixed", Kind::Mixed)] {
        for (index, case) in drawn(kind, scenes).iter().enumerate() {
            println!("{name} {index} {}", motion(case).unwrap_or_else(|error| error.to_string()));
        }
    }
}

fn motion(case: &verify::drawn::scenes::RandomScene) -> Result<String, hammer::Error> {
    let schedule = case.schedule()?;
    let mut machine = hammer::Machine::new(&case.parameters, &case.inputs, 0.0)?;
    machine.keep_journal(true);
    follow(&mut machine, &case.parameters, &schedule, case.end())?;
    let journal = machine.take_journal();
    let k = machine.kinematics();
    let end = [
        k.piston.displacement,
        k.piston.velocity,
        k.bit.displacement,
        k.bit.velocity,
        k.tip.displacement,
        k.tip.velocity,
        k.contact_force,
        k.rock_force,
    ];
    let times = journal.iter().flat_map(|record| [record.time, record.time_rest]);
    // FNV-1a of 64 bits.
    let hash = times
        .chain(end)
        .flat_map(|x| x.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
    Ok(format!("{} events {hash:016x}", journal.len()))
}
