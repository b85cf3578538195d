//! Published benchmarks and measurements.

use verify::row::assert_all;
use verify::{assembly, catalogue, measured, shapes};

#[test]
fn sdnl111_a_bar_strikes_a_clamped_bar() {
    assert_all(&assembly::clamped_bar().unwrap());
}

#[test]
fn sdnd101_a_mass_on_a_spring_strikes_a_stop() {
    assert_all(&assembly::mass_and_stop().unwrap());
}

#[test]
fn shaped_pistons_are_as_efficient_as_lundberg_and_the_characteristics_say() {
    assert_all(&shapes::efficiencies().unwrap());
}

#[test]
fn a_stepped_piston_on_a_stepped_bit_has_the_plateaus_of_the_characteristics() {
    assert_all(&shapes::stepped_impact().unwrap());
}

#[test]
fn one_insert_on_two_rocks_moves_as_measured_with_one_stiffness_from_its_penetration() {
    assert_all(&measured::rows().unwrap());
}

/// Depth goes like the square root of a blow's energy on a line of loading; the barrier and the
/// viscosity take what a stronger blow feels less. Volume goes like the depth squared.
#[test]
fn the_volume_broken_is_in_proportion_to_the_energy_of_the_blow() {
    let [slope, error] = measured::exponent(&measured::blows().unwrap());
    assert!(error < 0.02, "{error}");
    assert!((2.0 * slope - 1.0).abs() < 0.05, "{slope} +- {error}");
}

#[test]
fn five_hammers_of_a_catalogue_have_the_power_that_is_published() {
    assert_all(&catalogue::rows().unwrap());
}
