//! The report's rows, one test for each section: closed forms, exact waves, published benchmarks, measurements.

use verify::rows::measured;
use verify::rows::row::assert_all;

/// Declares a test for each section.
macro_rules! sections {
    ($($name:ident: $module:ident::$rows:ident),* $(,)?) => {
        $(#[test] fn $name() { assert_all(&verify::rows::$module::$rows().unwrap()); })*
    };
}

sections! {
    what_is_just_reached_is_told_from_what_is_just_missed: graze::rows,
    two_bars_exchange_momentum_as_saint_venant_says: closed::two_bars,
    a_bar_on_a_spring_has_the_tabulated_peak_and_contact_time: closed::springs,
    one_rectangular_pulse_leaves_the_rock_its_closed_form_share: closed::pulses,
    one_blow_on_virgin_rock_matches_the_exact_waves: closed::blows,
    sdnl111_a_bar_strikes_a_clamped_bar: assembly::clamped_bar,
    sdnd101_a_mass_on_a_spring_strikes_a_stop: assembly::mass_and_stop,
    shaped_pistons_are_as_efficient_as_lundberg_and_the_characteristics_say: shapes::efficiencies,
    a_stepped_piston_on_a_stepped_bit_has_the_plateaus_of_the_characteristics: shapes::stepped_impact,
    one_insert_on_two_rocks_moves_as_measured_with_one_stiffness_from_its_penetration: measured::rows,
    five_hammers_of_a_catalogue_have_the_power_that_is_published: catalogue::rows,
    a_relay_drives_a_viscous_piston_against_a_wall_at_the_closed_forms_speed: cycle::relay_viscous,
    a_relay_drives_a_piston_that_stops_dead_with_the_closed_forms_period: cycle::relay_dead,
    the_reference_hammer_settles_to_the_cycle_of_two_earlier_solvers: cycle::stationary,
    the_first_impact_comes_as_free_fall_says: cycle::first_impact,
    fifteen_cycles_follow_the_continuum: continuum::rows,
    observed_orders_of_one_blow_are_the_expected_ones: order::rows,
    a_blow_with_a_front_that_the_mesh_resolves_follows_exact_waves: order::resolved_blows,
    waves_go_up_an_elastic_casing_and_into_a_string_of_its_impedance: casing::waves,
    a_wave_comes_back_from_a_loose_joint_until_it_closes_and_passes_then: joints::waves,
    slack_leaves_its_part_of_a_blows_momentum_in_the_last_rod: joints::momentum_trapped,
    drawn_strings_carry_a_blow_as_the_characteristics_say: string::characteristics,
}

/// On a line of loading, depth is proportional to the square root of a blow's energy, and volume to the square of
/// depth. Barrier and viscosity take energy, which a stronger blow feels less.
#[test]
fn the_volume_broken_is_in_proportion_to_the_energy_of_the_blow() {
    let [slope, error] = measured::exponent(&measured::blows().unwrap());
    assert!(error < 0.02, "{error}");
    assert!((2.0 * slope - 1.0).abs() < 0.05, "{slope} +- {error}");
}
