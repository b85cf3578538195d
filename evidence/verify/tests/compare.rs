//! Drawn scenes against the extended-precision reference. `COMPARE_SCENES` sets how many;
//! `cargo compare --scenes 5000` is the long form.

use verify::tally::{Kind, Name, Tally, tally, these};

fn assert_agreement(kind: Kind, from: u32, scenes: u32) {
    let wanted = std::env::var("COMPARE_SCENES").ok().and_then(|n| n.parse().ok());
    let tally: Tally = tally(wanted.unwrap_or(scenes), from, kind, |_| ());
    let failures = [&tally.failures[..], &tally.unseen].concat();
    assert!(failures.is_empty(), "{}\n{}", tally.line(), failures.join("\n"));
    // Scenes in which nothing could be compared would say nothing.
    assert!(tally.events > tally.scenes as usize, "{}", tally.line());
    assert!(5 * tally.refused < tally.scenes, "{}", tally.line());
}

#[test]
fn scenes_under_constant_loads_agree() {
    assert_agreement(Kind::Still, 0, 40);
}

#[test]
fn scenes_with_changing_inputs_pressures_and_retuning_agree() {
    assert_agreement(Kind::Driven, 0, 40);
}

#[test]
fn scenes_driven_by_chambers_agree() {
    assert_agreement(Kind::Chambers, 0, 30);
}

#[test]
fn scenes_reloaded_along_the_unloading_line_agree() {
    assert_agreement(Kind::Reloading, 0, 40);
}

#[test]
fn scenes_with_a_casing_agree() {
    // The first has the light casing on a strong string whose roots once did not settle.
    assert_agreement(Kind::Casing, 0, 40);
    assert_agreement(Kind::ElasticCasing, 2, 40);
}

#[test]
fn scenes_with_loose_joints_agree() {
    assert_agreement(Kind::Joints, 0, 30);
}

fn compared(kind: Kind, names: &[&str]) -> Tally {
    let names: Vec<Name> = names.iter().map(|name| name.parse().expect("a name")).collect();
    let tally = these(&names, kind, false, |_| ());
    let apart = [&tally.failures[..], &tally.at_rest, &tally.unseen].concat();
    assert!(apart.is_empty(), "{}", apart.join("\n"));
    assert!(tally.events > 0 && tally.instants > names.len());
    tally
}

/// Scenes that disagreed once, each for the reason that a test is named after.
fn assert_these(kind: Kind, names: &[&str]) {
    let rough = compared(kind, names).rough;
    assert!(rough.is_empty(), "{}", rough.join("\n"));
}

/// A contact opened and closed again at one instant, or a rock's line turned back and forth, because
/// the rounding of a whole state lay beyond a guard whose own terms are small.
#[test]
fn what_a_transition_leaves_beyond_a_guard_is_no_crossing() {
    let names = ["2.85", "3.57", "8.37", "8.73", "10.11", "17.46", "22.45", "23.4", "42.57"];
    assert_these(Kind::Driven, &names);
}

/// The guard's zero was taken to be where it began, not where it came back.
#[test]
fn a_guard_that_begins_at_its_level_and_falls_crosses_when_it_is_back() {
    assert_these(Kind::Driven, &["22.84", "23.26", "45.31", "48.31"]);
}

/// A standing bit was moved by the rounding of a basis that had not changed.
#[test]
fn retuning_that_the_tip_does_not_feel_moves_nothing() {
    assert_these(Kind::Driven, &["29.83", "32.62"]);
}

/// A gain of nothing, rounded below zero, was less than the least gain of zero.
#[test]
fn a_cycle_that_gains_nothing_does_not_stand_still_where_the_least_gain_is_zero() {
    assert_these(Kind::Driven, &["23.3"]);
}

/// With `gamma` 3686 the depth of the hole was rounded into the force on the line of unloading.
#[test]
fn the_force_of_a_steep_unloading_does_not_feel_the_depth_of_the_hole() {
    assert_these(Kind::Driven, &["17.82"]);
}

/// Contact, chuck and rock attached to a bit that is lighter than piston and casing: the minors of
/// their matrix cancelled, and a state was off by 1e-12 of itself when it entered the basis.
#[test]
fn a_light_bit_between_heavy_bodies_keeps_its_digits() {
    assert_these(Kind::Casing, &["0.44", "2.4"]);
}

/// Hundreds of turns of joints without damping are chaotic: perturbed references that rounded numbers
/// and guards, but no state, stayed together where a run of theirs in doubles did not.
#[test]
fn chaotic_joints_are_compared_as_far_as_rounded_states_agree() {
    compared(Kind::Joints, &["1.47", "1.99"]);
}
