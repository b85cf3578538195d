//! A hammer whose casing is lifted off the rock: at the start, later, and with a vented drive.

use crate::scenes::{cased, machine};
use hammer::{Fidelity, Parameters, RockMode, Segment, Tie, TieState};

/// A casing that nothing carries begins at rest, and the string brakes it: `Mc v' = FS + Mc G - F_A - Zs v`, in
/// closed form until the ring catches the bit.
#[test]
fn a_casing_that_is_lifted_at_the_start_accelerates_from_rest() {
    for fidelity in [Fidelity::Rigid, Fidelity::Elastic] {
        for (impedance, gravity) in [(0.0, 9.81), (3e3, 9.81), (3e5, 9.81), (3e3, 0.0)] {
            let mut p = Parameters { fidelity, gravity, ..cased() };
            p.casing.impedance = impedance;
            let load = -2e4 + p.casing.mass * gravity - p.drive.amplitude;
            let mut m = machine(&p, -2e4);
            let (mode, at) = (m.mode(), *m.kinematics());
            let rock = if gravity > 0.0 { RockMode::Standstill } else { RockMode::FreeFlight };
            assert_eq!((mode.ties.of(Tie::Chuck), mode.rock), (TieState::Open, rock));
            assert_eq!((at.bit.velocity, at.chuck_force), (0.0, 0.0));
            // Rounding of the speed that the string would lead to.
            let terminal = if impedance == 0.0 { 0.0 } else { load / impedance };
            assert!(at.casing.velocity.abs() <= 1e-14 * terminal.abs(), "{}", at.casing.velocity);
            // Some roundings of the weight.
            assert!((at.rock_force - p.bit_mass() * gravity).abs() <= 1e-12 * at.rock_force);
            for k in 1..=4 {
                let t = 1e-3 * f64::from(k);
                m.advance(t).expect("a flight");
                let rate = impedance / p.casing.mass;
                let speed = match impedance {
                    0.0 => load / p.casing.mass * t,
                    _ => -load / impedance * (-rate * t).exp_m1(),
                };
                // Some hundred roundings of the speed that the load could reach.
                let reach = if impedance == 0.0 { speed } else { load / impedance };
                let apart = (m.kinematics().casing.velocity - speed).abs();
                assert!(apart <= 1e-14 * reach.abs(), "{impedance} {t}: {apart:e}");
                assert_eq!(m.mode().ties.of(Tie::Chuck), TieState::Open);
            }
            let energies = m.energies();
            assert!(energies.residual.abs() <= 1e-10 * energies.turnover(), "{energies:?}");
        }
    }
}

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
