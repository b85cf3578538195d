//! Every event against the stored extended-precision solution.

use verify::peers;
use verify::row::assert_all;

#[test]
fn every_event_of_two_blows_is_that_of_the_extended_precision_solution() {
    assert_all(&peers::rows().unwrap());
}
