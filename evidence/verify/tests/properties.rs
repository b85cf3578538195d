//! Properties over the whole domain. `PROPTEST_CASES` sets how many scenes are drawn.

use verify::properties::{Checked, PROPERTIES, check, check_cased, check_chambers, check_jointed};

/// Three hundred scenes per property, unless more are asked for.
fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
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
    // A property of which most scenes are refused would say nothing.
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

/// Few scenes: what is new of them is the drive alone. Sixty per property hold as well.
#[test]
fn scenes_driven_by_chambers_keep_every_property() {
    for (index, property) in PROPERTIES.iter().enumerate() {
        assert_checked(index, &check_chambers(property, cases().div_ceil(30)));
    }
}

/// A third body, its ties, and the drive's reaction on it.
#[test]
fn scenes_with_a_casing_keep_every_property() {
    for (index, property) in PROPERTIES.iter().enumerate() {
        assert_checked(index, &check_cased(property, cases().div_ceil(6)));
    }
}

/// Bodies that part and meet in the string, each pair by a guard of its own.
#[test]
fn scenes_with_loose_joints_keep_every_property() {
    for (index, property) in PROPERTIES.iter().enumerate() {
        assert_checked(index, &check_jointed(property, cases().div_ceil(10)));
    }
}
