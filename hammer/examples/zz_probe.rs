//! Probe.
use hammer::*;
use std::time::Instant;
fn main() {
    for (n, degree, beta, k, f, src) in [
        (1, 7, 2e-8, 1e6, 1e5, 0),
        (4, 7, 0.0, 1e6, 1e4, 0),
        (4, 7, 0.0, 1e8, 1e4, 0),
        (4, 3, 0.0, 1e8, 1e6, 0),
        (20, 3, 0.0, 1e6, 1e4, 0),
        (8, 1, 0.0, 1e8, 1e4, 0),
    ] {
        let mut p = Parameters::default();
        (p.piston.elements, p.bit.elements, p.mesh.degree) = (n, n, degree);
        p.material.damping_time = beta;
        if src == 0 {
            p.drive.source = Source::Force;
        }
        p.contact.stiffness = k * p.mesh_stiffness();
        let mut i = InputValues::default();
        i.drive_force = f;
        let Ok(mut m) = Machine::new(&p, &i, 0.0) else {
            println!("no");
            continue;
        };
        let t = Instant::now();
        let mut r = Ok(());
        let mut worst = (0, 0.0, t.elapsed());
        while m.time() < 0.1 && r.is_ok() && t.elapsed().as_secs() < 20 {
            let (c, w) = (m.counters(), Instant::now());
            r = m.advance(m.time() + 1e-3);
            let e = m.counters().events - c.events;
            if e > worst.0 {
                worst = (e, m.time(), w.elapsed())
            }
        }
        let c = m.counters();
        println!(
            "{n} {degree} {beta} {k}: {} {:?} {:?} windows {} ev {} t {:?} {} {worst:?}",
            c.events,
            r.map_err(|e| e.to_string()),
            m.time(),
            c.windows,
            c.guard_evaluations,
            t.elapsed(),
            p.contact.stiffness
        );
    }
}
