//! A process with limited memory.

#![cfg(target_os = "linux")]
#![allow(unsafe_code, reason = "forks and sets a limit")]

mod support;

use support::host::Host;
use support::library::{ERROR, Library, OK};
use support::three::{Three, extra};

const MEGABYTE: u64 = 1_000_000;

/// Address space that this process uses, bytes.
fn taken() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    let pages: u64 = text.split(' ').next().and_then(|n| n.parse().ok()).expect("a size");
    // SAFETY: asks for a number.
    pages * u64::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).expect("a page's size")
}

/// Status of a child that may use so many more bytes for `work`.
fn with_at_most(bytes: u64, work: impl FnOnce()) -> i32 {
    // SAFETY: the child uses the system's allocator, which may be used after a fork, and the code under test; it
    // exits without returning into the test.
    let child = unsafe { libc::fork() };
    assert!(child >= 0, "no fork");
    if child == 0 {
        let most = taken() + bytes;
        let limit = libc::rlimit { rlim_cur: most, rlim_max: most };
        // SAFETY: limits only this child.
        let set = unsafe { libc::setrlimit(libc::RLIMIT_AS, &raw const limit) };
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
        // SAFETY: ends the child.
        unsafe { libc::_exit(if done.is_ok() && set == 0 { 0 } else { 1 }) };
    }
    let mut status = 0;
    // SAFETY: our own child.
    assert_eq!(unsafe { libc::waitpid(child, &raw mut status, 0) }, child);
    status
}

/// A hammer on meshes with so many elements, before initialization.
fn fine(library: &Library, elements: i32) -> Host<'_> {
    let mesh = ["piston.elements", "bit.elements"].map(|name| (name, f64::from(elements)));
    let host = Host::with(library, &mesh);
    assert_eq!(library.set_up(host.handle, 0.0, None), OK);
    host.plain("fmi2EnterInitializationMode");
    host
}

#[test]
fn a_scene_that_does_not_fit_is_refused_by_name() {
    let library = Library::load();
    let ended = with_at_most(120 * MEGABYTE, || {
        let host = fine(&library, 400);
        assert_eq!(library.plain("fmi2ExitInitializationMode", host.handle), ERROR);
        let log = host.only_error();
        assert!(log.contains("400 elements of the piston, 400 elements of the bit"), "{log}");
        // A coarser one fits.
        drop(host);
        let host = fine(&library, 20);
        host.plain("fmi2ExitInitializationMode");
        host.step(0.0, 0.02);
    });
    assert_eq!(ended, 0, "the child's status");
}

/// With any limit, a scene is refused or has the memory it needs.
#[test]
fn no_limit_aborts() {
    let library = Library::load();
    for limit in [20, 40, 60, 80, 120, 160, 240] {
        let ended = with_at_most(limit * MEGABYTE, || {
            let host = fine(&library, 150);
            if library.plain("fmi2ExitInitializationMode", host.handle) == OK {
                host.step(0.0, 0.05);
                assert!(host.get("contact_count") > 0.0, "a blow");
                assert!(limit > 40, "{limit} MB cannot be enough");
            } else {
                assert!(host.only_error().contains("need up to"));
                assert!(limit < 240, "{limit} MB must be enough");
            }
        });
        assert_eq!(ended, 0, "the child's status at {limit} MB");
    }
}

/// Bytes that this process has from the system's allocator.
#[cfg(target_env = "gnu")]
fn allocated() -> usize {
    // SAFETY: asks for numbers.
    let info = unsafe { libc::mallinfo2() };
    info.uordblks + info.hblkhd
}

/// What the guide's questions and answers say of an instance's memory. Without a reader of energies the states of 120
/// blows wait, so that their memory is full twice in 12 s. The child has no other thread.
#[cfg(target_env = "gnu")]
#[test]
fn an_instance_takes_less_than_sixteen_megabytes_however_long_it_runs() {
    let library = Library::load();
    let ended = with_at_most(240 * MEGABYTE, || {
        let before = allocated();
        let host = Host::running(&library, &[]);
        for k in 0..120 {
            host.step(0.1 * f64::from(k), 0.1);
            assert!(allocated() - before < 16_000_000, "{} bytes", allocated() - before);
        }
        assert!(host.get("contact_count") > 240.0, "blows enough to fill it twice");
    });
    assert_eq!(ended, 0, "the child's status");
}

/// 800 arrays of 10,000 numbers take 64 MB. A read without room for them is refused before it computes them.
#[test]
fn arrays_without_room_are_refused_before_they_are_read() {
    let library = Library::load();
    let ended = with_at_most(50 * MEGABYTE, || {
        let host = Three::new(&library, false, false);
        host.calls(&["EnterConfigurationMode"]);
        host.set("UInt64", extra("waves.stations"), 10_000_u64);
        host.calls(&["ExitConfigurationMode"]);
        host.start(false);
        let status = host.access("GetFloat64", &[extra("piston_stress"); 800], &mut [0.0]);
        assert_eq!(status, ERROR);
        assert_eq!(host.only_error(), "nValues = 1, but these variables have 8000000 values");
    });
    assert_eq!(ended, 0, "the child's status");
}
