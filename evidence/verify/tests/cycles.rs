//! Whole cycles.

use verify::row::assert_all;
use verify::{continuum, cycle};

#[test]
fn a_relay_drives_a_viscous_piston_against_a_wall_at_the_closed_forms_speed() {
    assert_all(&cycle::relay_viscous().unwrap());
}

#[test]
fn a_relay_drives_a_piston_that_stops_dead_with_the_closed_forms_period() {
    assert_all(&cycle::relay_dead().unwrap());
}

#[test]
fn mean_forces_balance_over_a_cycle() {
    assert_all(&cycle::mean_forces().unwrap());
}

#[test]
fn the_reference_hammer_settles_to_the_published_cycle() {
    assert_all(&cycle::stationary().unwrap());
}

#[test]
fn other_meshes_settle_to_the_published_cycles() {
    assert_all(&cycle::other_meshes().unwrap());
}

#[test]
fn the_first_impact_comes_as_free_fall_says() {
    assert_all(&cycle::first_impact().unwrap());
}

#[test]
fn fifteen_cycles_follow_the_continuum() {
    assert_all(&continuum::rows().unwrap());
}
