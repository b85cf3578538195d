//! Properties over the whole domain. `PROPTEST_CASES` sets how many scenes are drawn.

use proptest::prelude::*;
use verify::properties::*;

/// A few hundred scenes over all properties, unless more are asked for.
fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn signs_losses_energy_and_work_keep_their_bounds(draw in draw()) {
        if let Err(fault) = keeps_the_laws(&draw) {
            prop_assert!(false, "{fault}");
        }
    }

    #[test]
    fn the_trajectory_does_not_depend_on_communication_points(draw in draw()) {
        prop_assert!(slices_alike(&draw).unwrap());
    }

    #[test]
    fn a_saved_state_continues_bit_for_bit(draw in draw()) {
        prop_assert!(restores(&draw).unwrap());
    }

    /// Masses enter by their square roots: a power of four changes no digit.
    #[test]
    fn a_heavier_scene_moves_bit_for_bit_alike(draw in draw(), power in -6i32..6) {
        let a = 4f64.powi(power);
        prop_assert_eq!(scaled_apart(&draw, &heavier(&draw, a), 1.0).unwrap(), Some(0.0));
    }
}
