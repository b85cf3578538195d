//! A hammer that air drives.
use hammer::{Fidelity, InputValues, Machine, Parameters, Source};

#[test]
fn runs() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        let mut p = Parameters::default();
        p.drive.source = Source::Air;
        p.fidelity = fidelity;
        let start = std::time::Instant::now();
        let mut m = Machine::new(&p, &InputValues::default(), 0.0).unwrap();
        m.keep_journal(true);
        for i in 1..=300 {
            m.advance(i as f64 * 1e-3).unwrap();
            if i % 20 == 0 {
                println!("{i} {:?} x {:.5} F {:.1} p {:.4e} {:.4e} res {:e} {:e} air {:.5}", m.blow().map(|b| (b.time, b.speed, b.period, b.air_flow*60.0)), m.kinematics().relative_position, m.kinematics().applied_drive_force, m.chamber_pressures()[0][0], m.chamber_pressures()[1][0], m.energies().residual, m.air_residual(), m.air_mass()[0]);
            }
        }
        println!("{:?} {:?}", m.counters(), start.elapsed());
        for r in m.take_journal().iter().take(60) { println!("{:.6} {}", r.time, r.event); }
    }
}
