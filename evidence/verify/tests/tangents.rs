//! Derivatives of drawn scenes against differences in extended precision;
//! `TANGENT_SCENES` sets how many; `cargo compare --tangents --scenes 1000` is the long form.

use verify::tangent::tally;

#[test]
fn derivatives_are_differences_in_extended_precision() {
    let scenes = std::env::var("TANGENT_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(30);
    let tally = tally(scenes, 0, |_| ());
    assert!(tally.failures.is_empty(), "{}\n{}", tally.line(), tally.failures.join("\n"));
    // Scenes in which nothing could be compared would say nothing.
    assert!(tally.compared > 10 * scenes as usize, "{}", tally.line());
}
