//! Calls that no host should make, but some do. Nothing may crash, hang, or disturb another, correct instance.

mod abuser;
mod support;

use abuser::three::ThreeAbuser;
use abuser::watchdog::SLOWER;
use abuser::{Abuser, Watchdog};
use dth_hammer::CAPACITY;
use hammer::variables::{Role, VARIABLES};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use std::process::Command;
use std::thread;
use support::host::{Host, vr};
use support::library::{ERROR, Library, Log, OK};
use support::three::Three;

/// Environment variable with the number of calls: fewer under valgrind, more every week.
const CALLS: &str = "DTH_ABUSE_CALLS";

fn calls() -> usize {
    std::env::var(CALLS).ok().and_then(|calls| calls.parse().ok()).unwrap_or(12_000)
}

/// Makes so many calls, with a step of 1 ms at every 200th. Returns the number of steps.
fn among(calls: usize, mut act: impl FnMut(), mut step: impl FnMut(f64)) -> u32 {
    let mut steps = 0;
    for call in 0..calls {
        act();
        if call % 200 == 0 {
            step(f64::from(steps) * 1e-3);
            steps += 1;
        }
    }
    steps
}

#[test]
fn random_calls_neither_crash_nor_hang_nor_disturb_a_neighbour() {
    let calls = calls();
    let library = Library::load();
    let [alone, beside] = [(); 2].map(|()| Host::running(&library, &[]));
    let log = Log::default();
    let mut abuser = Abuser::new(&library, &log, ChaCha8Rng::seed_from_u64(20_261_121));
    let dog = Watchdog::new();
    let steps = among(calls, || abuser.act(&dog), |point| beside.step(point, 1e-3));
    let accepted = abuser.accepted;
    abuser.clean_up();
    for step in 0..steps {
        alone.step(f64::from(step) * 1e-3, 1e-3);
    }
    assert_eq!(alone.fingerprint(), beside.fingerprint());
    println!("{calls} random calls, {accepted} of them accepted");
    assert!(accepted > calls / 4 && accepted < calls * 9 / 10, "the mixture is lopsided");
}

#[test]
fn random_calls_of_fmi_3_neither_crash_nor_hang_nor_disturb_a_neighbour() {
    let library = Library::load();
    let [alone, beside] = [(); 2].map(|()| {
        let host = Three::new(&library, false, false);
        host.start(false);
        host
    });
    let mut abuser = ThreeAbuser::new(&library, ChaCha8Rng::seed_from_u64(20_261_122));
    let (dog, calls) = (Watchdog::new(), calls());
    let steps = among(
        calls,
        || abuser.act(&dog),
        |point| {
            beside.step(point, 1e-3);
        },
    );
    let accepted = abuser.accepted;
    abuser.clean_up();
    for step in 0..steps {
        alone.step(f64::from(step) * 1e-3, 1e-3);
    }
    let names: Vec<&str> = real_outputs().collect();
    assert_eq!(alone.fingerprint(&names), beside.fingerprint(&names));
    assert!(accepted > calls / 4 && accepted < calls * 9 / 10, "{accepted} of {calls} accepted");
}

/// Names of all real outputs.
fn real_outputs() -> impl Iterator<Item = &'static str> {
    VARIABLES.iter().filter(|v| matches!(v.role, Role::Output(_))).map(|v| v.name)
}

/// Compares runs one after the other with the same runs on a thread each.
fn alone_and_together(run: impl Fn(usize) -> Vec<u64> + Sync) {
    let (run, alone): (&(dyn Fn(usize) -> Vec<u64> + Sync), Vec<_>) =
        (&run, (0..8).map(&run).collect());
    let together: Vec<_> = thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|number| scope.spawn(move || run(number))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(alone, together);
    assert_ne!(alone[0], alone[1]);
}

