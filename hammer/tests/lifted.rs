//! An elastic casing that is lifted off the rock.

use crate::scenes::{cased, machine};
use hammer::Segment;

/// A lifted elastic casing is strained as in the acceleration that follows, so that it does not oscillate. Without a
/// string each of its nodes keeps the mean velocity, and the stress falls linearly from the feed at its top to zero
/// at the shoulder.
#[test]
fn a_lifted_elastic_casing_does_not_ring() {
    let mut p = cased();
    let (n, area, feed) = (8usize, 4e-3, -2e4);
    p.casing.elements = n;
    p.casing.segments.set(&[Segment { length: 1.2, area }]);
    let mut m = machine(&p, feed);
    for k in 0..5 {
        m.advance(2e-4 * f64::from(k)).expect("a flight");
        let (profile, at) = (m.profile(), m.kinematics());
        for [_, speed] in &profile.casing {
            // Some hundred roundings of the mean, and an oscillation by the rounding of the strains.
            assert!((speed - at.casing.velocity).abs() <= 1e-12, "{k}: {speed}");
        }
        for (i, stress) in profile.casing_stress.iter().enumerate() {
            let carried = feed * (1.0 - (i as f64 + 0.5) / n as f64);
            let rounding = 1e-17 * p.material.youngs_modulus * n as f64;
            let apart = (stress * area + carried).abs();
            assert!(apart <= 1e-10 * feed.abs() + rounding * area, "{k} {i}: {stress}");
        }
    }
}
