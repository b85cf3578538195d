//! Drawn scenes against the extended-precision reference. `COMPARE_SCENES` sets how many;
//! `cargo compare --scenes 5000` is the long form.

use verify::compare::{Tally, tally};

fn scenes() -> u32 {
    std::env::var("COMPARE_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(40)
}

fn assert_agreement(driven: bool) {
    let tally: Tally = tally(scenes(), 0, driven, |_| ());
    let told = tally.failures.join("\n");
    assert!(tally.failures.is_empty(), "{}\n{told}", tally.line());
    // Scenes in which nothing could be compared would say nothing.
    assert!(tally.events > tally.scenes as usize, "{}", tally.line());
    assert!(5 * tally.refused < tally.scenes, "{}", tally.line());
}

#[test]
fn scenes_under_constant_loads_agree() {
    assert_agreement(false);
}

#[test]
fn scenes_with_changing_inputs_pressures_and_retuning_agree() {
    assert_agreement(true);
}
