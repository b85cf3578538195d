//! Published benchmarks of another code.

use verify::assembly;
use verify::row::assert_all;

#[test]
fn sdnl111_a_bar_strikes_a_clamped_bar() {
    assert_all(&assembly::clamped_bar().unwrap());
}

#[test]
fn sdnd101_a_mass_on_a_spring_strikes_a_stop() {
    assert_all(&assembly::mass_and_stop().unwrap());
}
