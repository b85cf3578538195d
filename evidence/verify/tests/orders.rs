//! Errors fall with the mesh as fast as theory says.

use verify::row::assert_all;
use verify::{order, spectral};

#[test]
fn observed_orders_of_one_blow_are_the_expected_ones() {
    assert_all(&order::rows().unwrap());
}

#[test]
fn a_blow_with_a_front_that_the_mesh_resolves_follows_exact_waves() {
    assert_all(&order::resolved_blows().unwrap());
}

#[test]
fn splines_tend_to_what_spectral_elements_say_in_the_order_of_theory() {
    assert_all(&spectral::rows().unwrap());
}
