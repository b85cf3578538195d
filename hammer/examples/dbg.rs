use hammer::*;
fn main() {
    let t0 = std::time::Instant::now();
    let mut m = Machine::new(&Parameters::default(), &InputValues::default(), 0.0).unwrap();
    println!("new {:?}", t0.elapsed());
    let mut last = 0;
    let mut ev = 0;
    let n = std::env::args().nth(1).map_or(600, |x| x.parse().unwrap());
    let t0 = std::time::Instant::now();
    for i in 1..=n {
        if let Err(e) = m.advance(i as f64 * 1e-3) {
            println!("{e}");
            break;
        }
        if m.blow().time > 0. && m.counters().blows != last {
            last = m.counters().blows;
            let b = *m.blow();
            let c = m.counters();
            let e = m.energies();
            println!(
                "{i} t {:.9} v {:.5} T {:.6}ms rop {:.4} dur {:.3}us ev {} +{} contacts {} und {} samples {} evals {} win {} basis {} res {:e}",
                b.time,
                b.speed,
                b.period * 1e3,
                b.rop * 1e3,
                b.contact_duration * 1e6,
                c.events,
                c.events - ev,
                c.contacts,
                c.undecided,
                c.samples,
                c.guard_evaluations,
                c.windows,
                c.basis_changes,
                e.residual
            );
            ev = c.events;
        }
    }
    println!("run {:?} {:?}", t0.elapsed(), m.energies());
}
