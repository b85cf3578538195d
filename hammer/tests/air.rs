//! A hammer that air drives.
use hammer::{Fidelity, InputValues, Machine, Parameters, Source};

#[test]
fn runs() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        let mut reference = vec![];
        for error in [1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6,1e-5] {
        let mut p = Parameters::default();
        p.drive.source = Source::Air;
        p.fidelity = fidelity;
        p.air.error = error;
        let mut m = Machine::new(&p, &InputValues::default(), 0.0).unwrap();
        m.keep_journal(true);
        let mut blows = vec![];
        let t0=std::time::Instant::now();
        for i in 1..=10 {
            m.advance(i as f64 * 30e-3).unwrap();
            blows.push(m.blow().map_or(1.0, |b| b.speed)); blows.push(m.blow().map_or(1.0,|b|b.air_flow+1.0));
        }
        if reference.is_empty() { reference = blows.clone(); }
        let err: Vec<String> = blows.iter().zip(&reference).map(|(a,b)| format!("{:.1e}", (a/b-1.0).abs())).collect();
        println!("{error:e} {:?} res {:e} {:e} {:?} {}", m.counters().events, m.energies().residual, m.air_residual(), t0.elapsed(), err.join(" "));
        }
    }
}
