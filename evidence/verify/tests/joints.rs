//! Loose joints of a drill string.

use verify::joints;
use verify::row::assert_all;

#[test]
fn a_wave_comes_back_from_a_loose_joint_until_it_closes_and_passes_then() {
    assert_all(&joints::waves().unwrap());
}

#[test]
fn slack_leaves_its_part_of_a_blows_momentum_in_the_last_rod() {
    assert_all(&joints::momentum_trapped().unwrap());
}

#[test]
fn momentum_and_energy_balance_over_blows_that_open_joints() {
    assert_all(&joints::balances().unwrap());
}
