//! Derivatives of drawn scenes against differences in extended precision. `DERIVATIVE_SCENES` is their number;
//! `cargo compare --derivatives --scenes 1000` is the long form.

use verify::comparison::sensitivity::{GROUPS, tally};

#[test]
fn derivatives_are_those_of_extended_precision_within_the_errors_that_they_tell() {
    let scenes = std::env::var("DERIVATIVE_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(30);
    let tally = tally(scenes, 0, |_| ());
    assert!(tally.failures.is_empty(), "{}\n{}", tally.line(), tally.failures.join("\n"));
    // If nothing could be compared, the test would show nothing.
    assert!(tally.compared > 10 * scenes as usize, "{}", tally.line());
    assert!(10 * tally.fine > 9 * tally.compared, "{}", tally.line());
    for (name, held) in GROUPS.iter().zip(&tally.held) {
        // Each group must have enough derivatives.
        assert!(held.compared > scenes as usize, "{name}\n{}", tally.table());
        println!("{}", tally.table());
    }
}
