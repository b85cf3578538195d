//! Drill strings.

use verify::row::assert_all;
use verify::string;

#[test]
fn drawn_strings_carry_a_blow_as_the_characteristics_say() {
    assert_all(&string::characteristics().unwrap());
}

#[test]
fn couplings_let_through_what_their_transfer_matrices_say_and_bare_rods_all() {
    assert_all(&string::joints().unwrap());
}
