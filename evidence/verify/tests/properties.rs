//! Properties over the whole domain. `PROPTEST_CASES` is the number of drawn scenes.

use verify::laws::properties::{Checked, PROPERTIES, check, check_mixed};

/// Scenes per property; the weekly run asks for 3,000.
fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(60)
}

fn assert_property(index: usize) {
    assert_checked(index, &check(&PROPERTIES[index], cases()));
}

fn assert_checked(index: usize, checked: &Checked) {
    assert!(
        checked.failures.is_empty(),
        "{}\n{}",
        PROPERTIES[index].0,
        checked.failures.join("\n")
    );
    // A property with mostly refused scenes would show nothing.
    let refused: u32 = checked.refused.iter().sum();
    assert!(10 * refused < checked.scenes, "{refused} of {} refused", checked.scenes);
}

#[test]
fn signs_losses_energy_and_work_keep_their_bounds() {
    assert_property(0);
}

#[test]
fn the_trajectory_does_not_depend_on_communication_points() {
    assert_property(1);
}

#[test]
fn a_saved_state_continues_bit_for_bit() {
    assert_property(2);
}

#[test]
fn a_heavier_scene_moves_bit_for_bit_alike() {
    assert_property(3);
}

#[test]
fn a_larger_scene_moves_bit_for_bit_that_much_further() {
    assert_property(4);
}

/// Any drive, casings, drill strings, and rock that is reloaded either way.
#[test]
fn scenes_with_everything_keep_every_property() {
    for (index, property) in PROPERTIES.iter().enumerate() {
        assert_checked(index, &check_mixed(property, cases().div_ceil(3)));
    }
}
