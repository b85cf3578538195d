//! Hard cases, each a test of its name.

use verify::hard_cases;

/// Declares a test a case, and one that no case is without.
macro_rules! cases {
    ($($name:ident),* $(,)?) => {
        $(#[test] fn $name() { hard_cases::assert_case(stringify!($name)); })*

        #[test]
        fn every_case_has_its_test() {
            let mut tested = vec![$(stringify!($name)),*];
            let mut made: Vec<&str> = hard_cases::all().iter().map(|c| c.name).collect();
            tested.sort_unstable();
            made.sort_unstable();
            assert_eq!(tested, made);
        }
    };
}

cases! {
    contact_twenty_times_the_element,
    contact_1e8,
    contact_1e9,
    contact_1e10,
    contact_1e12,
    contact_1e13,
    contact_1e15,
    undamped,
    undamped_fine,
    damping_1e9,
    damping_1e7,
    damping_1e6,
    overdamped,
    critical_bars,
    critical_rock,
    critical_tip,
    viscosity_impedance,
    viscosity_none,
    viscosity_1e9,
    barrier_none,
    barrier_huge,
    gamma_one,
    gamma_near_one,
    gamma_thousand,
    rock_1e5,
    rock_1e11,
    no_standstill,
    short_piston,
    long_piston,
    incommensurate,
    one_element,
    one_and_sixty,
    four_hundred,
    rigid,
    precursor,
    quiet_tip,
    zero_gravity,
    gravity_upward,
    feed_none,
    feed_negative,
    lifted_from_standstill,
    rests_for_good,
    rests_on_drive,
    resting_contact,
    all_at_once,
    creeping_flight,
    equal_bars_long,
    no_drive,
    swinging_drive,
    retuned_in_contact,
    step_of_ten_seconds,
    steps_of_a_nanosecond,
    steps_on_events,
    piston_touches_by_a_nanometre,
    piston_touches_by_a_picometre,
    piston_misses_by_a_picometre,
    piston_grazes,
    bit_reaches_rock,
    bit_misses_rock,
    bit_grazes_rock,
    barrier_just_met,
    barrier_just_missed,
    barrier_grazed,
}
