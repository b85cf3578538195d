//! Closed forms 1 to 4, by exact waves and by the engine.

use verify::closed;
use verify::row::assert_all;

#[test]
fn two_bars_exchange_momentum_as_saint_venant_says() {
    assert_all(&closed::two_bars().unwrap());
}

#[test]
fn a_bar_on_a_spring_has_the_tabulated_peak_and_contact_time() {
    assert_all(&closed::springs().unwrap());
}

#[test]
fn one_rectangular_pulse_leaves_the_rock_its_closed_form_share() {
    assert_all(&closed::pulses().unwrap());
}

#[test]
fn one_blow_on_virgin_rock_matches_the_exact_waves() {
    assert_all(&closed::blows().unwrap());
}
