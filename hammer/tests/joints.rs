//! Loose joints of a drill string.

use hammer::sensitivity::Scene;
use hammer::presets::PRESETS;

#[test]
fn look() {
    for (rods, elements, stiffness, slack) in [(1, 60, 1e9, 0.0), (1, 60, 1e9, 1e-4), (4, 190, 2e9, 3e-4)] {
        let preset = PRESETS.iter().find(|preset| preset.name == "top_hammer").expect("a preset");
        let (parameters, inputs) = preset.start();
        let mut scene = Scene { parameters, inputs };
        let p = &mut scene.parameters;
        p.drill.rods = rods;
        p.bit.elements = elements;
        p.drill.joint.stiffness = stiffness;
        p.drill.joint.slack = slack;
        let started = std::time::Instant::now();
        let mut m = scene.machine().unwrap();
        m.keep_journal(true);
        println!("{rods} {slack}: made {:?}", started.elapsed());
        for k in 1..=20 {
            if let Err(e) = m.advance(0.01 * f64::from(k)) { println!("{e}"); break; }
            let e = m.energies();
            println!("{k} {:?} events {} blows {} hole {:e} residual {:e} bound {:e}", started.elapsed(), m.counters().events, m.counters().blows, m.kinematics().hole_depth, e.residual, e.residual_bound());
        }
        let journal = m.take_journal();
        for r in journal.iter().take(60) { println!("{:.9} {} [{}]", r.time, r.event, r.mode); }
    }
}
