//! A step that another thread ends.

mod support;

use std::thread;
use std::time::{Duration, Instant};
use support::host::Host;
use support::library::{ERROR, Handle, Library, OK};

/// From the call to the end of the step.
const PROMPT: Duration = Duration::from_millis(50);
/// As well on a machine that does other work.
const TRIES: usize = 10;

/// A host's handle, for a second thread.
fn cancel(library: &Library, handle: Handle) -> i32 {
    library.plain("fmi2CancelStep", handle)
}

#[test]
fn a_step_of_minutes_ends_at_once_and_the_instance_can_be_used_again() {
    let library = Library::load();
    let mut fastest = Duration::MAX;
    for _ in 0..TRIES {
        let host = Host::running(&library, &[]);
        thread::scope(|scope| {
            let step = scope.spawn(|| library.step(host.handle, 0.0, 1e3));
            thread::sleep(Duration::from_millis(30));
            let begun = Instant::now();
            assert_eq!(cancel(&library, host.handle), OK);
            assert_eq!(step.join().unwrap(), ERROR);
            fastest = fastest.min(begun.elapsed());
        });
        assert!(host.only_error().starts_with("the step was cancelled after t = "));
        assert_eq!(library.step(host.handle, 0.0, 1e-3), ERROR, "before a reset");
        host.only_error();
        host.plain("fmi2Reset");
        host.start(0.0);
        host.step(0.0, 0.02);
        let new = Host::running(&library, &[]);
        new.step(0.0, 0.02);
        assert_eq!(host.fingerprint(), new.fingerprint());
    }
    assert!(fastest < PROMPT, "{fastest:?}");
}

#[test]
fn nothing_is_cancelled_where_no_step_is_under_way() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    assert_eq!(cancel(&library, host.handle), ERROR);
    assert!(host.only_error().starts_with("fmi2CancelStep has nothing to cancel"));
    host.step(0.0, 1e-3);
    assert_eq!(cancel(&library, Handle(8)), ERROR);
}
