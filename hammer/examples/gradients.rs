//! Derivatives for a profiler: of a run of 1 s of the reference hammer, read every 10 ms,
//! by as many parameters as the first argument says.

use hammer::Scene;
use hammer::sensitivity::{Argument, Sample, derivatives};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count = std::env::args().nth(1).map_or(Ok(0), |text| text.parse())?;
    let scene = Scene::default();
    // A relay reads no air, and there is no casing. The other arguments are in the order of the table.
    let absent = |a: &Argument| ["air.", "casing."].iter().any(|part| a.name().starts_with(part));
    let read = |a: &Argument| a.is_read(&scene.parameters) && !absent(a);
    let by: Vec<Argument> = Argument::all().filter(read).take(count).collect();
    let instants: Vec<f64> = (1..=100).map(|k| 0.01 * f64::from(k)).collect();
    let run = |scene: &Scene| {
        Sample::of_run(&mut scene.machine()?, &instants, &|m| vec![m.kinematics().tip_depth])
    };
    run(&scene)?;
    for (argument, row) in by.iter().zip(derivatives(&scene, &by, &run)?) {
        let (value, error) = (row.values[99], row.errors[99]);
        println!("{argument:?}: {value:e} +- {error:.0e}, reach {:.1e}", row.reach);
    }
    Ok(())
}
