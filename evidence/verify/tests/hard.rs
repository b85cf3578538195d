//! Hard cases, each a test of its name.

use verify::laws::hard::cases;

/// Declares a test a case, and one that no case is without.
macro_rules! cases {
    ($($name:ident),* $(,)?) => {
        $(#[test] fn $name() { cases::assert_case(stringify!($name)); })*

        #[test]
        fn every_case_has_its_test() {
            let mut tested = vec![$(stringify!($name)),*];
            let mut made: Vec<&str> = cases::all().iter().map(|c| c.name).collect();
            tested.sort_unstable();
            made.sort_unstable();
            assert_eq!(tested, made);
        }
    };
}

cases! {
    critical_bars,
    critical_rock,
    critical_tip,
    four_hundred,
    quiet_tip,
    lifted_from_standstill,
    rests_for_good,
    rests_on_drive,
    all_at_once,
    creeping_flight,
    swinging_drive,
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
