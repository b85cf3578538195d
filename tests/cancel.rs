//! Cancelling a step from another thread.

use crate::support::host::{Host, vr};
use crate::support::library::{ERROR, Handle, Library, OK};
use std::thread;
use std::time::{Duration, Instant};

/// Longest time from the call to the end of the step.
const PROMPT: Duration = Duration::from_millis(50);
/// Number of tries, since the machine may do other work.
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
            // Until the step has begun, there is nothing to cancel.
            let begun = loop {
                thread::sleep(Duration::from_millis(30));
                let now = Instant::now();
                if cancel(&library, host.handle) == OK {
                    break now;
                }
            };
            assert_eq!(step.join().unwrap(), ERROR);
            fastest = fastest.min(begun.elapsed());
        });
        let mut log = host.take_log();
        let (_, _, why) = log.pop().unwrap();
        assert!(why.ends_with("cancelled before it was done"), "{why}");
        assert!(log.iter().all(|(_, _, early)| early.contains("has nothing to cancel")), "{log:?}");
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

/// Calls `cancel` until it finds work to cancel, or `work` is over. Returns whether it was cancelled.
fn raced(host: &Host, work: impl FnOnce() -> i32 + Send) -> bool {
    let mut cancelled = false;
    let status = thread::scope(|scope| {
        let work = scope.spawn(work);
        while !cancelled && !work.is_finished() {
            thread::sleep(Duration::from_millis(1));
            cancelled = cancel(host.library, host.handle) == OK;
        }
        work.join().unwrap()
    });
    if status == ERROR {
        let (_, _, why) = host.take_log().pop().unwrap();
        assert!(cancelled && why == "cancelled before it was done", "{why}");
    }
    status == ERROR
}

/// With 400 elements in each body, making a scene takes a tenth of a second, and so do the forms by which an energy is
/// read for the first time.
#[test]
fn initialization_derivatives_and_reads_end_too_and_can_be_asked_for_again() {
    let library = Library::load();
    let directional: fn(&Library, Handle) -> i32 = |library, of| library.directional(of);
    let initialize: fn(&Library, Handle) -> i32 =
        |library, of| library.plain("fmi2ExitInitializationMode", of);
    let read: fn(&Library, Handle) -> i32 =
        |library, of| library.get_reals(of, &[vr("energy_damping")], &mut [0.0]);
    for (work, steps, shortest) in
        [(directional, false, 0.4), (initialize, false, 0.5), (read, true, 0.15)]
    {
        // Each with another length, so that no system is cached.
        let ends = |time: usize| {
            let length = ("piston.length", shortest + 1e-3 * time as f64);
            let fine = [("piston.elements", 400.0), ("bit.elements", 400.0), length];
            let host = Host::with(&library, &fine);
            host.plain("fmi2EnterInitializationMode");
            if steps {
                host.plain("fmi2ExitInitializationMode");
                // A step over the first blow.
                host.step(0.0, 0.0145);
            }
            let instance = host.handle;
            let ended = raced(&host, || work(&library, instance));
            if ended {
                assert_eq!(work(&library, instance), OK, "asked again: {:?}", host.take_log());
            }
            if steps {
                assert!(host.get("energy_damping") > 0.0);
                host.step(0.0145, 1e-3);
            }
            ended
        };
        assert!((0..TRIES).any(ends));
    }
}

#[test]
fn nothing_is_cancelled_where_no_step_is_under_way() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    assert_eq!(cancel(&library, host.handle), ERROR);
    assert!(host.only_error().starts_with("fmi2CancelStep has nothing to cancel: no other thread"));
    host.step(0.0, 1e-3);
    assert_eq!(cancel(&library, Handle(8)), ERROR);
}
