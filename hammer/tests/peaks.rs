//! The largest forces over a step, against the forces themselves.

use hammer::{InputValues, Machine, Parameters};

/// Where the first blow's contact force is largest, s, and the rock's force where
/// the tip turns: smooth maxima.
const BLOW: [[f64; 2]; 2] = [[0.01367, 0.01376], [0.01390, 0.01397]];

fn at(start: f64) -> Machine {
    let mut m =
        Machine::new(&Parameters::default(), &InputValues::default(), 0.0).expect("a scene");
    m.advance(start).expect("a step");
    m
}

/// `F_C` or `F_R`.
fn force(m: &Machine, which: usize) -> f64 {
    let k = m.kinematics();
    [k.contact_force, k.rock_force][which]
}

/// Instant and size of the largest of `n + 1` looks between two instants.
fn top([from, to]: [f64; 2], n: u32, which: usize) -> (f64, f64) {
    let mut m = at(from);
    let sample = |i| {
        let t = from + (to - from) * f64::from(i) / f64::from(n);
        m.advance(t).expect("a step");
        (t, force(&m, which))
    };
    (0..=n).map(sample).fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
}

/// Steps that begin anywhere before the maximum or end anywhere after it, a nanosecond or a
/// microsecond: it may lie at any place of the windows in which it is looked for, and at
/// either end of one.
#[test]
fn the_peak_of_a_step_is_found_wherever_the_step_begins_and_ends() {
    for which in 0..2 {
        // To 0.1 us, then to 0.1 ns: F'' is below 1e17 N/s2, so the maximum is 0.001 N higher
        // at the most.
        let (near, _) = top(BLOW[which], 2400, which);
        let (place, largest) = top([near - 1e-7, near + 1e-7], 2000, which);
        assert!(largest > 1e5, "{which}: the blow is not where it was");
        for k in 0..60 {
            let ahead = 1e-9 * 1.13f64.powi(k);
            for [from, to] in [[place - ahead, place + 1e-6], [place - 1e-6, place + ahead]] {
                let mut m = at(from);
                m.advance(to).expect("a step");
                let peak = [m.peaks().contact_force, m.peaks().rock_force][which];
                // 1e-13 m of 1e11 N/m that a window leaves out, and the look's own place.
                assert!((peak - largest).abs() < 0.02, "{which}, {from} to {to}: {peak} {largest}");
            }
        }
    }
}
