//! Published benchmarks and measurements.

use verify::assembly;
use verify::row::assert_all;
use verify::shapes;

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
fn a_drill_test_is_met_to_a_tenth() {
    assert_all(&shapes::drill_test().unwrap());
}
