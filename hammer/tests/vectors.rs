//! Which vectors are used, and that no result depends on them.

use hammer::{Fidelity, Input, InputValues, Machine, Parameters, Source, Vectors};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The choice is global to the process, so tests take turns.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Vectors of this processor by the standard library's own detection, widest first.
#[cfg(target_arch = "x86_64")]
fn allowed() -> Vec<Vectors> {
    macro_rules! all {
        ($($feature:tt)*) => { [$(std::is_x86_feature_detected!($feature)),*].iter().all(|&x| x) };
    }
    let v3 = all!("avx" "avx2" "bmi1" "bmi2" "fma" "lzcnt" "popcnt");
    let v4 = v3 && all!("avx512f" "avx512bw" "avx512cd" "avx512dq" "avx512vl");
    let mut list = Vec::new();
    list.extend(v4.then_some(Vectors::Avx512));
    list.extend(v3.then_some(Vectors::Avx2));
    list.push(Vectors::Scalar);
    list
}

#[cfg(target_arch = "aarch64")]
fn allowed() -> Vec<Vectors> {
    vec![Vectors::Neon, Vectors::Scalar]
}

#[cfg(target_arch = "wasm32")]
fn allowed() -> Vec<Vectors> {
    let wide = cfg!(target_feature = "simd128").then_some(Vectors::Simd128);
    wide.into_iter().chain([Vectors::Scalar]).collect()
}

#[test]
fn the_widest_vectors_of_the_processor_are_in_use() {
    let _alone = alone();
    assert_eq!(Vectors::available().collect::<Vec<_>>(), allowed());
    assert_eq!(Vectors::in_use(), allowed()[0]);
}

#[test]
fn vectors_that_the_processor_lacks_are_refused() {
    let _alone = alone();
    for vectors in [Vectors::Avx512, Vectors::Avx2, Vectors::Neon, Vectors::Simd128] {
        if !allowed().contains(&vectors) {
            assert!(!vectors.select(), "{vectors}");
            assert_eq!(Vectors::in_use(), allowed()[0]);
        }
    }
}

/// Scenes that together use every loop: waves and rigid bodies, varying inputs, overdamped and undamped modes, and
/// meshes that do and do not fill their lanes.
fn scenes() -> Vec<(&'static str, Parameters, f64)> {
    let mut list = vec![("reference", Parameters::default(), 0.06)];
    let mut add = |name, end, change: fn(&mut Parameters)| {
        let mut p = Parameters::default();
        change(&mut p);
        list.push((name, p, end));
    };
    add("rigid", 0.06, |p| p.fidelity = Fidelity::Rigid);
    add("undamped", 0.04, |p| p.material.damping_time = 0.0);
    add("overdamped", 0.04, |p| p.material.damping_time = 1e-5);
    add("unequal", 0.04, |p| (p.piston.elements, p.bit.elements, p.bit.length) = (3, 29, 0.4));
    add("stepped splines", 0.02, |p| {
        p.mesh.degree = 4;
        p.piston.segments.set_count(3);
        p.bit.segments.set_count(2);
        (p.piston.segments[1].area, p.bit.segments[0].length) = (1.1e-3, 0.09);
    });
    add("forced", 0.06, |p| p.drive.source = Source::Force);
    list
}

/// All outputs of a run, with every bit of every number.
fn trajectory(parameters: &Parameters, end: f64) -> String {
    let inputs = InputValues { drive_force: 1500.0, ..Default::default() };
    let mut machine = Machine::new(parameters, &inputs, 0.0).expect("a scene");
    machine.keep_journal(true);
    let mut out = String::new();
    for step in 1..=6 {
        // A feed that oscillates by a fifth, with its derivatives up to the second.
        let phase = f64::from(step);
        let derivatives = [5e3 + 1e3 * phase.sin(), 1e5 * phase.cos(), -1e7 * phase.sin()];
        machine.set_input(Input::FeedForce, &derivatives).expect("an input");
        machine.advance(end * f64::from(step) / 6.0).expect("a run");
        let outputs = (*machine.kinematics(), machine.energies(), machine.peaks());
        // `Debug` of a double is the shortest text that parses to the same bits.
        out += &format!("{:?}{outputs:?}", machine.take_journal());
    }
    out + &format!("{:?}{:?}", machine.profile(), machine.state())
}

#[test]
fn every_kind_of_vectors_gives_the_same_bits_over_whole_runs() {
    let _alone = alone();
    for (name, parameters, end) in scenes() {
        let mut first: Option<(Vectors, String)> = None;
        for vectors in Vectors::available() {
            assert!(vectors.select());
            assert_eq!(Vectors::in_use(), vectors);
            let text = trajectory(&parameters, end);
            let (widest, expected) = first.get_or_insert_with(|| (vectors, text.clone()));
            assert!(text == *expected, "{name}: {vectors} differs from {widest}");
        }
        assert!(allowed()[0].select());
    }
}