#[test]
fn threads_give_bitwise_what_one_thread_gives_in_either_standard() {
    let library = Library::load();
    let stiffness = |number: usize| 1e8 + 1e7 * number as f64;
    alone_and_together(|number| {
        let host = Host::running(&library, &[("rock.stiffness", stiffness(number))]);
        (0..100).for_each(|step| host.step(f64::from(step) * 1e-3, 1e-3));
        host.fingerprint()
    });
    let names: Vec<&str> = real_outputs().collect();
    alone_and_together(|number| {
        let host = Three::new(&library, true, true);
        host.set("Float64", vr("rock.stiffness"), stiffness(number));
        host.start(true);
        host.run(0.0, 0.1, |_, event| assert!(event.is_none_or(|event| event == [1.0, 0.0])));
        host.fingerprint(&names)
    });
}

#[test]
fn too_much_work_ends_in_an_error_that_leaves_the_instance_safe() {
    let library = Library::load();
    // A contact a million times stiffer than its splines chatters when a force presses.
    let stiff = [("contact.stiffness", 1e17), ("material.damping_time", 0.0), ("work_limit", 1.0)];
    let mesh = [("piston.elements", 4.0), ("bit.elements", 4.0), ("mesh.degree", 7.0)];
    let pressed = [("drive.source", 2.0), ("drive_force", 1e4)];
    let host = Host::running(&library, &[&stiff[..], &mesh, &pressed].concat());
    host.take_log();
    let dog = Watchdog::new();
    dog.about_to("fmi2DoStep of a contact that chatters".into());
    assert_eq!(library.step(host.handle, 0.0, 1.0), ERROR);
    let line = host.only_error();
    // It chatters against the rock too; the error names the parameter that causes it.
    assert!(line.contains("contact.stiffness = 1e17 is 1.1e6 times"), "{line}");
    // Afterwards everything can be read, no step can be made, and the instance can be reset.
    for (reference, variable) in (0u32..).zip(VARIABLES.iter()) {
        let mut number = [0];
        let read = match variable.role {
            Role::Output(_) => library.get_reals(host.handle, &[reference], &mut [0.0]),
            Role::Truth(_) => library.get_ints(true, host.handle, &[reference], &mut number),
            Role::Choice(..) => library.get_ints(false, host.handle, &[reference], &mut number),
            Role::Parameter(_) | Role::Input(_) => OK,
        };
        assert_eq!(read, OK, "{}", variable.name);
    }
    for _ in 0..3 {
        assert_eq!(library.step(host.handle, 0.0, 1e-3), ERROR);
        host.only_error();
    }
    host.plain("fmi2Terminate");
    host.plain("fmi2Reset");
    host.start(0.0);
    host.step(0.0, 1e-3);
    let new = Host::running(&library, &[]);
    new.step(0.0, 1e-3);
    assert_eq!(host.fingerprint(), new.fingerprint());
}

#[test]
fn a_thousand_instances_live_side_by_side() {
    let library = Library::load();
    let hosts: Vec<Host> = (0..1000).map(|_| Host::running(&library, &[])).collect();
    let expected = {
        hosts[0].step(0.0, 0.05);
        hosts[0].fingerprint()
    };
    for host in hosts.iter().skip(1).step_by(97) {
        host.step(0.0, 0.05);
        assert_eq!(host.fingerprint(), expected);
    }
    assert!(hosts.len() < CAPACITY);
}

#[test]
fn memory_is_clean_under_valgrind() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "apt install valgrind");
        println!("skipped: valgrind is not installed");
        return;
    }
    let output = Command::new("valgrind")
        .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
        .args(["--errors-for-leak-kinds=definite", "--fair-sched=yes"])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "--test-threads=1"])
        .arg("random_calls_neither_crash_nor_hang_nor_disturb_a_neighbour")
        .envs([(CALLS, "1200"), (SLOWER, "50")])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{stderr}", output.status);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
}

/// Runs with glibc's checks of every freed block. Since 2.34 they are in a library of their own; the variable alone
/// has no effect.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn the_heap_is_whole_under_the_checks_of_glibc() {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "--test-threads=1"])
        .arg("random_calls_neither_crash_nor_hang_nor_disturb_a_neighbour")
        .envs([("LD_PRELOAD", "libc_malloc_debug.so.0"), ("MALLOC_CHECK_", "3"), (CALLS, "4000")])
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    if errors.contains("cannot be preloaded") {
        println!("skipped: this glibc is older than 2.34");
        return;
    }
    assert!(output.status.success(), "{}\n{errors}", output.status);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
}
