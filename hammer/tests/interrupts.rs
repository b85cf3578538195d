//! Long work of every kind ends when it is interrupted, and leaves the objects it worked on unchanged.

use hammer::Scene;
use hammer::means::{Wanted, steady};
use hammer::sensitivity::{Argument, Sample, derivatives};
use hammer::{Error, InputValues, Interrupt, Machine, Parameters, in_threads};
use std::panic::catch_unwind;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest time from the interrupt to the end of the work; at most 0.4 ms was observed. (Only a call of the dense
/// solver cannot be interrupted: 0.1 s for 400 splines.)
const PROMPT: Duration = Duration::from_millis(50);

/// Lock for tests that count questions. Another test's scenes would displace this one's systems from the cache, and
/// decomposing them again asks again.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An interrupt that counts its questions, and returns true from some time on.
struct Counted {
    interrupt: Interrupt,
    inner: Arc<Inner>,
}

struct Inner {
    asked: AtomicU64,
    from: AtomicU64,
    /// When it first returned true.
    yes: OnceLock<Instant>,
}

impl Inner {
    fn ask(&self) -> bool {
        let yes = self.asked.fetch_add(1, Relaxed) >= self.from.load(Relaxed);
        if yes {
            self.yes.get_or_init(Instant::now);
        }
        yes
    }
}

impl Counted {
    fn new(from: u64) -> Self {
        let (asked, from) = (AtomicU64::new(0), AtomicU64::new(from));
        let inner = Arc::new(Inner { asked, from, yes: OnceLock::new() });
        let asked = inner.clone();
        Self { interrupt: Interrupt::asking(move || asked.ask()), inner }
    }

    fn never() -> Self {
        Self::new(u64::MAX)
    }

    fn asked(&self) -> u64 {
        self.inner.asked.load(Relaxed)
    }

    /// Makes it return false until it has been asked so many more times.
    fn lets_go_on(&self, more: u64) {
        self.interrupt.clear();
        self.inner.from.store(self.asked().saturating_add(more), Relaxed);
    }

    /// True if it has just returned true.
    fn was_prompt(&self) -> bool {
        self.inner.yes.get().is_some_and(|when| when.elapsed() < PROMPT)
    }
}

/// After the first blow, s; before it the piston falls freely for 10 ms.
const END: f64 = 0.0145;

/// No other test shares its systems, since each has its own bodies.
fn scene(elements: usize, tenths: u32) -> Parameters {
    let mut p = Parameters::default();
    (p.piston.elements, p.bit.elements) = (elements, elements);
    for length in [&mut p.piston.length, &mut p.bit.length] {
        *length *= 1.0 + 1e-3 * f64::from(tenths);
    }
    p
}

fn machine(p: &Parameters) -> Result<Machine, Error> {
    Machine::new(p, &InputValues::default(), 0.0)
}

/// Decomposing a system of `N` modes takes 2 N roots, each in at least two steps (one that moves, one that does not),
/// half of them conjugates without steps, and then N blocks. The question is asked before each, so that `O(N)` work
/// lies between two questions: with 802 modes a second in all, and less than a millisecond each.
#[test]
fn a_decomposition_asks_before_every_root_and_every_block() {
    let _alone = alone();
    let p = scene(400, 1);
    let counted = Counted::never();
    let mut m = counted.interrupt.watch(|| machine(&p)).expect("a scene");
    let made = counted.asked();
    assert!(made >= 401 * (2 + 2 + 1), "bit and piston: {made}");
    m.advance(0.01).expect("a fall");
    let before = counted.asked();
    counted.interrupt.watch(|| m.advance(END)).expect("a blow");
    let blow = counted.asked() - before;
    assert!(m.counters().contacts > 0 && blow >= 802 * (2 + 2 + 1), "the bodies together: {blow}");
}

/// Interrupted at about every hundredth question, from making the scene through its first blows: the step ends, and
/// what follows is the uninterrupted motion, bit for bit.
#[test]
fn a_scene_of_400_elements_can_be_cancelled_wherever_it_is() {
    let _alone = alone();
    let p = scene(400, 2);
    let counted = Counted::new(100);
    let mut cancelled = 0;
    let made = loop {
        match counted.interrupt.watch(|| machine(&p)) {
            Ok(made) => break made,
            Err(error) => assert_eq!(error, Error::Cancelled),
        }
        assert!(counted.interrupt.is_set());
        cancelled += 1;
        // Later each time, since unfinished work is done again.
        counted.lets_go_on(100 << cancelled);
    };
    assert!(cancelled > 2, "{cancelled}");
    let (mut m, mut cancelled) = (made, 0);
    counted.lets_go_on(50);
    while m.time() < END {
        match counted.interrupt.watch(|| m.advance(END)) {
            Ok(()) => (),
            Err(error) => assert_eq!(error, Error::Cancelled),
        }
        cancelled += 1;
        counted.lets_go_on(50 << (cancelled % 12));
    }
    assert!(cancelled > 5, "{cancelled}");
    let mut other = machine(&p).expect("a scene");
    other.advance(END).expect("a run");
    assert!(other.counters().contacts > 0, "a blow");
    assert_eq!(m.state().without_step(), other.state().without_step());
    assert_eq!(m.energies(), other.energies());
}

/// For each joint, the modes of the joined rods ask one by one, before their system's roots.
#[test]
fn the_making_of_a_loose_string_can_be_cancelled() {
    let _alone = alone();
    let loose = |tenths| {
        let mut p = scene(200, tenths);
        (p.mesh.degree, p.drill.rods, p.drill.joint.stiffness) = (3, 3, 3e9);
        p
    };
    let counted = Counted::never();
    counted.interrupt.watch(|| machine(&loose(3))).expect("a scene");
    let made = counted.asked();
    assert!(made >= 201 * (3 + 2 + 2 + 1), "three joints: {made}");
    for part in 1..8 {
        let counted = Counted::new(made * part / 8);
        let cancelled = counted.interrupt.watch(|| machine(&loose(3 + part as u32)));
        assert_eq!(cancelled.expect_err("no scene"), Error::Cancelled);
        assert!(counted.was_prompt(), "{part}");
    }
}

/// The damping form of `N` modes asks before each of its 2 N / 16 strips of products and each of its N rows.
#[test]
fn what_takes_long_of_reading_an_energy_can_be_cancelled_and_done_again() {
    let _alone = alone();
    let p = scene(400, 5);
    let blown = || {
        let mut m = machine(&p).expect("a scene");
        m.advance(END).expect("a blow");
        assert!(m.counters().contacts > 0);
        m
    };
    let (m, counted) = (blown(), Counted::new(100));
    let mut cancelled = 0;
    while let Err(error) = counted.interrupt.watch(|| m.prepare_ledger()) {
        assert_eq!(error, Error::Cancelled);
        cancelled += 1;
        counted.lets_go_on(100 << cancelled);
    }
    assert!(cancelled > 2 && counted.asked() > 802, "{cancelled}, {}", counted.asked());
    assert_eq!(m.energies(), blown().energies());
}

#[test]
fn derivatives_and_long_run_responses_end_when_they_are_interrupted() {
    let _alone = alone();
    let scene = Scene { parameters: scene(10, 3), ..Scene::default() };
    let by = ["feed_force", "rock.stiffness"].map(|name| Argument::named(name).expect("a number"));
    let read = |m: &mut Machine| vec![m.kinematics().gap.displacement];
    let run = |at: &Scene| Sample::of_run(&mut at.machine()?, &[0.5], &read);
    let differentiate = || derivatives(&scene, &by, &run).map(|_| ());
    let respond = || steady(&scene, &Wanted::default(), &mut |_, _| true).map(|_| ());
    for work in [&differentiate as &dyn Fn() -> Result<(), Error>, &respond] {
        // The scene's systems are made once and then cached.
        work().expect("a result");
        let all = Counted::never();
        all.interrupt.watch(work).expect("a result");
        assert!(all.asked() >= 50, "{}", all.asked());
        for part in [50, 20, 10, 3, 2] {
            let some = Counted::new(all.asked() / part);
            some.interrupt.watch(work).expect_err("interrupted");
            assert!(some.was_prompt());
        }
    }
}

/// As with Python's signals: only its main thread handles them, and it is waiting meanwhile.
#[test]
fn what_other_threads_do_ends_when_the_thread_that_waits_for_them_hears_so() {
    let _alone = alone();
    let own = thread::current().id();
    let begun = Arc::new(AtomicU64::new(0));
    let known = begun.clone();
    let interrupt =
        Interrupt::asking(move || thread::current().id() == own && known.load(Relaxed) > 0);
    let work = |_| {
        begun.fetch_add(1, Relaxed);
        // It would take some seconds.
        machine(&Parameters::default())?.advance(100.0)
    };
    let found = interrupt.watch(|| in_threads(vec![(); 3], 2, work));
    assert_eq!(found, [const { Err(Error::Cancelled) }; 3], "the last one as it begins");
}

#[test]
fn parts_for_threads_are_answered_in_their_order_and_a_panic_goes_on() {
    for threads in [0, 1, 3, 8] {
        let found = in_threads((0..5).collect(), threads, |k: u64| 10 * k);
        assert_eq!(found, [0, 10, 20, 30, 40], "{threads} threads");
        let falls = || in_threads((0..5).collect(), threads, |k: u64| assert_ne!(k, 3));
        assert!(catch_unwind(falls).is_err(), "{threads} threads");
    }
}

#[test]
fn who_does_not_listen_is_not_interrupted() {
    let _alone = alone();
    let (outer, inner) = (Interrupt::default(), Interrupt::default());
    outer.set();
    let mut m = machine(&scene(2, 4)).expect("a scene");
    let step = |m: &mut Machine| m.advance(m.time() + 1e-3);
    outer.watch(|| {
        assert_eq!(step(&mut m), Err(Error::Cancelled));
        inner.watch(|| step(&mut m)).expect("the inner one alone counts");
        assert_eq!(step(&mut m), Err(Error::Cancelled), "the outer one again");
    });
    step(&mut m).expect("none counts");
}
