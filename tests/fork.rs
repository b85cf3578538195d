//! A process that forks while another of its threads works in the library, and signals that interrupt a step.

#![cfg(unix)]
#![allow(unsafe_code, reason = "forks")]

mod support;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use support::host::{Host, vr};
use support::library::{Handle, Library, OK};
use support::three::Three;

/// A child that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(20);

/// Makes new scenes, steps them, and takes and frees states.
fn work(library: &Library, first: u32, done: &AtomicBool) {
    for number in first.. {
        let host = Host::running(library, &[("rock.stiffness", 1e8 + f64::from(number))]);
        for step in 0..10 {
            host.step(f64::from(step) * 1e-3, 1e-3);
            let mut state = host.state();
            assert_eq!(library.free_state(host.handle, Some(&mut state)), OK);
        }
        if done.load(Ordering::Relaxed) {
            return;
        }
    }
}

/// Forks a child, which does `work` and exits with its result. Returns how it ended.
fn child(work: impl FnOnce() -> bool) -> Option<i32> {
    // SAFETY: the child uses the system's allocator, which may be used after a fork, and the code under test; it
    // exits without returning into the test.
    let child = unsafe { libc::fork() };
    assert!(child >= 0, "no fork");
    if child == 0 {
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
        // SAFETY: exits as a program does, including what libraries do at their end.
        unsafe { libc::exit(if matches!(done, Ok(true)) { 0 } else { 1 }) };
    }
    let (begun, mut status) = (Instant::now(), 0);
    loop {
        // SAFETY: our own child.
        let ended = unsafe { libc::waitpid(child, &raw mut status, libc::WNOHANG) };
        if ended == child {
            return Some(status);
        }
        if begun.elapsed() > PATIENCE {
            // SAFETY: our own child.
            unsafe {
                libc::kill(child, libc::SIGKILL);
                libc::waitpid(child, &raw mut status, 0);
            }
            return None;
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Forks many times while two threads work in the library.
fn fork_amid_work(number: usize, in_child: impl Fn(&Library) -> bool) {
    let (library, done) = (Library::load(), AtomicBool::new(false));
    thread::scope(|scope| {
        for first in [0, 1 << 20] {
            let (library, done) = (&library, &done);
            scope.spawn(move || work(library, first, done));
        }
        let mut ends = (0..number).map(|_| child(|| in_child(&library)));
        let wrong = ends.find(|end| *end != Some(0));
        done.store(true, Ordering::Relaxed);
        assert_eq!(wrong, None, "how the first child ended that did not end well");
    });
}

#[test]
fn a_child_that_only_exits_does() {
    fork_amid_work(100, |_| true);
}

#[test]
fn a_child_may_use_the_library() {
    fork_amid_work(60, |library| {
        let host = Host::running(library, &[("rock.stiffness", 1.5e8)]);
        host.step(0.0, 1e-3);
        let mut state = Handle(0);
        library.get_state(host.handle, Some(&mut state)) == OK
            && library.set_state(host.handle, state) == OK
            && library.free_state(host.handle, Some(&mut state)) == OK
            && library.step(host.handle, 1e-3, 1e-3) == OK
    });
}

#[test]
fn a_child_may_use_fmi_3_and_is_told_of_events() {
    fork_amid_work(50, |library| {
        let host = Three::new(library, true, true);
        host.set("Int64", vr("fidelity"), 1_i64); // Rigid: the first blow is soon found
        host.start(true);
        let ended = host.step(0.0, 0.1);
        host.event(|_, _| ());
        ended.early && host.try_step(ended.time, 1e-3).0 == OK
    });
}

#[test]
fn a_child_is_refused_what_a_thread_of_its_parent_was_stepping() {
    let library = Library::load();
    let host = Host::running(&library, &[]);
    let begun = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            begun.store(true, Ordering::Relaxed);
            host.step(0.0, 30.0);
        });
        while !begun.load(Ordering::Relaxed) {
            std::hint::spin_loop()
        }
        thread::sleep(Duration::from_millis(20));
        let refused = || library.get_reals(host.handle, &[0], &mut [0.0]) != OK;
        assert_eq!(child(refused), Some(0), "a step that no thread ends");
    });
}

/// What the handler reads, and how often it was refused.
static INTERRUPTED: OnceLock<(Library, Handle)> = OnceLock::new();
static REFUSED: AtomicUsize = AtomicUsize::new(0);
static ALARMS: AtomicUsize = AtomicUsize::new(0);
const MOST_ALARMS: usize = 20;

fn set_timer(milliseconds: libc::suseconds_t) {
    let interval = libc::timeval { tv_sec: 0, tv_usec: 1000 * milliseconds };
    let timer = libc::itimerval { it_interval: interval, it_value: interval };
    // SAFETY: a timer of the process; the previous one is not asked for.
    unsafe { libc::setitimer(libc::ITIMER_REAL, &raw const timer, std::ptr::null_mut()) };
}

extern "C" fn on_alarm(_: libc::c_int) {
    let Some((library, handle)) = INTERRUPTED.get() else { return };
    let refused = library.get_reals(*handle, &[0], &mut [0.0]) != OK;
    REFUSED.fetch_add(usize::from(refused), Ordering::Relaxed);
    if ALARMS.fetch_add(1, Ordering::Relaxed) + 1 == MOST_ALARMS {
        set_timer(0); // Before the step ends, so that every alarm finds it on its way.
    }
}

/// The handler runs on the thread that steps, and waiting for it would never end.
#[test]
fn a_handler_is_refused_the_instance_that_its_own_thread_is_stepping() {
    let interrupted = || {
        let library = Library::load();
        let handle = Host::running(&library, &[]).detach().handle;
        let (library, handle) = INTERRUPTED.get_or_init(|| (library, handle));
        // SAFETY: the handler calls the library alone, which is under test.
        unsafe { libc::signal(libc::SIGALRM, on_alarm as *const () as libc::sighandler_t) };
        set_timer(5);
        let mut point = 0.0;
        while ALARMS.load(Ordering::Relaxed) < MOST_ALARMS {
            if library.step(*handle, point, 20.0) != OK {
                return false;
            }
            point += 20.0;
        }
        REFUSED.load(Ordering::Relaxed) > MOST_ALARMS / 2
    };
    assert_eq!(child(interrupted), Some(0), "None: the handler waits for ever");
}
