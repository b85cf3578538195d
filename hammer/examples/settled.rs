//! The reference hammer settled, in three rocks.
//!
//! `cargo run --release -p dth-hammer --example settled`

use hammer::{InputValues, Machine, Parameters};

fn main() -> Result<(), hammer::Error> {
    println!("  rock.stiffness   frequency   energy per blow       ROP");
    for factor in [0.5, 1.0, 2.0] {
        let mut parameters = Parameters::default();
        parameters.rock.stiffness *= factor;
        let mut hammer = Machine::new(&parameters, &InputValues::default(), 0.0)?;
        while hammer.counters().blows < 20 {
            hammer.advance(hammer.time() + 0.01)?;
        }
        let blow = hammer.blow().expect("twenty blows");
        println!(
            "{:10.0} MN/m {:8.2} Hz {:14.1} J {:10.2} m/h",
            1e-6 * parameters.rock.stiffness,
            1.0 / blow.period,
            blow.energy,
            3600.0 * blow.rop
        );
    }
    Ok(())
}
