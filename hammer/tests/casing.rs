//! The hammer in its casing.

use hammer::{Fidelity, InputValues, Machine, Parameters};

fn cased(mass: f64, impedance: f64) -> Parameters {
    let mut p = Parameters::default();
    (p.casing.mass, p.casing.impedance) = (mass, impedance);
    p
}

#[test]
fn try_it() {
    for (fidelity, mass, z, feed) in [
        (Fidelity::Rigid, 40.0, 0.0, 5000.0),
        (Fidelity::Elastic, 40.0, 0.0, 5000.0),
        (Fidelity::Elastic, 40.0, 1e4, 5000.0),
        (Fidelity::Elastic, 40.0, 1e4, 2000.0),
        (Fidelity::Elastic, 40.0, 0.0, 2000.0),
    ] {
        let mut p = cased(mass, z);
        p.fidelity = fidelity;
        let inputs = InputValues { feed_force: feed, ..InputValues::default() };
        let mut m = Machine::new(&p, &inputs, 0.0).expect("a scene");
        println!("{:?} {:?}", m.mode(), m.kinematics().chuck_force);
        for k in 1..=10 {
            if let Err(e) = m.advance(0.1 * f64::from(k)) {
                println!("{e} at {}", m.time());
                break;
            }
        }
        println!("{fidelity:?} {z} {feed}: {:?}", m.energies());
        println!("turnover {:e} residual {:e}", m.energies().turnover(), m.energies().residual);
        println!("{:?} rop {:?}", m.counters(), m.blow());
        println!("{:?} {:?}", m.kinematics().casing_position, m.kinematics().bit_position);
    }
}
