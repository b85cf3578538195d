//! Drawn scenes against the extended-precision reference. `COMPARE_SCENES` sets how many;
//! `cargo compare --scenes 5000` is the long form.

use verify::tally::{Kind, Tally, tally};

fn assert_agreement(kind: Kind, scenes: u32) {
    let wanted = std::env::var("COMPARE_SCENES").ok().and_then(|n| n.parse().ok());
    let tally: Tally = tally(wanted.unwrap_or(scenes), 0, kind, |_| ());
    let told = tally.failures.join("\n");
    assert!(tally.failures.is_empty(), "{}\n{told}", tally.line());
    // Scenes in which nothing could be compared would say nothing.
    assert!(tally.events > tally.scenes as usize, "{}", tally.line());
    assert!(5 * tally.refused < tally.scenes, "{}", tally.line());
}

#[test]
fn scenes_under_constant_loads_agree() {
    assert_agreement(Kind::Still, 40);
}

#[test]
fn scenes_with_changing_inputs_pressures_and_retuning_agree() {
    assert_agreement(Kind::Driven, 40);
}

#[test]
fn scenes_driven_by_chambers_agree() {
    assert_agreement(Kind::Chambers, 30);
}
