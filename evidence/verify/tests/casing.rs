//! The hammer in its casing.

use verify::casing;
use verify::row::assert_all;

#[test]
fn a_hammer_rests_in_equilibrium_under_feed_weights_and_the_drives_reaction() {
    assert_all(&casing::statics().unwrap());
}

#[test]
fn waves_go_up_an_elastic_casing_and_into_a_string_of_its_impedance() {
    assert_all(&casing::waves().unwrap());
}

#[test]
fn momentum_of_three_bodies_is_what_feed_weight_rock_and_string_gave() {
    assert_all(&casing::momentum().unwrap());
}

#[test]
fn mean_forces_on_casing_and_bit_balance_over_a_cycle() {
    assert_all(&casing::mean_forces().unwrap());
}
